"""Subjects of a case: the bodies that its script names, with their visible parts."""

import re
from collections.abc import Iterator
from typing import Any

from text2sim.compiler.shapes.rotation import Vec
from text2sim.lint.facts import Facts, once_per_case

Balls = list[tuple[Vec, float]]
"""Centres and radii [m]."""

_NAME = re.compile(r"[A-Za-z]\w*")
NAMING_KEYS = {
    *("body", "joint", "of", "by", "between", "from", "to"),
    *("measure", "measures", "event", "before", "after", "on", "attach"),
}
"""Keys under which the script names bodies, or measures, events and controls that name them."""


@once_per_case
def subjects(facts: Facts) -> list[str]:
    """Return the bodies that expectations are about, or that a control acts on, in the order of the case."""
    actions = facts.value_at(("actions",)) or {}
    expect = actions.get("expect") or {}
    waiting: list[Any] = [*expect.values(), *(actions.get("controls") or {}).values()]
    named: set[str] = set()
    known = {**(actions.get("measures") or {}), **(actions.get("events") or {})}
    while waiting:
        for name in _names(waiting.pop()):
            if name in known:
                waiting.append(known.pop(name))
            named.add(name)
    return [name for name in facts.case.bodies if name in named]


def _names(value: Any, key: str = "") -> Iterator[str]:
    if isinstance(value, dict):
        for inner, item in value.items():
            yield from _names(item, inner)
    elif isinstance(value, list):
        for item in value:
            yield from _names(item, key)
    elif isinstance(value, str) and key in NAMING_KEYS and (found := _NAME.match(value)):
        yield found[0]


def drawn(facts: Facts, name: str) -> Balls:
    """Return balls around the visible parts of a body."""
    found: Balls = []
    for copy in facts.placed[name]:
        look = getattr(copy.model, "look", None)
        if look is None or (look.visible and look.opacity > 0):
            found += facts.balls(copy)
    return found


def center_of(balls: Balls) -> Vec:
    """Return the mean of the centres of balls."""
    x, y, z = (sum(axis) / len(balls) for axis in zip(*(center for center, _ in balls), strict=True))
    return x, y, z
