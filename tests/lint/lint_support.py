"""What the tests of the lint share: a case from parts, and what the lint says about it."""

import json
from pathlib import Path
from typing import Any

from text2sim.compiler.build import resolve_case
from text2sim.lint import LintReport, lint_case
from text2sim.lint.rules import EXAMPLE_BASE
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.text.document import parse_document
from text2sim.spec_schema.text.source import Source


def merged(base: Any, overlay: Any) -> Any:
    """JSON Merge Patch (RFC 7396)."""
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
    """Parts of a case, laid over `EXAMPLE_BASE` one after the other, as data."""
    data: Any = {}
    for part in (EXAMPLE_BASE, *parts):
        data = merged(data, parse_document(Source(part, "part.yaml")).data)
    return data


def report_on(folder: Path, *parts: str) -> LintReport:
    """What the lint says about parts of a case in a folder."""
    return lint_case(resolve_case(load_text(json.dumps(data_of(*parts), indent=1), folder / "case.yaml")))


def findings(folder: Path, rule: str, *parts: str) -> list[Problem]:
    """What one rule finds."""
    return [problem for problem in report_on(folder, *parts).problems if problem.rule == rule]
