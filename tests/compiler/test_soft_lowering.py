"""Deformable bodies as entities of the engine: materials, meshes, poses, masses, and what rigid bodies are told."""

from math import pi
from pathlib import Path

import numpy as np
import pytest

from text2sim.compiler.build import Resolution, resolve_case
from text2sim.compiler.explicit import explicit
from text2sim.compiler.masses import masses
from text2sim.compiler.plan import EntityPlan
from text2sim.compiler.shapes.rotation import quat_to_rows
from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.load import load_text

HEAD = "text2sim: 2\nname: soft\nscene: {duration: 1, statics: {floor: {shape: {kind: plane}, material: {friction: 0.7}}}}\nbodies:\n"
PROGRAMS = Path(__file__).resolve().parent.parent / "soft_programs"


def resolve(bodies: str, folder: Path | None = None) -> Resolution:
    return resolve_case(load_text(HEAD + bodies, folder / "case.yaml" if folder else Path("case.yaml")))


def entity(bodies: str) -> EntityPlan:
    return resolve(bodies).plan.bodies[0].entities[0]


def vertices(case: Resolution, one: EntityPlan) -> np.ndarray:
    text = case.plan.files[one.options["file"]].decode()
    return np.array([line.split()[1:] for line in text.splitlines() if line.startswith("v ")], float)


BOX = "shape: {kind: box, size: [0.3, 0.2, 0.1]}"


def test_materials_of_soft_bodies() -> None:
    stuff = "youngs_modulus: 2.0e5, poisson_ratio: 0.4, density: 800.0"
    one = entity(f"  a: {{kind: soft, {BOX}, material: {{{stuff}}}}}")
    assert one.material == "Corotated"
    assert one.material_options == {"E": 2e5, "nu": 0.4, "rho": 800.0}
    one = entity(f"  a: {{kind: soft, {BOX}, material: {{model: neo_hookean, {stuff}}}}}")
    assert one.material_options["model"] == "neohooken"
    one = entity(f"  a: {{kind: soft, solver: fem, {BOX}, material: {{{stuff}, friction: 0.9}}}}")
    assert one.material == "FEM.Elastic"
    assert one.material_options == {"E": 2e5, "nu": 0.4, "rho": 800.0, "model": "linear_corotated", "friction_mu": 0.9}
    one = entity(f"  a: {{kind: soft, solver: fem, {BOX}, material: {{{stuff}, hydroelastic_modulus: 4.0e6}}}}")
    assert one.material_options["hydroelastic_modulus"] == 4e6


def test_yield_stress_is_that_of_von_mises() -> None:
    one = entity(f"  a: {{kind: soft, {BOX}, material: {{model: elasto_plastic, yield_stress: 3000.0}}}}")
    # Under uniaxial stress s the deviator is s (2/3, -1/3, -1/3), whose norm is s sqrt(2/3): the engine's measure.
    deviator = 3000 * np.array([2 / 3, -1 / 3, -1 / 3])
    assert one.material_options["von_mises_yield_stress"] == pytest.approx(np.linalg.norm(deviator), rel=1e-5)


def test_a_plastic_solid_with_a_viscosity_is_of_our_own_class() -> None:
    stuff = "model: elasto_plastic, yield_stress: 300.0"
    plain = entity(f"  a: {{kind: soft, {BOX}, material: {{{stuff}}}}}")
    slow = entity(f"  a: {{kind: soft, {BOX}, material: {{{stuff}, viscosity: 20}}}}")
    assert (plain.material, slow.material) == ("MPM.ElastoPlastic", "Viscoplastic")
    assert slow.material_options == plain.material_options | {"viscosity": 20.0}
    with pytest.raises(SpecError, match="viscosity needs model elasto_plastic \\(got elastic\\)"):
        entity(f"  a: {{kind: soft, {BOX}, material: {{viscosity: 20}}}}")


@pytest.mark.parametrize(
    ("look", "finish"), [("", "glass"), (", look: {color: red}", "glass"), (", look: {finish: rough}", "rough")]
)
def test_a_liquid_is_clear_unless_it_is_given_a_finish(look: str, finish: str) -> None:
    one = entity(f"  a: {{kind: liquid, {BOX}{look}}}")
    assert one.surface is not None
    assert one.surface.finish == finish


def test_stiffness_of_a_liquid_is_its_bulk_modulus() -> None:
    one = entity(f"  a: {{kind: liquid, {BOX}, material: {{stiffness: 4.0e5}}}}")
    young, nu = one.material_options["E"], one.material_options["nu"]
    assert young * nu / ((1 + nu) * (1 - 2 * nu)) == pytest.approx(4e5)


def test_a_stream_waits_nowhere_and_weighs_what_comes_out() -> None:
    stream = "shape: {kind: stream, radius: 0.02, speed: 0.5, start: 1, duration: 2, direction: [0, 1, 0]}"
    pose = "pose: {pos: [0, 0, 1], euler_deg: [0, 0, 90]}"
    one = entity(f"  a: {{kind: liquid, {stream}, {pose}, material: {{density: 1200, viscosity: 3}}}}")
    assert (one.morph, one.material) == ("Nowhere", "ViscousLiquid")
    assert one.soft is not None
    assert one.soft.stream is not None
    assert one.soft.mass == pytest.approx(1200 * pi * 0.02**2 * 0.5 * 2)
    assert one.soft.stream["direction"] == pytest.approx((-1, 0, 0))
    assert one.soft.stream["start"] == 1.0


def test_cloth_and_grains() -> None:
    one = entity(
        "  a: {kind: cloth, shape: {kind: sheet, size: [0.4, 0.2]}, material: {area_density: 0.25, friction: 0.4}}"
    )
    assert one.material == "PBD.Cloth"
    assert one.material_options["rho"] == 0.25
    assert one.material_options["static_friction"] == one.material_options["kinetic_friction"] == 0.4
    one = entity("  a: {kind: granular, shape: {kind: cylinder, radius: 0.1, height: 0.2}}")
    assert (one.material, one.morph, one.options) == ("MPM.Sand", "Cylinder", {"radius": 0.1, "height": 0.2})
    assert one.material_options["friction_angle"] == 35.0
    assert entity("  a: {kind: snow, shape: {kind: sphere, radius: 0.1}}").material_options["yield_lower"] == 0.025


@pytest.mark.parametrize("solver", ["mpm", "fem"])
def test_the_mesh_stands_where_the_body_is_placed(solver: str) -> None:
    case = resolve(
        f"  a: {{kind: soft, solver: {solver}, {BOX}, pose: {{pos: [1, 2, 3], euler_deg: [20, 30, 40]}}, "
        "repeat: {kind: line, count: 2, step: [1, 0, 0]}}"
    )
    for copy, one in zip(case.placed["a"], case.plan.bodies[0].entities, strict=True):
        world = vertices(case, one) @ np.array(quat_to_rows(one.quat)).T + one.pos
        corners = np.array([[x, y, z] for x in (-0.15, 0.15) for y in (-0.1, 0.1) for z in (-0.05, 0.05)])
        meant = corners @ np.array(quat_to_rows(copy.quat)).T + copy.pos
        assert world.min(axis=0) == pytest.approx(meant.min(axis=0), abs=1e-6)
        assert world.max(axis=0) == pytest.approx(meant.max(axis=0), abs=1e-6)
    # The engine turns a fem body about the mean of vertices that it makes itself: it must have nothing to turn.
    assert (case.plan.bodies[0].entities[0].quat == (1.0, 0.0, 0.0, 0.0)) == (solver == "fem")


def test_copies_share_a_mesh_unless_they_are_turned_in_it() -> None:
    def files(solver: str) -> set[str]:
        case = resolve(
            f"  a: {{kind: soft, solver: {solver}, {BOX}, pose: {{pos: [0, 0, 3], euler_deg: [0, 0, '${{90 * i}}']}}, "
            "repeat: {kind: line, count: 3, step: [1, 0, 0]}}"
        )
        return {one.options["file"] for one in case.plan.bodies[0].entities}

    assert len(files("mpm")) == 1
    assert len(files("fem")) == 3


def test_masses() -> None:
    case = resolve(
        f"  a: {{kind: soft, {BOX}, material: {{density: 500.0}}}}\n"
        "  b: {kind: cloth, shape: {kind: sheet, size: [0.4, 0.2]}, material: {area_density: 0.25}, pose: {pos: [0, 0, 1]}}\n"
        "  c: {kind: granular, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 2]}}\n"
    )
    assert masses(case) == pytest.approx({"a": 3.0, "b": 0.02, "c": 1600 * 4 / 3 * pi * 0.001})
    assert {name: facts.mass for name, facts in case.plan.deformables.items()} == pytest.approx(masses(case))


def test_rigid_bodies_tell_their_friction_where_something_deforms() -> None:
    case = resolve(
        f"  a: {{kind: soft, {BOX}, pose: {{pos: [0, 0, 1]}}}}\n"
        "  b: {kind: rigid, shape: {kind: sphere, radius: 0.1}, material: {friction: 0.2}}\n"
        "  c: {kind: rigid, shape: {kind: sphere, radius: 0.1}, material: {touch_soft: false}, pose: {pos: [1, 0, 0]}}\n"
        "  d: {kind: chain, links: 3, link_length: 0.1, radius: 0.01, pose: {pos: [2, 0, 1]}}\n"
    )
    found = {e.name: e.material_options for g in (*case.plan.statics, *case.plan.bodies) for e in g.entities}
    assert found["floor"] == {"coup_friction": 0.7}
    assert found["b"] == {"coup_friction": 0.2}
    assert found["c"] == {"needs_coup": False}
    assert found["d"] == {"coup_friction": 0.5}
    link = "{parent: base, shape: {kind: sphere, radius: 0.1}, joint: {kind: hinge, axis: x}, material: {%s}}"
    arm = (
        f"  a: {{kind: soft, {BOX}, pose: {{pos: [0, 0, 1]}}}}\n"
        "  arm:\n    kind: articulated\n    pose: {pos: [3, 0, 1]}\n    links:\n"
        f"      base: {{shape: {{kind: sphere, radius: 0.1}}}}\n      free: {link % 'touch_soft: false'}\n"
        f"      felt: {link % 'density: 500'}\n"
    )
    ((entity,),) = (group.entities for group in resolve(arm).plan.bodies if group.name == "arm")
    assert entity.material_options == {"coup_friction": 0.5, "coup_links": ["base", "felt"]}
    # What a link says counts before its body, and what it leaves out is as the body says.
    aloof = arm + "    material: {touch_soft: false}\n"
    ((entity,),) = (group.entities for group in resolve(aloof).plan.bodies if group.name == "arm")
    assert entity.material_options == {"needs_coup": False}
    only = aloof.replace("density: 500", "density: 500, touch_soft: true")
    ((entity,),) = (group.entities for group in resolve(only).plan.bodies if group.name == "arm")
    assert entity.material_options == {"coup_friction": 0.5, "coup_links": ["felt"]}
    fine = resolve(
        f"  a: {{kind: soft, {BOX}, cell: 0.008, pose: {{pos: [0, 0, 1]}}}}\n"
        "  b: {kind: rigid, shape: {kind: sphere, radius: 0.1}}"
    )
    assert fine.plan.bodies[1].entities[0].material_options["coup_softness"] == pytest.approx(0.001)
    said = resolve(
        f"  a: {{kind: soft, {BOX}, cell: 0.008, pose: {{pos: [0, 0, 1]}}}}\n"
        "  b: {kind: rigid, shape: {kind: sphere, radius: 0.1}, material: {soft_reach: 0.008}}"
    )
    assert said.plan.bodies[1].entities[0].material_options["coup_softness"] == pytest.approx(0.008)


def test_what_holds_a_liquid_reaches_a_quarter_of_a_cell() -> None:
    """More would narrow what it flows through: benchmarks/soft_leaks.py."""
    text = f"  a: {{kind: liquid, {BOX}, cell: 0.02, pose: {{pos: [0, 0, 1]}}}}"
    case = resolve(text)
    assert case.plan.statics[0].entities[0].material_options["coup_softness"] == pytest.approx(0.005)
    assert any(note.startswith("soft_reach = 0.005 m: a quarter of a cell") for note in case.plan.settings.notes())


def test_the_space_of_a_liquid_does_not_end_behind_the_wall_that_holds_it() -> None:
    """The engine stops particles three cells before the bounds: a wall within the margin would never be reached."""
    text = f"  a: {{kind: liquid, {BOX}, cell: 0.02, pose: {{pos: [0, 0, 1]}}}}"
    alone = resolve(text).plan.settings.soft.mpm.high[0]
    face = alone - 0.02
    wall = f"  wall: {{kind: rigid, mount: {{kind: fixed}}, shape: {{kind: box, size: [0.1, 1, 1]}}, pose: {{pos: [{face + 0.05}, 0, 0.5]}}}}"
    assert resolve(f"{text}\n{wall}").plan.settings.soft.mpm.high[0] >= face + 3 * 0.02


def test_a_picture_goes_into_the_program(tmp_path: Path) -> None:
    from PIL import Image

    Image.new("RGB", (4, 2), "red").save(tmp_path / "flag.png")
    sheet = "  a: {kind: cloth, shape: {kind: sheet, size: [0.4, 0.2], texture: flag.png}}"
    case = resolve(sheet, tmp_path)
    surface = case.plan.bodies[0].entities[0].surface
    assert surface is not None and surface.picture is not None
    assert case.plan.files[surface.picture] == (tmp_path / "flag.png").read_bytes()


def test_the_digest_of_a_simulation_covers_shape_and_stuff_but_no_looks() -> None:
    def digest(bodies: str) -> tuple[str, str]:
        plan = resolve(bodies).plan
        return plan.sim_digest, plan.render_digest

    first = digest(f"  a: {{kind: soft, {BOX}}}")
    assert digest(f"  a: {{kind: soft, {BOX}, look: {{color: red}}}}")[0] == first[0]
    assert digest(f"  a: {{kind: soft, {BOX}, look: {{color: red}}}}")[1] != first[1]
    for change in ("material: {youngs_modulus: 9.0e4}", "cell: 0.019", "material: {model: neo_hookean}", "solver: fem"):
        assert digest(f"  a: {{kind: soft, {BOX}, {change}}}")[0] != first[0], change


@pytest.mark.parametrize("name", sorted(path.parent.name for path in PROGRAMS.glob("*/case.yaml")))
def test_written_out_it_is_the_same_simulation(name: str) -> None:
    path = PROGRAMS / name / "case.yaml"
    case = resolve_case(load_text(path.read_text(), path))
    second = resolve_case(load_text(explicit(case).text(), path))
    assert second.plan.sim_digest == case.plan.sim_digest
    assert explicit(second).data == explicit(case).data
