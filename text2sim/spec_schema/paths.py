"""Dotted paths: `bodies.ball.material.density`, `bodies.ball.pose.pos[2]`."""

import re

from text2sim.spec_schema.text.document import Path, Step

_STEP = re.compile(r"([^.\[\]]+)((?:\[\d{1,6}\])*)")
MAX_LENGTH = 500


def dotted(path: Path) -> str:
    """Return the text of a path, with indices in brackets."""
    text = ""
    for step in path:
        text += f"[{step}]" if isinstance(step, int) else f".{step}" if text else str(step)
    return text


def parse_dotted(text: str) -> Path:
    """Return the path of a text.

    Raises:
        ValueError: If it is not a dotted path.
    """
    steps: list[Step] = []
    for part in text.split("."):
        found = _STEP.fullmatch(part)
        if found is None or len(text) > MAX_LENGTH:
            raise ValueError("a path has the form bodies.ball.material.density or bodies.ball.pose.pos[2]")
        steps.append(found[1])
        steps += [int(index) for index in re.findall(r"\d+", found[2])]
    return tuple(steps)
