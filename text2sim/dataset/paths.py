"""Paths in a case, and the group of draws that each belongs to: physics, looks, lights or cameras."""

from text2sim.spec_schema.paths import dotted, parse_dotted
from text2sim.spec_schema.text.document import Path, parse_pointer

LOOKS = ("background", "backdrop", "tone")
"""Keys of `render` that belong to neither lights nor cameras."""
LIGHTS = ("lights", "exposure")


def parse_path(text: str) -> Path:
    """Return the steps of `bodies.ball.pose.pos[2]` or `/bodies/ball/pose/pos/2`.

    Raises:
        ValueError: if it is neither.
    """
    if not text.startswith("/"):
        return parse_dotted(text)
    path = tuple(int(step) if isinstance(step, str) and step.isdigit() else step for step in parse_pointer(text))
    return parse_dotted(dotted(path))


def in_section(path: Path, group: str) -> str | None:
    """Return why a path does not belong to `physics`, `looks`, `lights` or `cameras`; None if it does."""
    steps = [str(step) for step in path]
    film = steps[0] == "render"
    if group == "physics":
        return "changes the film: draw it under `looks`, `lights` or `cameras`" if film or "look" in steps else None
    inner = steps[1] if film and len(steps) > 1 else ""
    if group == "looks":
        ok, wanted = "look" in steps or inner in LOOKS, f"a `look`, or render.{', render.'.join(LOOKS)}"
    elif group == "lights":
        ok, wanted = inner in LIGHTS, f"a path that begins with render.{' or render.'.join(LIGHTS)}"
    else:
        ok, wanted = inner == group, f"a path that begins with render.{group}"
    return None if ok else f"does not belong to {group}, which takes {wanted}"
