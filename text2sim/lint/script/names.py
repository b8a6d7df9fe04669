"""Names that are given and never used: most often a typing error, or what an edit left behind."""

import re
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.spec_schema.errors import Problem

OPEN, CLOSE = "${", "}"


def _written(facts: Facts) -> dict[str, Any]:
    """The case as it stands in its file: what prefabs and variants say is in it."""
    data = facts.loaded.written.data
    return data if isinstance(data, dict) else {}


def _texts(value: Any) -> Iterator[str]:
    """Every text inside some data."""
    waiting = [value]
    while waiting:
        one = waiting.pop()
        if isinstance(one, str):
            yield one
        elif isinstance(one, dict | list):
            waiting += one.values() if isinstance(one, dict) else one


def _names(text: str) -> set[str]:
    """All words in the expressions of a text, its names among them; to parse thousands again would take a second."""
    return {word for part in text.split(OPEN)[1:] for word in re.findall(r"\w+", part.partition(CLOSE)[0])}


def _params(facts: Facts) -> Iterator[Problem]:
    given = facts.raw(("params",)) or {}
    if not given:
        return
    written = _written(facts)
    # A prefab knows its own parameters, and nothing of the case.
    sections = [value for key, value in written.items() if key != "prefabs"]
    used: set[str] = set()
    for text in {text for data in (sections, facts.loaded.raw) for text in _texts(data) if OPEN in text}:
        used |= _names(text)
    for name in given:
        if name not in used:
            text = f"no expression uses the parameter `{name}`; use it as ${{{name}}}, or leave it out"
            yield facts.problem("unused-param", ("params", name), text, key=True)


def _prefabs(facts: Facts) -> Iterator[Problem]:
    written = _written(facts)
    prefabs = written.get("prefabs")
    if not isinstance(prefabs, dict):
        return
    used: set[Any] = set()
    waiting: list[Any] = [written]
    while waiting:
        value = waiting.pop()
        if isinstance(value, dict):
            used |= {value["use"]} if isinstance(value.get("use"), str) else set()
            waiting += value.values()
        elif isinstance(value, list):
            waiting += value
    for name in prefabs:
        if name not in used:
            text = f"nothing uses the prefab `{name}`: a body would by `use: {name}`; or leave it out"
            problem = facts.problem("unused-prefab", ("prefabs", name), text, key=True)
            # The expanded case has no prefabs any more: their places are those in the file.
            line, column = facts.loaded.written.place(("prefabs", name), key=True)
            yield replace(problem, line=line, column=column)


_BALL = """\
params: {radius: 0.1, height: 2.0}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: "${radius}"}, pose: {pos: [0, 0, %s]}}
"""

RULES = (
    Rule(
        id="unused-param",
        severity="warning",
        title="A parameter that no expression uses.",
        reason="""\
A parameter changes nothing by itself. One that no `${…}` names is misspelt in one of the two places, or was left
behind: a sweep over it would run the same case again and again.""",
        remedy="Use it, or leave it out.",
        example=_BALL % "2.0",
        fix=_BALL % '"${height}"',
        run=_params,
    ),
    Rule(
        id="unused-prefab",
        severity="warning",
        title="A prefab of the case that no body uses.",
        reason="""\
The section `prefabs` describes bodies that are there only where a body says `use`. One that nothing names is misspelt
in one of the two places, or was left behind.""",
        remedy="Use it, or leave it out.",
        example="""\
prefabs:
  cube: {params: {}, body: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}}}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 0.5]}}
""",
        fix="bodies: {ball: null, block: {use: cube, pose: {pos: [0, 0, 0.5]}}}",
        run=_prefabs,
    ),
)
