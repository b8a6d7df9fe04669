"""Stand-ins for the bodies of a plan, whose shapes, sizes and places are not known yet."""

import json
import re
from functools import cache
from typing import Any, NamedTuple

from text2sim.agents.language import body_kinds, shape_kinds
from text2sim.agents.replies import CasePlan, Fragments, PlannedBody
from text2sim.spec_schema.models.placed import Placed
from text2sim.spec_schema.names.selectors import named_by, strings_in
from text2sim.spec_schema.text.canonical import format_text
from text2sim.spec_schema.text.source import Source

Data = dict[str, Any]
_PART = re.compile(r"(\w+)(?:\[[\d:*]+\])?\.([\w*]+)")


class Arrangement(NamedTuple):
    """Sizes and places of stand-ins."""

    size: float
    """Length of their sides [m]."""
    start: tuple[float, float, float]
    """Position before that of the first [m]."""
    step: tuple[float, float, float]
    """Way from one to the next [m]."""


ARRANGEMENTS = (
    Arrangement(0.01, (0.0, 0.0, 40.0), (50.0, 0.0, 0.0)),
    Arrangement(0.4, (0.0, -30.0, -40.0), (-7.0, -3.0, -11.0)),
    Arrangement(0.2, (0.0, 0.0, 1.0), (0.001, 0.0, 0.0)),
)
"""Far apart at one height; far apart, elsewhere and at other heights; all in one place."""


def rehearsal_text(plan: CasePlan, checks: Fragments, arrangement: Arrangement, *, loose: bool = False) -> str:
    """Return a plan as a case of stand-ins.

    Args:
        plan: The plan.
        checks: Its measures, events and expectations, or some of them.
        arrangement: Sizes and places of the stand-ins.
        loose: Whether no body has a joint, so that joint limits imply nothing.
    """
    statics, bodies = {"ground": {"shape": {"kind": "plane"}}}, {}
    for k, (name, body) in enumerate(plan.bodies.items()):
        parts = _named_parts(checks, name)
        data = _stand_in(body, parts, k, arrangement, loose)
        (statics if body.kind == "static" else bodies)[name] = data
    if not bodies:
        bodies["stand_in"] = {"kind": "rigid", "shape": {"kind": "sphere", "radius": 0.1}}
    actions = {part: getattr(checks, part) for part in ("measures", "events", "expect") if getattr(checks, part)}
    document = {"text2sim": 2, "name": "rehearsal", "params": plan.params}
    document |= {"scene": {"duration": plan.duration, "statics": statics}, "bodies": bodies, "actions": actions}
    return format_text(json.dumps(document, ensure_ascii=False))


def _stand_in(body: PlannedBody, parts: list[str], k: int, arrangement: Arrangement, loose: bool) -> Data:
    size, start, step = arrangement
    place: Data = {"pose": {"pos": [at + way * (k + 1) for at, way in zip(start, step, strict=True)]}}
    box = {"kind": "box", "size": [size, size, size]}
    shape = {"kind": "compound", "parts": {part: {"shape": box} for part in parts}} if parts else box
    if body.count > 1:
        place["repeat"] = {"kind": "line", "count": body.count, "step": [3 * size, 0, 0]}
    used = body.kind if body.kind not in body_kinds() else ""
    if body.kind == "static":
        if body.shape == "plane":
            return {"shape": {"kind": "plane"}}
        used = body.shape if body.shape in prefab_arguments() and body.shape not in shape_kinds() else ""
        if not used:
            return {"shape": shape, **place}
    if used:
        return {"use": used, **prefab_arguments()[used], **place}
    if body.kind == "rigid":
        mount = {"kind": body.mount or "free"}
        if mount["kind"] in ("hinge", "slider"):
            mount |= _joint(mount["kind"])
        return {"kind": "rigid", "shape": shape, **place, **({} if loose else {"mount": mount})}
    if body.kind == "articulated":
        joint = {"kind": "hinge", **_joint("hinge")}
        links: Data = {"root_of_it": {"shape": box}}
        links |= {part: {"parent": "root_of_it", "shape": box, "joint": joint} for part in parts}
        return {"kind": "articulated", "links": links, **place, **({"base": "free"} if loose else {})}
    return {**_example(body.kind), **place}


def _joint(kind: str) -> Data:
    reach = {"range_deg": [-170, 170]} if kind == "hinge" else {"range": [-10, 10]}
    return {"axis": "z", **reach, "actuator": {"stiffness": 10, "damping": 1}}


@cache
def _example(kind: str) -> Data:
    """The body in the reference's example of a kind, without its placement."""
    from text2sim.spec_schema.published.language_reference import load_examples
    from text2sim.spec_schema.text.document import parse_document

    body = next(iter(parse_document(Source(load_examples()["bodies"][kind], "example")).data.values()))
    return {key: value for key, value in body.items() if key not in Placed.model_fields}


@cache
def prefab_arguments() -> dict[str, Data]:
    """Return the required arguments of each prefab."""
    from text2sim.spec_schema.reuse.catalogue import examples
    from text2sim.spec_schema.text.document import parse_document

    found: dict[str, Data] = {}
    for name, example in examples().items():
        data = parse_document(Source(example, "example")).data
        uses = [*(data.get("bodies") or {}).values(), *((data.get("scene") or {}).get("statics") or {}).values()]
        found[name] = next(({"with": row["with"]} for row in uses if row.get("use") == name and "with" in row), {})
    return found


def _named_parts(checks: Fragments, body: str) -> list[str]:
    """Links, joints and parts of a body that the checks name and its Writer will define."""
    words = [*strings_in(checks.measures), *strings_in(checks.events)]
    found = [match for word in words if (match := _PART.fullmatch(word)) is not None and match[1] == body]
    parts = dict.fromkeys(match[2] for match in found if "*" not in match[2])
    for match in found:
        if not named_by(match[2], parts):  # a pattern needs at least one part that it matches
            parts[match[2].replace("*", "a")] = None
    return list(parts)
