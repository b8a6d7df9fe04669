"""Problems land on the right character, in the words of the language; copies differ where they should."""

import subprocess
import sys
from pathlib import Path

import pytest
from small_case import only_problem, problems_of, small

from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.load import load_case, load_text
from text2sim.spec_schema.text.document import parse_pointer, pointer

MEASURES = "actions: {measures: {m: %s}}"
MANY = """\
text2sim: 1
name: many
scene:
  duration: yes
  gravty: [0, 0, -9]
  contact: {model: rigid, friction_cone: eliptic}
bodies:
  ball:
    kind: rigid
    shape: {kind: sphere, radius: -1, height: 3}
    pose: {pos: [0, 0]}
  cube: {shape: {kind: box, size: [1, 1, 1]}}
  9b: {kind: ragdoll, height: 2}
  rope: {kind: chain, links: 1.5, link_length: 0.1, radius: true}
actions:
  controls:
    push: {kind: force, body: ball, force: [1, 0, x]}
    go: {kind: drive, joint: ball, position: {kind: rampp, to: 1}}
    none:
  expect:
    hit: {event: a, above: 3}
"""


def test_every_problem_at_once_each_in_its_place():
    found = [(p.line, p.column, p.rule, p.path, p.hint) for p in problems_of(MANY)]
    assert found == [
        (4, 13, "type", "/scene/duration", None),
        (5, 3, "unknown-key", "/scene/gravty", "gravity"),
        (6, 42, "unknown-word", "/scene/contact/friction_cone", "elliptic"),
        (10, 35, "range", "/bodies/ball/shape/radius", None),
        (10, 39, "unknown-key", "/bodies/ball/shape/height", None),
        (11, 17, "length", "/bodies/ball/pose/pos", None),
        (12, 3, "missing-kind", "/bodies/cube", None),
        (13, 3, "form", "/bodies/9b", None),
        (14, 30, "type", "/bodies/rope/links", None),
        (14, 61, "type", "/bodies/rope/radius", None),
        (17, 51, "type", "/actions/controls/push/force/2", None),
        (18, 53, "unknown-kind", "/actions/controls/go/position/kind", "ramp"),
        (19, 5, "type", "/actions/controls/none", None),
        (21, 5, "inconsistent", "/actions/expect/hit", None),
    ]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (small(radius="true"), "needs a number greater than 0; true is not a number"),
        (small(radius="big"), "needs a number greater than 0 (got the text 'big')"),
        (small(radius="0"), "must be greater than 0 (got 0)"),
        (small(radius=""), "needs a number greater than 0 (got nothing)"),
        (small(ball=", pose: {pos: [1, 2]}"), "needs 3 numbers (got 2)"),
        (small(ball=", pose: {pos: [1, 2, 3, 4]}"), "needs 3 numbers (got 4)"),
        (small(ball=", pose: 3"), "needs a mapping (got the number 3)"),
        (
            small(ball=", mount: {kind: hinge, axis: w}"),
            "needs 3 numbers, or one of x, y, z (got the text 'w')",
        ),
        (small(ball=", mount: {kind: hinge, axis: [0, 0]}"), "needs 3 numbers (got 2)"),
        (small(ball=", mount: {kind: hinge, axis: [0, 0, 0]}"), "must not be zero: it has no direction"),
        (small(ball=", mount: {kind: hinge, axis: 3}"), "needs 3 numbers, or one of x, y, z (got the number 3)"),
        (
            small(ball=", mount: {kind: hing}"),
            "unknown kind `hing`; there are free, fixed, hinge, slider, ball",
        ),
        (small(ball=", mount: {kind: 3}"), "must be one of free, fixed, hinge, slider, ball (got 3)"),
        (small(ball=", mount: {}"), "`kind` is missing: one of free, fixed, hinge, slider, ball"),
        (
            small(ball=", mount: {kind: hinge, range_deg: [10, -10]}"),
            "the second number must not be smaller than the first",
        ),
        (small(ball=", material: {friction: 9}"), "must be from 0.01 to 5 (got 9)"),
        (small(ball=", material: {density: 1, mass: 1}"), "give either density or mass, not both"),
        (
            small(ball=", repeat: {kind: line, count: 2.5, step: [1, 0, 0]}"),
            "needs a whole number from 1 to 100000 (got 2.5)",
        ),
        (
            small(ball=", repeat: {kind: grid, counts: [2], spacing: 1}"),
            "3 whole numbers from 1 to 100000, or 2",
        ),
        (small(ball=", repeat: {kind: line, step: [1, 0, 0]}"), "`count` is missing: `kind: line` needs it"),
        (small(ball=", look: {color: terracota}"), "unknown colour `terracota`"),
        (small(ball=", look: {color: [red, gren]}"), "unknown colour `gren`"),
        (small(ball=", look: {color: [2, 0, 0]}"), "must be from 0 to 1 (got 2)"),
        (
            small(ball=", look: {color: 3}"),
            "needs a colour, 3 numbers from 0 to 1, a list of colours, or a mapping (got the number 3)",
        ),
        (small(ball=", look: {color: [1, 0]}"), "needs 3 numbers from 0 to 1 (got 2)"),
        (small(ball=", place: {on: 'a b'}"), "`a b` is not a selector"),
        (
            small(ball=", place: {on: [ball, ball]}"),
            "needs a selector (got a list of 2 items); it takes one: lists are for",
        ),
        (small(top=MEASURES % "{kind: distance, between: [ball, [ball, ball]]}"), "lists are for `of` of measures and"),
        (small(top=MEASURES % "{kind: speed, of: [ball, 3]}"), "needs a selector (got the number 3)"),
        (
            small(top=MEASURES % "{kind: speed, of: [[ball], ball]}"),
            "needs a selector (got a list of 1 item); it takes",
        ),
        (small(top=MEASURES % "{kind: speed, of: 'a b'}"), "`a b` is not a selector: `brick`, "),
        (
            small(top="actions: {expect: {it: {measure: speed, during: [0, 1s], above: 1}}}"),
            "needs a number of at least 0, or end (got the text '1s'); leave out the unit",
        ),
        (
            small(top="actions: {expect: {it: {measure: speed, during: [0s, end], above: 1}}}"),
            "needs a number of at least 0 (got the text '0s'); leave out the unit",
        ),
        (small(top=MEASURES % "{kind: speed, of: 3}"), "needs a selector, or a list of selectors (got the number 3)"),
        (small(ball=", place: {at: [0, 0]}"), "exactly one of on, above, below"),
        (
            small(scene=", domain: {min: [0, 0, 0], max: [1, 1, 0]}"),
            "than that of min; along z, 0 is not larger than 0",
        ),
        (small(top="render: {resolution: [641, 480]}"), "resolution must be even"),
        (small(top="prompt: 3"), "needs text (got the number 3)"),
        (small().replace("text2sim: 1", "text2sim: 3"), "supports versions 1 to 2 of the language (got 3)"),
        (small().replace("text2sim: 1", "text2sim: true"), "supports versions 1 to 2 of the language (got true)"),
        (small(ball=", material: {restitution: -1}"), "must be from 0 to 0.995 (got -1)"),
        (small(ball=", place: {on: ball, clearance: -1}"), "must be at least 0 (got -1)"),
        (small(ball=", pose: {pos: 3}"), "needs 3 numbers (got the number 3)"),
        (small(ball=", pose: {pos: [1, 2, 1e16]}"), "1e16 is too large: numbers go up to 1e+15"),
        (small(ball=", pose: {quat: [1e-12, 0, 0, 0]}"), "must not be zero: it has no direction"),
        (
            small().replace("sphere, radius: 0.1", "torus, radius: 0.1, bar_radius: 0.2"),
            "bar_radius must be smaller than radius (got 0.2 and 0.1)",
        ),
        (
            small().replace(
                "rigid, shape: {kind: sphere, radius: 0.1}", "chain, links: 3, link_length: 1, radius: 0.6"
            ),
            "link_length must be at least twice the radius (got 1 and 0.6)",
        ),
        (
            small().replace(
                "rigid, shape: {kind: sphere, radius: 0.1}", "net, cells: [4, 4], size: [1, 1], radius: 0.2"
            ),
            "the strands are too thick for its meshes",
        ),
        (
            small(top=f"render: {{lights: {{{', '.join(f'a{i}: {{kind: sun}}' for i in range(21))}}}}}"),
            "needs at most 20 entries (got 21)",
        ),
        (small(top=MEASURES % "{kind: speed, of: []}"), "needs at least 1 entry (got 0)"),
        (
            small(top="actions: {expect: {a: {event: b, above: 1}}}"),
            "above goes with a measure; an event takes within, never",
        ),
        (small(top="render: {during: [1, 1]}"), "the span of the film must not be empty"),
        (small(top="render: {lights: {sun: {kind: sun, direction: [0, 0, 0]}}}"), "must not be zero"),
        (small().replace("text2sim: 1\n", ""), "`text2sim` is missing"),
        (
            small().replace("kind: sphere, ", "kind: plane, ").replace("radius: 0.1", ""),
            "only a static can be a plane",
        ),
    ],
)
def test_messages_are_in_the_words_of_the_language(text, says):
    assert says in only_problem(text).message


@pytest.mark.parametrize(
    ("measure", "place"),
    [
        ("{kind: speed, of: [ball, 3]}", "of/1"),
        ("{kind: speed, of: [ball, 'a b']}", "of/1"),
        ("{kind: speed, of: [[ball], ball]}", "of/0"),
        ("{kind: speed, of: []}", "of"),
        ("{kind: speed, of: {body: ball}}", "of"),
        ("{kind: distance, between: [ball, [ball, ball]]}", "between/1"),
        ("{kind: gap, of: ball, to: [ball, 3]}", "to/1"),
    ],
)
def test_a_wrong_item_of_a_list_of_selectors_is_told_at_its_place(measure, place):
    assert only_problem(small(top=MEASURES % measure)).path == f"/actions/measures/m/{place}"


def test_a_field_that_is_named_like_a_kind_does_not_lead_astray():
    text = small(top="actions: {controls: {a: {kind: force, force: [1, 0, 0], body: 3}}}")
    assert only_problem(text).path == "/actions/controls/a/body"


def test_names_of_attributes_are_no_keys():
    text = small(top="render: {cameras: {c: {kind: still, from_: [1, 1, 1], look_at: ball}}}")
    assert [(p.rule, p.hint) for p in problems_of(text)] == [("unknown-key", "from")]


def test_a_case_is_a_folder_or_its_file(tmp_path: Path):
    (tmp_path / "case.yaml").write_text(small(), "utf-8")
    for path in (tmp_path, tmp_path / "case.yaml"):
        loaded = load_case(path)
        assert loaded.path == tmp_path / "case.yaml"
        assert loaded.folder == tmp_path
        assert loaded.case.name == "small"


REPEATED = """\
text2sim: 1
name: hooks
params: {gap: 0.1}
scene: {duration: 1}
bodies:
  hook:
    kind: rigid
    shape: {kind: sphere, radius: "${0.01 * (i + 1)}"}
    mount: {kind: slider, actuator: {stiffness: "${100 * n}", damping: 1}}
    repeat: {kind: line, count: 4, step: ["${gap}", 0, 0]}
    look: {color: "${'red' if i % 2 == 0 else 'white'}"}
  ring: {kind: ragdoll, height: 1, repeat: {kind: stack, count: 4}}
actions:
  controls:
    open: {kind: drive, joint: "hook[1:3]", position: {kind: ramp, to: "${-gap * i}", end: 1}}
    hang: {kind: attach, body: hook, to: "ring[${n - 1 - i}]"}
    close: {kind: drive, joint: hook, velocity: "${gap}"}
"""


def test_copies_differ_where_expressions_say_so():
    loaded = load_text(REPEATED)
    assert loaded.case.bodies["hook"].shape.radius == 0.01
    copies = [loaded.body_copy("hook", {"i": i, "n": 4}) for i in range(4)]
    assert [round(copy.shape.radius, 9) for copy in copies] == [0.01, 0.02, 0.03, 0.04]
    assert [copy.look.color for copy in copies] == ["red", "white", "red", "white"]
    assert {copy.mount.actuator.stiffness for copy in copies} == {400.0}
    assert [loaded.control_copy("open", {"i": i}).position.to for i in (1, 2)] == [-0.1, -0.2]
    assert loaded.control_copy("hang", {"i": 1, "n": 4}).to == "ring[2]"
    # What does not vary is the same object for every copy.
    assert loaded.body_copy("ring", {"i": 3, "n": 4}) is loaded.case.bodies["ring"]


def test_what_varies_is_known_at_every_depth():
    loaded = load_text(REPEATED)
    varying = [
        "/bodies/hook",
        "/bodies/hook/shape",
        "/bodies/hook/shape/radius",
        "/actions/controls/open",
        "/actions/controls/hang/to",
    ]
    same = [
        "/bodies/hook/repeat",
        "/bodies/hook/shape/kind",
        "/bodies/ring",
        "/actions/controls/close",
        "/params",
    ]
    assert all(loaded.varies(where) for where in varying)
    assert not any(loaded.varies(where) for where in same)


def test_a_copy_that_goes_wrong_is_located():
    loaded = load_text(REPEATED.replace("0.01 * (i + 1)", "0.03 - 0.01 * i"))
    assert loaded.body_copy("hook", {"i": 2, "n": 4}).shape.radius == pytest.approx(0.01)
    with pytest.raises(SpecError) as caught:
        loaded.body_copy("hook", {"i": 3, "n": 4})
    (problem,) = caught.value.problems
    assert (problem.path, problem.line, problem.column) == ("/bodies/hook/shape/radius", 8, 35)
    assert problem.message == "copy 3: must be greater than 0 (got 0)"


@pytest.mark.parametrize(
    ("edit", "says"),
    [
        (("count: 4, step", 'count: "${n}", step'), "not defined in `repeat` itself"),
        (('joint: "hook[1:3]"', 'joint: "hook[${i}]"'), "not defined in `joint`, which selects the copies"),
        (("duration: 1", 'duration: "${n}"'), "defined only in a body or static with repeat"),
    ],
)
def test_copy_variables_have_their_place(edit, says):
    assert says in only_problem(REPEATED.replace(*edit)).message


def test_lines_and_problems_by_pointer():
    loaded = load_text(REPEATED)
    assert loaded.line("/bodies/hook/repeat/step") == 10
    assert loaded.line(("actions", "controls", "hang")) == 16
    assert loaded.line("/bodies/hook/repeat/nothing/here") == 10
    problem = loaded.problem("/bodies/hook/look", "is too red", key=True, rule="taste")
    assert (problem.line, problem.column, problem.rule, problem.path) == (11, 5, "taste", "/bodies/hook/look")
    assert loaded.problem("/bodies/hook/repeat/step/0", "x", rule="r").column == 43


def test_pointers_and_paths():
    assert pointer(("a/b", 0, "c~d")) == "/a~1b/0/c~0d"
    assert parse_pointer("/a~1b/0/c~0d") == ("a/b", 0, "c~d")
    assert parse_pointer("") == ()
    for word in ("007", "²", "٣", "9" * 5000):
        assert parse_pointer(f"/{word}/10") == (word, 10)


def test_checking_a_case_imports_nothing_heavy():
    heavy = "{'numpy', 'genesis', 'torch', 'trimesh', 'ruamel', 'jsonschema', 'rich', 'typer', 'scipy'}"
    code = (
        "import sys, text2sim.spec_schema.load, text2sim.spec_schema.names.references;"
        f"found = {heavy} & set(sys.modules); assert not found, found"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


def test_a_short_thick_rope_has_as_many_links_as_fit() -> None:
    def links(length: float) -> int:
        rope = f"bodies: {{r: {{kind: rope, length: {length}, radius: 0.01}}}}"
        return load_text(f"text2sim: 2\nname: ropes\nscene: {{duration: 1}}\n{rope}\n").case.bodies["r"].segments  # type: ignore[union-attr]

    assert [links(length) for length in (2.0, 0.3, 0.04)] == [24, 15, 2]
    with pytest.raises(SpecError, match="use a longer rope"):
        links(0.03)
