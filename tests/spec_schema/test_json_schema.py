"""The published JSON Schema is fresh, and takes what the language takes."""

import json
from pathlib import Path

import jsonschema
import pytest
from freshness import assert_fresh
from small_case import problems_of, small
from staged import edits_of

from text2sim import spec_schema
from text2sim.compiler.build import resolve_case
from text2sim.lint import lint_case
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.models.shapes import Box, Sphere
from text2sim.spec_schema.names.references import check_references
from text2sim.spec_schema.published.json_schema import build_schema, schema_text
from text2sim.spec_schema.published.language_reference import field_rows, language_reference, load_examples

ROOT = Path(spec_schema.__file__).parents[2]


@pytest.fixture(scope="module")
def validator():
    schema = build_schema()
    jsonschema.Draft7Validator.check_schema(schema)
    return jsonschema.Draft7Validator(schema)


def test_the_schema_is_fresh():
    committed = Path(spec_schema.__file__).with_name("case.schema.json")
    assert_fresh(committed, schema_text(), "text2sim schema -o text2sim/spec_schema/case.schema.json")


def test_the_reference_is_fresh():
    command = "python -m text2sim.spec_schema.published.language_reference > docs/language.md"
    assert_fresh(ROOT / "docs/language.md", language_reference(), command)


def test_a_valid_case_is_valid(validator, stage):
    loaded = stage()
    validator.validate(loaded.raw)
    validator.validate(loaded.data)


@pytest.mark.parametrize(
    "edit",
    [
        {"/bodies/ball/shape/radius": -1},
        {"/bodies/ball/shape/radius": True},
        {"/bodies/ball/shape/radius": "big"},
        {"/bodies/ball/shape/height": 1},
        {"/bodies/ball/shape/kind": "shpere"},
        {"/bodies/ball/pose/pos": [0, 0]},
        {"/bodies/9b": {"kind": "ragdoll", "height": 1}},
        {"/scene/duration": None},
        {"/render/cameras/main/look_at": "a b"},
    ],
)
def test_what_is_wrong_is_wrong(validator, stage, edit):
    loaded = stage()
    data = json.loads(json.dumps(loaded.raw))
    ((where, value),) = edit.items()
    *way, last = where.strip("/").split("/")
    target = data
    for step in way:
        target = target[step]
    if value is None:
        del target[last]
    else:
        target[last] = value
    assert not validator.is_valid(data)


EXAMPLES = [(section, kind) for section, kinds in load_examples().items() for kind in kinds]


@pytest.mark.parametrize(("section", "kind"), EXAMPLES)
def test_every_example_is_valid(validator, stage, section, kind):
    edits = edits_of(section, kind)
    loaded = stage(edits)
    assert check_references(loaded) == []
    validator.validate(loaded.raw)


@pytest.mark.parametrize("section", ["measures", "events"])
def test_the_lint_takes_every_kind_of_the_script(stage, section):
    """One that has no `of` needs its bodies in `subjects` of the lint."""
    edits = {where: value for kind in load_examples()[section] for where, value in edits_of(section, kind).items()}
    lint_case(resolve_case(stage(edits)))


def test_an_example_for_every_kind():
    """The reference fails to build if a kind has no example; an example without a kind would be dead."""
    text = language_reference()
    assert all(example in text for kinds in load_examples().values() for example in kinds.values())


def test_what_the_schema_says_of_expressions_holds(validator):
    body = "{kind: ragdoll, height: ${r + 1}, pose: {pos: [${r}, 0, 0]}}"
    text = f"text2sim: 1\nname: a\nparams: {{r: 1}}\nscene: {{duration: ${{r}}}}\nbodies: {{b: {body}}}\n"
    validator.validate(load_text(text).raw)


@pytest.mark.parametrize(("size", "sound"), [("1e-6", True), ("9e-7", False), ("1e+6", True), ("2e+6", False)])
def test_the_reference_says_which_lengths_the_checker_takes(size, sound):
    rows = {key: takes for key, takes, *_ in field_rows(Sphere)}
    assert rows["radius"] == "a number from 1e-06 to 1e+06 m"
    assert {key: takes for key, takes, *_ in field_rows(Box)}["size"] == "3 numbers from 1e-06 to 1e+06 m"
    assert (problems_of(small(radius=size)) == []) is sound
