"""Every rule: its example breaks it, the fixed example does not, and it is documented."""

import ast
import re
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages

import pytest
from freshness import assert_fresh
from lint_support import data_of, findings, report_on

import text2sim.lint
from text2sim.compiler.build import resolve_case
from text2sim.lint import lint_case
from text2sim.lint.reference import lint_reference
from text2sim.lint.rules import EARLIER_RULES, RULES, Rule, find_rule
from text2sim.spec_schema.load import load_case, load_text

every_rule = pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.id)


@every_rule
def test_an_example_breaks_its_rule(rule: Rule, assets: Path) -> None:
    found = findings(assets, rule.id, rule.example)
    assert found
    assert rule.severity in {problem.severity for problem in found}


@every_rule
def test_a_mended_example_keeps_its_rule(rule: Rule, assets: Path) -> None:
    assert findings(assets, rule.id, rule.example, rule.fix) == []


@every_rule
def test_a_finding_stands_at_something_that_the_case_says(rule: Rule, assets: Path) -> None:
    said = data_of(rule.example)
    for problem in findings(assets, rule.id, rule.example):
        value = said
        for step in problem.path.split("/")[1:]:
            value = value[int(step)] if isinstance(value, list) else value[step]


@every_rule
def test_a_finding_can_be_waived(rule: Rule, assets: Path) -> None:
    report = report_on(assets, rule.example)
    waiver = f"waive: {{{rule.id}: this is what the test is about}}"
    waived = report_on(assets, rule.example, waiver)
    assert [one.problem.message for one in waived.waived] == [p.message for p in report.problems if p.rule == rule.id]
    assert rule.id not in {problem.rule for problem in waived.problems}


@every_rule
def test_a_row_says_everything(rule: Rule) -> None:
    assert re.fullmatch(r"[a-z]+(-[a-z]+)*", rule.id)
    assert rule.title.endswith(".")
    assert "\n" not in rule.title
    assert len(rule.reason) > 40
    assert len(rule.remedy) > 10


def test_ids_are_unique() -> None:
    ids = [*(rule.id for rule in RULES), *EARLIER_RULES]
    assert len(set(ids)) == len(ids)
    assert find_rule("no such rule") is None


def test_every_module_of_rules_is_registered() -> None:
    for module in walk_packages(text2sim.lint.__path__, "text2sim.lint."):
        rows = getattr(import_module(module.name), "RULES", ())
        assert set(rows) <= set(RULES), f"add the RULES of {module.name} to lint/rules.py"


def test_no_other_check_uses_the_id_of_a_rule() -> None:
    """Otherwise a waiver of a lint rule could hide an error in the form of a document."""
    package = Path(__file__).resolve().parents[2] / "text2sim"
    ids = {rule.id for rule in RULES}
    said = {
        node.value
        for folder in ("spec_schema", "compiler", "assets")
        for file in (package / folder).rglob("*.py")
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    }
    assert not ids & said


def test_the_page_is_fresh() -> None:
    page = Path(__file__).resolve().parents[2] / "docs" / "lint.md"
    assert_fresh(page, lint_reference(), "python -m text2sim.lint.reference > docs/lint.md")


def test_the_repositorys_cases_are_clean(cases: Path) -> None:
    found = {}
    for path in sorted(cases.iterdir()):
        if (path / "case.yaml").is_file():
            found[path.name] = [str(problem) for problem in lint_case(resolve_case(load_case(path))).problems]
    assert len(found) >= 8
    assert {name: problems for name, problems in found.items() if problems} == {}


def test_a_case_with_nothing_in_it_is_fine() -> None:
    text = "text2sim: 1\nname: a\nscene: {duration: 1}\nbodies: {b: {kind: ragdoll, height: 1, place: {on: c}}, c: {kind: rigid, shape: {kind: box, size: [1, 1, 1]}, mount: {kind: fixed}}}\n"
    assert lint_case(resolve_case(load_text(text))).ok
