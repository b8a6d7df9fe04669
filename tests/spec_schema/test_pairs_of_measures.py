"""Differences and ratios of other differences and ratios."""

from typing import Any

import pytest

from text2sim.spec_schema.names.references import check_references

MEASURES = "/actions/measures"


def pair(kind: str, *measures: str) -> dict[str, Any]:
    return {"kind": kind, "measures": list(measures)}


def chain(count: int) -> dict[str, Any]:
    names = [*(f"m{k}" for k in range(count)), "height"]
    return {f"{MEASURES}/{one}": pair("ratio", after, "height") for one, after in zip(names, names[1:], strict=False)}


@pytest.mark.parametrize(
    ("edits", "wrong"),
    [
        ({f"{MEASURES}/it": pair("ratio", "it", "height")}, {"it": "`it` is worked out from itself"}),
        (
            {f"{MEASURES}/a": pair("ratio", "b", "height"), f"{MEASURES}/b": pair("ratio", "height", "a")},
            {name: f"`{name}` is worked out from itself" for name in "ab"},
        ),
        (chain(6), {}),
        (chain(7), {"m0": "differences and ratios of each other are nested more than 6 deep"}),
        (
            {
                f"{MEASURES}/rate": pair("ratio", "ball_speed", "height"),
                f"{MEASURES}/d": pair("difference", "rate", "height"),
            },
            {"d": "`rate` is in m/s/m and `height` in m: a difference needs equal units; use a `ratio`"},
        ),
        (
            {
                f"{MEASURES}/gap": pair("difference", "height", "height"),
                f"{MEASURES}/d": pair("difference", "gap", "height"),
            },
            {},
        ),
    ],
)
def test_pairs_are_measures_of_pairs(stage: Any, edits: dict[str, Any], wrong: dict[str, str]) -> None:
    problems = check_references(stage(edits))
    assert {problem.path.rsplit("/", 2)[1]: problem.message for problem in problems} == wrong
