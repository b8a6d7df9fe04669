"""Names that are never used, usually because of a typing error or an edit."""

import re
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.spec_schema.errors import Problem

OPEN, CLOSE = "${", "}"


def _mappings_and_texts(value: Any) -> Iterator[Any]:
    """Yield every mapping and text inside some data."""
    waiting = [value]
    while waiting:
        item = waiting.pop()
        if isinstance(item, dict | str):
            yield item
        if isinstance(item, dict | list):
            waiting += item.values() if isinstance(item, dict) else item


def _words_in(text: str) -> set[str]:
    """Return all words in the expressions of a text, including its names, without parsing."""
    return {word for part in text.split(OPEN)[1:] for word in re.findall(r"\w+", part.partition(CLOSE)[0])}


def _params(facts: Facts) -> Iterator[Problem]:
    given = facts.value_at(("params",)) or {}
    if not given:
        return
    # A prefab knows its own parameters, but not those of the case. Variants are only in the file.
    sections = [value for key, value in facts.loaded.written.data.items() if key != "prefabs"]
    parts = (part for data in (sections, facts.loaded.raw) for part in _mappings_and_texts(data))
    texts = {part for part in parts if isinstance(part, str) and OPEN in part}
    used = {word for text in texts for word in _words_in(text)}
    for name in given:
        if name not in used:
            text = f"no expression uses the parameter `{name}`; use it as ${{{name}}}, or leave it out"
            yield facts.problem("unused-param", ("params", name), text, key=True)


def _prefabs(facts: Facts) -> Iterator[Problem]:
    written = facts.loaded.written
    prefabs = written.data.get("prefabs")
    if not isinstance(prefabs, dict):
        return
    used = [part.get("use") for part in _mappings_and_texts(written.data) if isinstance(part, dict)]
    for name in prefabs:
        if name not in used:
            text = f"nothing uses the prefab `{name}`; use it in a body as `use: {name}`, or leave it out"
            problem = facts.problem("unused-prefab", ("prefabs", name), text, key=True)
            # The expanded case has no prefabs, so the position is that in the file.
            line, column = written.place(("prefabs", name), key=True)
            yield replace(problem, line=line, column=column)


_BALL = """\
params: {radius: 0.1, height: 2.0}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: "${radius}"}, pose: {pos: [0, 0, %s]}}
"""

RULES = (
    Rule(
        id="unused-param",
        title="A parameter that no expression uses.",
        reason="""\
A parameter changes nothing by itself. One that no `${…}` uses is misspelt, or a leftover: a sweep over it would run the
same case again and again.""",
        remedy="Use it, or leave it out.",
        example=_BALL % "2.0",
        fix=_BALL % '"${height}"',
        run=_params,
    ),
    Rule(
        id="unused-prefab",
        title="A prefab of the case that no body uses.",
        reason="""\
The section `prefabs` defines bodies that exist only where a body has `use`. One that nothing uses is misspelt, or a
leftover.""",
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
