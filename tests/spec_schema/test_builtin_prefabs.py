"""The built-in prefabs: whatever is asked of them within their ranges, they are bodies that stand where they are put."""

import random
from typing import Any

import pytest

from text2sim.compiler.build import Resolution, resolve_case
from text2sim.lint import lint_case
from text2sim.spec_schema.errors import Problem, SpecError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.models.prefab_models import PrefabParam
from text2sim.spec_schema.reuse.catalogue import STAGE, built_in, example_case, examples, library
from text2sim.spec_schema.reuse.expanded import expanded_text
from text2sim.spec_schema.reuse.library import Definition
from text2sim.spec_schema.text.writing import flow_text

NAMES = tuple(examples())
HEAVY = ("robot_arm",)
"""Read from files, which takes a second."""
STANDING = ("table", "plate", "cup", "bottle", "wine_glass", "fork", "knife", "spoon", "tube", "funnel", "tank")
"""Their origin is in the middle of their underside."""
MEASURED = {  # width, depth, height [m], as it is
    "table": (1.4, 0.8, 0.74),
    "plate": (0.27, 0.27, 0.024),
    "bottle": (0.075, 0.075, 0.3),
    "wine_glass": (0.085, 0.085, 0.2),
    "fork": (0.2, 0.0232, 0.00741),
    "tube": (0.11, 0.11, 0.5),
    "tank": (0.42, 0.42, 0.36),
    "wheel": (0.5, 0.24, 0.5),
}
MASSES = {  # [kg], as it is; what shops say of such things
    "table": (25, 45),
    "plate": (0.45, 0.75),
    "cup": (0.25, 0.4),
    "bottle": (0.4, 0.65),
    "wine_glass": (0.12, 0.25),
    "fork": (0.04, 0.065),
    "knife": (0.08, 0.12),
    "spoon": (0.04, 0.065),
    "ragdoll": (70, 80),
    "wheel": (6, 12),
    "cart": (8, 14),
}
UNMEANT = {"overlap", "self-overlap", "under-floor", "on-edge", "falls-for-ever"}
"""Rules that must find nothing, whatever the parameters."""


def resolved(use: dict[str, Any], **scene: Any) -> Resolution:
    case = {**STAGE, "scene": {**STAGE["scene"], "substeps": 2, **scene}, "bodies": {"it": use}}
    return resolve_case(load_text(flow_text(case)))


def found(resolution: Resolution) -> list[Problem]:
    return [p for p in lint_case(resolution).problems if p.severity == "error" or p.rule in UNMEANT]


def drawn(param: PrefabParam, chance: random.Random) -> Any:
    """A value within the range, its ends more often than chance would have it."""
    low, high = param.min, param.max
    if param.kind == "bool":
        return chance.random() < 0.5
    if param.kind == "choice":
        assert param.of is not None
        return chance.choice(param.of)
    if param.kind == "color":
        return chance.choice(["crimson", "#102030"])
    assert low is not None and high is not None, f"a {param.kind} needs a range"
    if param.kind == "integer":
        return chance.choice([int(low), int(high), chance.randint(int(low), int(high))])

    def one() -> float:
        return round(
            chance.choice(
                [low, high, chance.uniform(low, high), low * (high / low) ** chance.random() if low > 0 else low]
            ),
            9,
        )

    return [one() for _ in range(int(param.kind[-1]))] if param.kind.startswith("vec") else one()


def arguments(definition: Definition, chance: random.Random) -> dict[str, Any]:
    params = definition.model.params.items()
    given = {name: drawn(param, chance) for name, param in params if chance.random() < 0.8}
    # A chain of sixty rings of a metre needs room below it.
    return given | {"at": [0, 0, 200]} if "at" in definition.model.params else given


def test_every_prefab_has_an_example_and_every_example_a_prefab():
    assert {*library().names()} ^ {*NAMES} == set(), "prefab_examples.yaml and the folder prefabs differ in these"


@pytest.mark.parametrize("name", NAMES)
def test_the_example_is_a_case_without_fault(name: str):
    loaded = load_text(example_case(examples()[name]))
    assert f"use: {name}" in examples()[name]
    assert lint_case(resolve_case(loaded)).problems == []
    assert load_text(expanded_text(loaded)).data == loaded.data  # a run names its case by this text


@pytest.mark.parametrize("name", NAMES)
def test_every_parameter_is_documented_and_can_be_left_out(name: str):
    definition = built_in()[name]
    assert "Origin" in definition.model.doc or "at" in definition.model.params
    for param, model in definition.model.params.items():
        assert model.doc.endswith("."), param
        assert model.default is not None, param
        if model.kind in ("number", "integer", "length", "angle_deg", "vec2", "vec3"):
            assert model.min is not None and model.max is not None, param


@pytest.mark.parametrize("name", [name for name in NAMES if name not in HEAVY])
def test_whatever_is_given_within_the_ranges_is_a_valid_body(name: str):
    definition, chance = built_in()[name], random.Random(name)
    for _ in range(12):
        given = arguments(definition, chance)
        use: dict[str, Any] = {"use": name, "with": given}
        if definition.model.body is not None:
            use["place"] = {"on": "floor"}
        resolution = resolved(use)
        assert found(resolution) == [], given
        if name in STANDING:
            (copy,) = resolution.placed["it"]
            assert copy.pos[2] == pytest.approx(0, abs=1e-6), given


@pytest.mark.parametrize("name", [name for name in NAMES if name not in HEAVY])
def test_what_is_out_of_range_is_refused_where_it_stands(name: str):
    definition = built_in()[name]
    for param, model in definition.model.params.items():
        if model.max is None or model.kind.startswith("vec"):
            continue
        with pytest.raises(SpecError, match=r"needs .* from .* to .*got") as caught:
            resolved({"use": name, "with": {param: model.max * 1.01 + 1}})
        assert caught.value.problems[0].path.startswith("/bodies/it/with/")


@pytest.mark.parametrize(("name", "size"), MEASURED.items())
def test_it_is_as_large_as_it_says(name: str, size: tuple[float, float, float]):
    from text2sim.compiler.shapes.extents import extents

    (copy,) = resolved({"use": name, "pose": {"pos": [0, 0, 5]}}).placed["it"]
    low, high = extents(copy.shape, copy.quat, resolved({"use": name, "pose": {"pos": [0, 0, 5]}}).loaded.folder)
    assert tuple(b - a for a, b in zip(low, high, strict=True)) == pytest.approx(size, rel=0.01)


@pytest.mark.parametrize(("name", "span"), MASSES.items())
def test_it_weighs_what_such_a_thing_weighs(name: str, span: tuple[float, float]):
    low, high = span
    assert low < mass_of(resolved({"use": name, "pose": {"pos": [0, 0, 5]}})) < high


def mass_of(resolution: Resolution) -> float:
    """Mass [kg] of the one body, from the model file that the engine reads."""
    import mujoco

    files = {path.rsplit("/", 1)[-1]: content for path, content in resolution.plan.files.items()}
    model = mujoco.MjModel.from_xml_string(files["it.xml"].decode(), files)  # type: ignore[attr-defined]
    return float(model.body_mass.sum())


def test_a_full_bottle_is_heavier_by_its_wine():
    empty, full = (
        mass_of(resolved({"use": "bottle", "with": {"fill": fill}, "place": {"on": "floor"}})) for fill in (0, 1)
    )
    # The body of a bottle of 0.75 l, without shoulder and neck.
    assert full - empty == pytest.approx(0.64, abs=0.06)


def test_rings_of_a_chain_hold_each_other_and_do_not_touch():
    from text2sim.compiler.shapes.geometry import pieces

    for radius, bar in ((0.05, 0.2), (0.02, 0.28), (0.5, 0.12)):
        use = {"use": "ring_chain", "with": {"radius": radius, "bar": bar, "rings": 3, "at": [0, 0, 9]}}
        resolution = resolved(use)
        anchor, *rings = resolution.placed["it_anchor"] + resolution.placed["it_ring"]
        for upper, lower in zip([anchor, *rings], rings, strict=False):
            drop = upper.pos[2] - lower.pos[2]
            # The bar of each runs through the hole of the other, with a gap: inner radii of both overlap.
            assert 2 * bar * radius < drop < 2 * radius - 2.078 * bar * radius
            assert len(pieces(upper.shape, resolution.loaded.folder)) == 16
            # At right angles: turned by a quarter about the vertical.
            turn = sum(a * b for a, b in zip(upper.quat, lower.quat, strict=True))
            assert abs(turn) == pytest.approx(0.5**0.5, abs=1e-6)
        # Two that are not neighbours never meet.
        assert 2 * drop > 2 * (radius + bar * radius)


def test_a_chain_that_is_not_fixed_falls_as_a_whole():
    held, loose = (resolved({"use": "ring_chain", "with": {"fixed": fixed}}) for fixed in (True, False))
    assert held.loaded.case.bodies["it_anchor"].mount.kind == "fixed"  # type: ignore[union-attr]
    assert loose.loaded.case.bodies["it_anchor"].mount.kind == "free"  # type: ignore[union-attr]


def test_hooks_can_go_to_both_ends_of_their_rod():
    resolution = resolved({"use": "curtain_rod", "with": {"hooks": 5, "length": 2}})
    for copy in resolution.placed["it_hook"]:
        low, high = copy.model.mount.range
        assert copy.pos[0] + low == pytest.approx(-0.96)
        assert copy.pos[0] + high == pytest.approx(0.96)


def test_jaws_close_on_each_other_and_no_further():
    resolution = resolved({"use": "clamp", "with": {"opening": 0.2}, "pose": {"pos": [0, 0, 1]}})
    links = resolution.loaded.case.bodies["it"].links  # type: ignore[union-attr]
    assert links is not None
    for name, side in (("left", -1), ("right", 1)):
        joint = links[name].joint
        assert joint is not None and joint.kind == "slider" and joint.range == (0, 0.1)
        assert links[name].pose.pos[0] == pytest.approx(side * 0.1)


def test_a_prefab_among_the_statics_has_no_motor_and_no_mass():
    statics = {**STAGE["scene"]["statics"], "drum": {"use": "drum", "pose": {"pos": [0, 0, 1]}}}
    ball = {"kind": "rigid", "shape": {"kind": "sphere", "radius": 0.1}, "pose": {"pos": [0, 0, 1]}}
    case = {**STAGE, "scene": {**STAGE["scene"], "statics": statics}, "bodies": {"ball": ball}}
    resolution = resolve_case(load_text(flow_text(case)))
    assert resolution.plan.motors == ()
    assert "drum" not in resolution.loaded.case.bodies


def test_the_robot_comes_from_the_engine_and_stands_on_the_floor():
    resolution = resolved({"use": "robot_arm", "with": {"posture": "up"}, "place": {"on": "floor", "at": [0, 0]}})
    motors = {motor.joint: motor for motor in resolution.plan.motors}
    assert len(motors) == 9
    assert motors["panda_joint1"].max_force == 87
    assert motors["panda_joint7"].max_force == 12
    assert found(resolution) == []
    (copy,) = resolution.placed["it"]
    assert copy.pos[2] == pytest.approx(0, abs=1e-3)
