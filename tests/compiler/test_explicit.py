"""A case with nothing left out is a case, and the same simulation and film."""

from pathlib import Path

import pytest

from text2sim.compiler.build import Resolution, resolve_case
from text2sim.compiler.explicit import explicit, folded
from text2sim.compiler.masses import masses
from text2sim.spec_schema.arithmetic.resolution import COPY_VARIABLES
from text2sim.spec_schema.load import load_case, load_text
from text2sim.spec_schema.text.canonical import format_text

TESTS = Path(__file__).resolve().parent.parent
CASES = sorted(path.parent for path in (TESTS.parent / "cases").glob("*/case.yaml"))
ZOO = TESTS / "drawing" / "zoo.yaml"

CASE = """\
text2sim: 2
name: small
params: {size: [0.2, 0.1, 0.3], rows: 3, heavy: 5}
scene:
  duration: 2
  statics: {floor: {shape: {kind: plane}}, post: {shape: {kind: box, size: [1, 1, 1]}, pose: {pos: [5, 0, 0.5]}}}
bodies:
  brick:
    kind: rigid
    shape: {kind: box, size: "${size}"}
    material: {mass: "${heavy * (i + 1)}", restitution: 0.3}
    place: {on: floor, at: ["${i * size[0]}", 0]}
    repeat: {kind: line, count: "${rows}", step: [0, 0, 0]}
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, place: {on: post}, look: {color: "${'red' if rows > 2 else 'blue'}"}}
actions:
  controls:
    throw: {kind: initial_velocity, body: brick, linear: ["${i + rows}", 0, 0]}
"""


def case_of(text: str) -> Resolution:
    return resolve_case(load_text(text))


def again(case: Resolution) -> Resolution:
    return resolve_case(load_text(explicit(case).text(), case.loaded.path))


@pytest.mark.parametrize("path", [*CASES, ZOO], ids=lambda path: path.stem)
def test_same_simulation_and_film(path: Path) -> None:
    case = resolve_case(load_case(path))
    text = explicit(case).text()
    second = resolve_case(load_text(text, case.loaded.path))
    assert second.plan.sim_digest == case.plan.sim_digest
    assert second.plan.render_digest == case.plan.render_digest
    assert second.loaded.case.actions.expect == case.loaded.case.actions.expect
    assert second.loaded.case.prompt == case.loaded.case.prompt
    assert format_text(text) == text, "it is in canonical form"
    assert explicit(second).data == explicit(case).data, "and nothing is left to be written out"


def test_what_a_liquid_looks_like_is_written_out() -> None:
    case = case_of(
        "text2sim: 2\nname: pool\nscene: {duration: 1}\nbodies:\n"
        "  water: {kind: liquid, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0, 0, 0.3]}}\n"
    )
    text = explicit(case).text()
    assert "finish: glass" in text
    assert case_of(text).plan.render_digest == case.plan.render_digest


def test_damping_that_one_body_has_holds_for_all_as_in_the_engine() -> None:
    soft = "kind: soft, solver: fem, shape: {kind: box, size: [0.1, 0.1, 0.1]}"
    case = case_of(
        "text2sim: 2\nname: two\nscene: {duration: 1, contact: {model: sap}}\nbodies:\n"
        f"  a: {{{soft}, material: {{damping: 0}}, pose: {{pos: [0, 0, 1]}}}}\n  b: {{{soft}, pose: {{pos: [1, 0, 1]}}}}\n"
    )
    assert again(case).plan.sim_digest == case.plan.sim_digest


def test_derived_settings_stand_there_with_their_reasons() -> None:
    case = case_of(CASE.replace(", restitution: 0.3", ""))
    text = explicit(case).text()
    assert f"substeps: {case.settings.substeps}  # derived: " in text
    assert "kind: newton  # derived: few enough bodies for the exact solver" in text
    assert "timeconst: 0.01  # derived: two substeps" in text
    assert "max_pairs: 150  # derived: 16 for each of 6 convex pieces" in text


def test_time_constant_of_contacts_that_bounce_is_only_told() -> None:
    case = case_of(CASE)
    assert case.settings.bounce_time > 0
    found = explicit(case)
    assert "timeconst" not in found.data["scene"]["contact"]
    assert "left out, is" in found.comments["scene", "contact"]
    assert again(case).plan.sim_digest == case.plan.sim_digest


def test_values_stand_where_expressions_stood_but_where_copies_differ() -> None:
    data = explicit(case_of(CASE)).data
    assert "params" not in data
    brick = data["bodies"]["brick"]
    assert brick["shape"]["size"] == [0.2, 0.1, 0.3]
    assert brick["repeat"]["count"] == 3
    assert brick["material"]["mass"] == "${5 * (i + 1)}"
    assert brick["place"]["at"] == ["${i * 0.2}", 0]
    assert data["bodies"]["ball"]["look"]["color"] == "red"
    assert data["actions"]["controls"]["throw"]["linear"] == ["${i + 3}", 0.0, 0.0]


def test_places_masses_and_default_colours_are_told() -> None:
    comments = explicit(case_of(CASE)).comments
    assert comments["bodies", "ball", "place"] == "at [5, 0, 1.1]"
    assert comments["bodies", "brick", "place"] == "at [0, 0, 0.15], [0.2, 0, 0.15], [0.4, 0, 0.15]"
    assert comments["bodies", "brick"] == "3 copies of 5 to 15 kg, 30 kg in all"
    assert comments["bodies", "ball"] == "4.189 kg"
    assert comments["scene", "statics", "post", "look"] == "derived: what never moves"


def test_what_the_case_and_the_recording_decide_of_a_film_is_not_written_out() -> None:
    case = case_of(CASE)
    render = explicit(case).data["render"]
    assert not {"cameras", "shots", "speed", "during"} & set(render)
    assert not {"lighting", "background", "exposure"} & set(render)
    assert again(case).plan.render == case.plan.render


def test_one_body_alone() -> None:
    found = explicit(case_of(CASE))
    assert found.only("ball").text().startswith("bodies:\n  ball:  # 4.189 kg\n    kind: rigid\n")
    assert "brick" not in found.only("ball").text()
    assert "place" not in found.only("post").text()
    with pytest.raises(KeyError):
        found.only("nobody")


def test_file_decides_about_its_friction(tmp_path: Path) -> None:
    (tmp_path / "door.xml").write_text(
        '<mujoco><worldbody><body name="door"><joint name="hinge" type="hinge" axis="0 0 1"/>'
        '<geom name="leaf" type="box" size="0.4 0.02 1" mass="12" friction="0.1"/></body></worldbody></mujoco>'
    )
    text = "text2sim: 2\nname: door\nscene: {duration: 1}\nbodies: {door: {kind: articulated, file: door.xml}}\n"
    case = resolve_case(load_text(text, tmp_path / "case.yaml"))
    assert explicit(case).data["bodies"]["door"]["material"] == {}
    assert again(case).plan.sim_digest == case.plan.sim_digest
    assert masses(case) == {"door": pytest.approx(12)}


def test_masses_are_those_of_the_shapes() -> None:
    case = resolve_case(load_case(ZOO))
    found = masses(case)
    assert found["ball"] == pytest.approx(4 / 3 * 3.14159265 * 0.1**3 * 1000)
    assert found["bauble[3]"] == pytest.approx(0.4)
    assert found["ring"] == pytest.approx(2 * 3.14159265**2 * 0.2 * 0.03**2 * 1000, rel=1e-6)
    assert found["doll"] == pytest.approx(sum(found[name] for name in ("doll",)))
    assert set(found) == {copy.name for name in case.loaded.case.bodies for copy in case.placed[name]}


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("${a + i * b[1]}", "${2 + i * 4.5}"),
        ("${b[i]}", "${[1, 4.5][i]}"),
        ("${-a if flag else i}", "${-2 if true else i}"),
        ("${1 / zero if zero else i}", "${1 / 0 if 0 else i}"),
        ("row ${i} of ${a}", "row ${i} of ${2}"),
        ("$${i} is ${i}", "$${i} is ${i}"),
        ("${max(i, sqrt(a + 2))}", "${max(i, 2.0)}"),
        ("${'x' if i else word}", "${'x' if i else 'it'}"),
    ],
)
def test_folding(text: str, meant: str) -> None:
    params = {"a": 2, "b": [1, 4.5], "flag": True, "zero": 0, "word": "it"}
    assert folded(text, params) == meant
    assert folded(meant, {}) == meant
    assert "i" in COPY_VARIABLES


def test_more_substeps_than_can_be_asked_for_are_only_told() -> None:
    stiff = "  a: {kind: soft, solver: mpm, shape: {kind: box, size: [0.1, 0.1, 0.1]}, material: {youngs_modulus: 1.0e+13}}\n"
    case = case_of(f"text2sim: 2\nname: stiff\nscene: {{duration: 1}}\nbodies:\n{stiff}")
    assert case.settings.substeps > 200
    assert "substeps, left out, are" in explicit(case).text()
    assert again(case).plan.sim_digest == case.plan.sim_digest
