"""Programs of contact model ipc: what the coupler is told of every body."""

import json
from pathlib import Path
from typing import Any

import pytest

from text2sim.compiler.build import compile_case, plan_case
from text2sim.compiler.plan import Plan
from text2sim.spec_schema.load import load_case, load_text

GOLDEN = Path(__file__).with_name("ipc_golden")
TOWEL = Path(__file__).resolve().parents[1] / "fuzz" / "soft" / "towel"


@pytest.mark.parametrize("module", ["scene.py", "bodies.py"])
def test_program_is_golden(module: str, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    compile_case(load_case(TOWEL), tmp_path)
    made, known = (tmp_path / module).read_text(), GOLDEN / f"{module}.txt"
    if request.config.getoption("--update-goldens"):
        known.parent.mkdir(exist_ok=True)
        known.write_text(made)
    assert made == known.read_text(), "if this is meant: pytest tests/compiler/test_ipc_program.py --update-goldens"


BODIES: dict[str, Any] = {
    "towel": {
        "kind": "cloth",
        "solver": "ipc",
        "shape": {"kind": "sheet", "size": [0.4, 0.3]},
        "material": {"area_density": 0.4, "thickness": 0.002, "friction": 0.6},
        "pose": {"pos": [0, 0, 0.5]},
    },
    "cup": {
        "kind": "rigid",
        "shape": {"kind": "cup", "radius": 0.04, "height": 0.1, "thickness": 0.005},
        "material": {"mass": 0.3, "friction": 0.7},
        "pose": {"pos": [1, 0, 0.5]},
    },
    "ball": {"kind": "rigid", "shape": {"kind": "sphere", "radius": 0.05}, "pose": {"pos": [2, 0, 0.5]}},
    "thrown": {"kind": "rigid", "shape": {"kind": "sphere", "radius": 0.05}, "pose": {"pos": [3, 0, 0.5]}},
    "door": {
        "kind": "rigid",
        "shape": {"kind": "box", "size": [0.4, 0.04, 0.6]},
        "mount": {"kind": "hinge", "axis": "z"},
        "pose": {"pos": [4, 0, 0.5]},
    },
    "hook": {
        "kind": "rigid",
        "shape": {"kind": "sphere", "radius": 0.01},
        "material": {"touch_soft": False},
        "pose": {"pos": [5, 0, 0.5]},
    },
    "jelly": {
        "kind": "soft",
        "solver": "fem",
        "shape": {"kind": "box", "size": [0.1, 0.1, 0.1]},
        "material": {"friction": 0.2},
        "pose": {"pos": [6, 0, 0.5]},
    },
}


@pytest.fixture(scope="module")
def plan() -> Plan:
    data = {
        "text2sim": 2,
        "name": "dishes",
        "scene": {"duration": 1, "statics": {"floor": {"shape": {"kind": "plane"}, "material": {"friction": 0.9}}}},
        "bodies": BODIES,
        "actions": {"controls": {"go": {"kind": "initial_velocity", "body": "thrown", "linear": [1, 0, 0]}}},
    }
    return plan_case(load_text(json.dumps(data)))


def options(plan: Plan, name: str) -> dict[str, Any]:
    entities = [entity for group in (*plan.statics, *plan.bodies) for entity in group.entities]
    return next(entity.material_options for entity in entities if entity.name == name)


def density(plan: Plan, name: str) -> float | None:
    return next(entity.rho for group in plan.bodies for entity in group.entities if entity.name == name)


def test_a_cloth_weighs_what_it_is_said_to(plan: Plan) -> None:
    found = options(plan, "towel")
    # libuipc counts the thickness to each side of the middle: its volume is area times twice that.
    assert 2 * found["thickness"] * found["rho"] == pytest.approx(0.4)
    assert found["thickness"] == pytest.approx(0.001)
    assert found["friction_mu"] == 0.6


@pytest.mark.parametrize(("name", "friction"), [("floor", 0.9), ("cup", 0.7), ("ball", 0.5)])
def test_the_coupler_knows_the_friction_of_rigid_bodies(plan: Plan, name: str, friction: float) -> None:
    assert options(plan, name)["coup_friction"] == friction


def test_soft_bodies_have_friction_and_the_couplers_model(plan: Plan) -> None:
    assert options(plan, "jelly")["friction_mu"] == 0.2
    assert options(plan, "jelly")["model"] == "stable_neohookean"


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("floor", "ipc_only"),
        ("cup", "ipc_only"),
        ("ball", "ipc_only"),
        ("thrown", "two_way_soft_constraint"),
        ("door", "two_way_soft_constraint"),
    ],
)
def test_what_moves_a_body_decides_how_it_is_coupled(plan: Plan, name: str, kind: str | None) -> None:
    assert options(plan, name).get("coup_type") == kind


def test_what_keeps_out_is_not_coupled(plan: Plan) -> None:
    assert options(plan, "hook") == {"needs_coup": False}


def test_a_body_of_pieces_has_the_density_that_gives_its_mass(plan: Plan) -> None:
    from text2sim.compiler.shapes import geometry
    from text2sim.spec_schema.models.shapes import Cup

    cup = Cup(kind="cup", radius=0.04, height=0.1, thickness=0.005)
    volume = sum(piece.volume() for piece in geometry.pieces(cup, Path()))
    assert (density(plan, "cup") or 0.0) * volume == pytest.approx(0.3, rel=1e-4)


def test_contact_begins_within_what_is_seen_as_a_gap(plan: Plan) -> None:
    soft = plan.settings.soft
    assert soft is not None
    assert soft.ipc is not None
    assert 5e-4 <= soft.ipc.contact_distance <= 5e-3
    assert "contact_distance" in soft.why
