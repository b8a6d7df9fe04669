"""Helpers for the tests of the lint: cases made of parts, their facts, and the problems that rules report."""

import json
from pathlib import Path
from typing import Any

from text2sim.compiler.build import resolve_case
from text2sim.lint import LintReport, lint_case
from text2sim.lint.facts import Facts
from text2sim.lint.rules import EXAMPLE_BASE
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.text.document import parse_document
from text2sim.spec_schema.text.source import Source


def merged(base: Any, overlay: Any) -> Any:
    """Return data with a JSON Merge Patch (RFC 7396) applied."""
    if not isinstance(overlay, dict):
        return overlay
    found = dict(base) if isinstance(base, dict) else {}
    for key, value in overlay.items():
        if value is None:
            found.pop(key, None)
        else:
            found[key] = merged(found.get(key), value)
    return found


def data_of(*parts: str) -> Any:
    """Return `EXAMPLE_BASE` with parts of a case applied to it as merge patches, one after the other."""
    data: Any = {}
    for part in (EXAMPLE_BASE, *parts):
        data = merged(data, parse_document(Source(part, "part.yaml")).data)
    return data


def facts_of(*parts: str, folder: Path = Path()) -> Facts:
    """Return the facts of a case made of parts, in a folder."""
    return Facts(resolve_case(load_text(json.dumps(data_of(*parts), indent=1), folder / "case.yaml")))


def report_on(folder: Path, *parts: str) -> LintReport:
    """Return the report of the lint on a case made of parts."""
    return lint_case(facts_of(*parts, folder=folder).resolution)


def findings(folder: Path, rule: str, *parts: str) -> list[Problem]:
    """Return the problems that one rule reports in a case made of parts."""
    return [problem for problem in report_on(folder, *parts).problems if problem.rule == rule]


def expect_words(folder: Path, rule: str, words: str, *parts: str, path: str | None = None) -> None:
    """Assert that a rule reports problems with these words, at this path if one is given; none if there are no words."""
    found = findings(folder, rule, *parts)
    assert bool(found) == bool(words), found
    assert all(words in problem.message and path in (None, problem.path) for problem in found)
