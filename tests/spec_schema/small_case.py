"""A small valid case with holes to fill, and shorthands for what is wrong with it."""

from pathlib import Path
from typing import Any

from text2sim.spec_schema.errors import Problem, SpecError
from text2sim.spec_schema.load import load_text

_TEXT = """\
text2sim: 1
name: small
{top}
scene: {{duration: 1{scene}}}
bodies:
  ball: {{kind: rigid, shape: {{kind: sphere, radius: {radius}}}{ball}}}
"""


def small(*, top: str = "", scene: str = "", radius: str = "0.1", ball: str = "") -> str:
    """Text of a small case."""
    return _TEXT.format(top=top, scene=scene, radius=radius, ball=ball)


def problems_of(text: str, path: Path | str = "case.yaml", **options: Any) -> list[Problem]:
    """Everything that is wrong with the form of a case."""
    try:
        load_text(text, path, **options)
    except SpecError as error:
        return error.problems
    return []


def only_problem(text: str, path: Path | str = "case.yaml") -> Problem:
    """The one thing that is wrong with the form of a case."""
    found = problems_of(text, path)
    assert len(found) == 1, found
    return found[0]
