"""Solvers, sizes of elements, domains and time steps that are derived for deformable bodies."""

from math import e, sqrt
from typing import Any

import pytest

from text2sim.compiler.build import Resolution, resolve_case
from text2sim.compiler.soft.settings import sound_step
from text2sim.compiler.soft.setup import MpmSettings, PbdSettings
from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.models.soft_bodies import Liquid

FLOOR = "statics: {floor: {shape: {kind: plane}}}"
CUBE = "{kind: soft, shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [0, 0, 0.3]}"
SHEET = "{kind: cloth, shape: {kind: sheet, size: [0.4, 0.2]}, pose: {pos: [0, 0, 0.5]}}"


def resolve(bodies: str, scene: str = FLOOR, actions: str = "") -> Resolution:
    return resolve_case(
        load_text(f"text2sim: 2\nname: soft\nscene: {{duration: 1, {scene}}}\nbodies:\n{bodies}\n{actions}\n")
    )


def mpm(case: Resolution) -> MpmSettings:
    assert case.settings.soft is not None and case.settings.soft.mpm is not None
    return case.settings.soft.mpm


def pbd(case: Resolution) -> PbdSettings:
    assert case.settings.soft is not None and case.settings.soft.pbd is not None
    return case.settings.soft.pbd


@pytest.mark.parametrize(
    ("bodies", "scene", "model", "solver"),
    [
        (f"  a: {CUBE}}}", FLOOR, "particle", "mpm"),
        (f"  a: {SHEET}", FLOOR, "particle", "pbd"),
        (f"  a: {CUBE}, solver: fem}}", FLOOR, "sap", "fem"),
        (f"  a: {CUBE}}}", f"contact: {{model: sap}}, {FLOOR}", "sap", "fem"),
        (f"  a: {SHEET}", f"contact: {{model: ipc}}, {FLOOR}", "ipc", "ipc"),
        (f"  a: {CUBE}}}\n  b: {SHEET[:-1]}, solver: ipc}}", FLOOR, "ipc", "mpm"),
        (f"  a: {CUBE}}}", f"contact: {{model: rigid}}, {FLOOR}", "rigid", "mpm"),
    ],
)
def test_contact_model_and_solver_go_together(bodies: str, scene: str, model: str, solver: str) -> None:
    case = resolve(bodies, scene)
    assert case.settings.soft is not None
    assert case.settings.soft.model == model
    assert case.plan.deformables["a"].solver == solver


def test_a_rigid_scene_has_none() -> None:
    case = resolve("  a: {kind: rigid, shape: {kind: sphere, radius: 0.1}}")
    assert case.settings.soft is None
    assert case.plan.bodies[0].entities[0].material_options == {}
    assert "soft" not in case.plan.files


def test_cell_comes_from_the_thinnest_body_and_can_be_said() -> None:
    thin = "  b: {kind: soft, shape: {kind: box, size: [0.2, 0.2, 0.05]}, pose: {pos: [1, 0, 0.3]}}"
    assert mpm(resolve(f"  a: {CUBE}}}")).cell == pytest.approx(0.02)
    assert mpm(resolve(f"  a: {CUBE}}}\n{thin}")).cell == pytest.approx(0.01)
    assert mpm(resolve(f"  a: {CUBE}, cell: 0.016}}\n{thin}")).cell == 0.016
    case = resolve(f"  a: {CUBE}, cell: 0.016}}", f"mpm: {{cell: 0.03}}, {FLOOR}")
    assert mpm(case).cell == 0.03
    assert "mpm_cell" not in case.settings.soft.why  # type: ignore[union-attr]
    assert mpm(case).density == pytest.approx(1 / 0.03, rel=1e-5)


def test_a_large_body_is_cut_as_fine_as_there_are_particles() -> None:
    plate = "  a: {kind: soft, shape: {kind: box, size: [1, 1, 0.02]}, pose: {pos: [0, 0, 0.3]}}"
    cell = mpm(resolve(plate)).cell
    assert 0.02 / (0.64 * cell) ** 3 == pytest.approx(20_000, rel=0.02)


def test_substeps_keep_sound_within_half_a_cell() -> None:
    def step(material: str) -> tuple[float, float]:
        case = resolve(f"  a: {CUBE}, material: {material}}}")
        return 0.01 / case.settings.substeps, mpm(case).cell

    step_s, cell = step("{youngs_modulus: 2.0e6, poisson_ratio: 0.45, density: 500.0}")
    speed = sqrt(2e6 * 0.55 / (1.45 * 0.1 * 500))
    assert 0.45 * cell / speed < step_s <= 0.5 * cell / speed
    step_s, cell = step("{youngs_modulus: 1.0e4}")
    assert step_s == pytest.approx(0.05 * cell), "a soft one that nothing moves"


def test_substeps_keep_what_moves_within_half_a_cell() -> None:
    """Sound c and motion v cross half a cell; what is faster than the engine's 25 m/s has the engine's step."""

    def step(speed: float) -> float:
        start = f"actions: {{controls: {{go: {{kind: initial_velocity, body: a, linear: [{speed}, 0, 0]}}}}}}"
        soft = "material: {youngs_modulus: 1.0e5, poisson_ratio: 0, density: 1000}"
        case = resolve(f"  a: {CUBE}, {soft}}}", "gravity: [0, 0, 0]", start)
        return 0.01 / case.settings.substeps / mpm(case).cell

    assert 0.45 / 15 < step(5.0) <= 0.5 / 15
    assert step(30.0) == pytest.approx(0.02)


@pytest.mark.parametrize(("speed", "hardening"), [(2.0, e), (14.0, 1 + 5 * 400 * 14**2 / (4e5 * 0.03))])
def test_substeps_know_how_hard_snow_gets_where_it_is_hit(speed: float, hardening: float) -> None:
    """Crushed until its work E crush (h - 1) / 10 is rho v^2 / 2, it is h times as stiff; e times at least."""
    snow = "material: {density: 400, youngs_modulus: 4.0e5, crush: 0.03, crumble: 0.014, poisson_ratio: 0.2}"
    case = resolve(
        f"  a: {CUBE.replace('soft', 'snow')}, {snow}}}",
        "gravity: [0, 0, 0]",
        f"actions: {{controls: {{go: {{kind: initial_velocity, body: a, linear: [{speed}, 0, 0]}}}}}}",
    )
    step_s, cell = 0.01 / case.settings.substeps, mpm(case).cell
    sound = sqrt(4e5 * hardening * 0.8 / (1.2 * 0.6 * 400))
    assert 0.45 * cell < sound * step_s <= 0.5 * cell


def test_snow_that_falls_is_hit_at_the_speed_of_its_fall() -> None:
    fall = "a: {kind: snow, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0, 0, 2]}}"
    assert (settings := resolve(f"  {fall}", FLOOR).settings.soft) is not None
    assert settings.impact == pytest.approx(sqrt(2 * 9.81 * 2.1))


def test_substeps_keep_a_viscous_liquid_stable() -> None:
    """Within a substep s a viscosity is a shear modulus of `viscosity / s`."""
    case = resolve(
        f"  a: {CUBE.replace('soft', 'liquid')}, material: {{density: 1400, viscosity: 500, stiffness: 1e5}}}}"
    )
    step_s, cell = 0.01 / case.settings.substeps, mpm(case).cell
    assert 0.45 * cell < sqrt((1e5 + 2 * 500 / step_s) / 1400) * step_s <= 0.5 * cell


def test_a_liquid_so_viscous_that_sound_does_not_matter_has_a_step() -> None:
    """For a large nu = viscosity / density, the step is (cell / 2)^2 / (2 nu): what diffuses half a cell."""
    liquid = Liquid.model_validate({"kind": "liquid", "shape": {"kind": "sphere", "radius": 0.1}})
    material = liquid.material.model_copy(update={"viscosity": 1e15})
    assert sound_step(material, liquid, 0.02, 0.0) == pytest.approx(0.01**2 / (2 * 1e15 / 1000), rel=1e-9)


def test_substeps_keep_gas_in_a_hull_stable() -> None:
    """A sphere breathes at sqrt(3 K / (R m))."""
    ball = "  a: {kind: cloth, shape: {kind: sphere, radius: 0.2}, material: {area_density: 0.3, gas_modulus: 1e5}}"
    case = resolve(ball)
    assert 0.4 < 0.01 / case.settings.substeps * sqrt(3 * 1e5 / (0.2 * 0.3)) <= 0.51


@pytest.mark.parametrize("shape", ["{kind: sheet, size: [1, 1]}", "{kind: disc, radius: 1}"])
def test_what_is_open_holds_no_gas(shape: str) -> None:
    with pytest.raises(SpecError, match="encloses no gas"):
        resolve(f"  a: {{kind: cloth, shape: {shape}, material: {{pressure: 10}}}}")


def test_an_elastic_sheet_gets_the_substeps_and_sweeps_of_its_material() -> None:
    """It needs `K = 2 E t h^2 / (w m c^2)` sweeps of relaxation w = 0.3, and draws together at `e sqrt(2 E t / m)`."""
    band = "  a: {kind: cloth, cell: 0.01, shape: {kind: sleeve, radius: 0.1, height: 0.03}, material: {area_density: 1, youngs_modulus: 1.0e+6, %s}}"
    still, taut = resolve(band % "thickness: 0.001"), resolve(band % "prestretch: 1.6")
    for case, snap in ((still, 0.0), (taut, 0.6 * sqrt(2 * 1000))):
        soft = case.settings.soft
        assert soft is not None and soft.pbd is not None
        h = 0.01 / case.settings.substeps
        assert soft.pbd.stretch_iterations >= 2 * 1000 * h**2 / (0.3 * 1 * 0.01**2)
        assert h * snap <= 0.01 / 2 * 1.001
        assert soft.max_speed > 4 * snap
    assert taut.plan.deformables["a"].elastic == (1000, 1.6, (0, 0, 1)), "a sleeve is stretched around, and not along"
    flat = resolve(band.replace("sleeve, radius: 0.1, height: 0.03", "sheet, size: [0.1, 0.1]") % "prestretch: 1.6")
    assert flat.plan.deformables["a"].elastic == (1000, 1.6, None)


@pytest.mark.parametrize(("material", "message"), [
    ("prestretch: 1.5", "prestretch needs a youngs_modulus"),
    ("youngs_modulus: 1.0e+6, stretch_compliance: 1.0e-6", "either material.youngs_modulus or"),
])  # fmt: skip
def test_what_an_elastic_sheet_cannot_have(material: str, message: str) -> None:
    with pytest.raises(SpecError, match=message):
        resolve(f"  a: {{kind: cloth, shape: {{kind: disc, radius: 1}}, material: {{{material}}}}}")


def test_bounds_follow_a_stream() -> None:
    tap = "  a: {kind: liquid, shape: {kind: stream, radius: 0.02, speed: %g, duration: 1, direction: [1, 0, 0]}, pose: {pos: [0, 0, 0.5]}}"
    slow, fast = mpm(resolve(tap % 0.1)), mpm(resolve(tap % 3))
    assert fast.high[0] > slow.high[0] + 2.9 * sqrt(2 * 0.5 / 9.81) * 0.9
    assert slow.cell == pytest.approx(0.01), "four cells across"


def test_bounds_hold_the_start_the_fall_and_the_walls_of_the_grid() -> None:
    case = resolve(f"  a: {CUBE}}}")
    found = mpm(case)
    assert found.low[2] <= -4 * found.cell + 1e-9, "it rests on the floor, not on the grid's wall"
    assert found.low[2] > -8 * found.cell
    assert found.high[2] > 0.35 + 4 * found.cell
    assert all(value / found.cell == pytest.approx(round(value / found.cell)) for value in (*found.low, *found.high))
    above = resolve(
        f"  a: {CUBE}}}", "statics: {table: {shape: {kind: box, size: [1, 1, 0.1]}, pose: {pos: [0, 0, 0.05]}}}"
    )
    assert mpm(above).low[2] <= -4 * found.cell + 1e-9, "what slips off a table is followed to its foot"


def test_bounds_follow_what_throws_carries_and_pushes() -> None:
    still = mpm(resolve(f"  a: {CUBE}}}"))
    thrown = mpm(
        resolve(
            f"  a: {CUBE}}}", actions="actions: {controls: {go: {kind: initial_velocity, body: a, linear: [3, 0, 0]}}}"
        )
    )
    assert thrown.high[0] > still.high[0] + 1.0
    assert thrown.low[0] == pytest.approx(still.low[0], abs=2 * still.cell)
    slider = """  hook:
    kind: rigid
    shape: {kind: sphere, radius: 0.02}
    pose: {pos: [0, 0, 0.7]}
    material: {touch_soft: false}
    mount: {kind: slider, axis: x, actuator: {stiffness: 100, damping: 10}}"""
    held = "hang: {kind: attach, body: a, region: {edge: back}, to: hook}"
    drive = "move: {kind: drive, joint: hook, position: {kind: ramp, start: 0, end: 1, to: -1.5}}"
    before = pbd(resolve(f"  a: {SHEET}\n{slider}", actions=f"actions: {{controls: {{{held}}}}}"))
    after = pbd(resolve(f"  a: {SHEET}\n{slider}", actions=f"actions: {{controls: {{{held}, {drive}}}}}"))
    assert after.low[0] < before.low[0] - 1.4
    assert after.high[0] == pytest.approx(before.high[0], abs=0.02)
    far, stopped = drive.replace("-1.5", "-5"), slider.replace("axis: x", "axis: x, range: [-4, 0]")
    after = pbd(resolve(f"  a: {SHEET}\n{stopped}", actions=f"actions: {{controls: {{{held}, {far}}}}}"))
    assert after.low[0] == pytest.approx(before.low[0] - 4, abs=0.1), "as far as it is driven, up to its stop"


@pytest.mark.parametrize(("mount", "far"), [("{kind: fixed}", 0.0), ("{kind: free}", 2.0)])
def test_a_sail_takes_along_what_is_free(mount: str, far: float) -> None:
    """It is blown to the other side, 2 sqrt(0.4^2 + 0.2^2) m at most; a free boat goes on, and is followed for 2 m."""
    boat = f"  boat: {{kind: rigid, shape: {{kind: box, size: [0.2, 0.2, 0.1]}}, mount: {mount}, pose: {{pos: [0, 0, 0.4]}}}}"
    tie = "tie: {kind: attach, body: sail, region: {edge: left}, to: boat}"
    blow = "blow: {kind: airflow, body: sail, velocity: [0, -6, 0]}"
    still = pbd(resolve(f"  sail: {SHEET}\n{boat}", FLOOR, f"actions: {{controls: {{{tie}}}}}"))
    blown = pbd(resolve(f"  sail: {SHEET}\n{boat}", FLOOR, f"actions: {{controls: {{{tie}, {blow}}}}}"))
    assert still.low[1] - blown.low[1] == pytest.approx(2 * sqrt(0.4**2 + 0.2**2) + far, abs=0.02)


def test_a_cloth_hangs_below_what_stands_lowest() -> None:
    peg = "  peg: {kind: rigid, mount: {kind: fixed}, shape: {kind: box, size: [0.02, 0.2, 0.04]}, pose: {pos: [0.25, 0, 0.5]}}"
    assert pbd(resolve(f"  a: {SHEET}\n{peg}", "gravity: [0, 0, -9.81]")).low[2] < 0.5 - 0.4


def test_what_is_held_throughout_does_not_fall() -> None:
    """Nothing is below the cube: only the length of its diagonal has room there, unless it is let go or can tear."""
    tie = "tie: {kind: attach, body: a, region: {face: bottom}, to: world}"

    def lowest(controls: str, more: str = "") -> float:
        return mpm(resolve(f"  a: {CUBE}{more}}}", "", f"actions: {{controls: {{{controls}}}}}")).low[2]

    cell = mpm(resolve(f"  a: {CUBE}}}", "")).cell
    assert 0.25 - 0.1 * sqrt(3) - 6 * cell < lowest(tie) < 0.25 - 0.1 * sqrt(3)
    assert lowest(f"{tie}, let_go: {{kind: release, attach: tie, at: 0.5}}") < -0.5
    assert lowest(tie, ", material: {tear_stretch: 1.3}") < -0.5
    box = "shape: {kind: box, size: [0.2, 0.2, 0.1]}, pose: {pos: [0, 0, 0.19]}}"
    for holder, firm in (("", False), ("mount: {kind: slider, axis: z}, ", False), ("mount: {kind: fixed}, ", True)):
        bodies = f"  a: {CUBE}}}\n  b: {{kind: rigid, material: {{touch_soft: false}}, {holder}{box}"
        held = mpm(resolve(bodies, "", f"actions: {{controls: {{{tie.replace('world', 'b')}}}}}")).low[2]
        assert (held > -0.5) == firm


def test_bounds_follow_what_is_carried_and_pushed_ahead() -> None:
    def x_of(kind: str, pos: str, size: str) -> float:
        solid = f"""  plate:
    kind: driven
    shape: {{kind: box, size: {size}}}
    pose: {{pos: {pos}}}
    motion: {{kind: waypoints, times: [0, 1], positions: [[0, 0, 0], [0.8, 0, 0]]}}"""
        return mpm(resolve(f"  a: {CUBE.replace('soft', kind)}, cell: 0.02}}\n{solid}")).high[0]

    far = x_of("soft", "[0, 3, 0.1]", "[0.4, 0.4, 0.1]")
    assert x_of("soft", "[0, 0, 0.195]", "[0.4, 0.4, 0.1]") == pytest.approx(far + 0.8, abs=0.03), "it lies on a tray"
    assert x_of("soft", "[-0.3, 0, 0.2]", "[0.1, 0.4, 0.4]") > far + 0.4, "it is in front of a blade"
    assert x_of("snow", "[-0.3, 0, 0.2]", "[0.1, 0.4, 0.4]") < x_of("soft", "[-0.3, 0, 0.2]", "[0.1, 0.4, 0.4]")


def test_sand_on_a_board_with_a_hinge_needs_room_to_slide_off() -> None:
    sand = (
        "{kind: granular, cell: 0.02, shape: {kind: cylinder, radius: 0.1, height: 0.1}, pose: {pos: [-0.3, 0, 0.115]}}"
    )
    board = "{kind: rigid, shape: {kind: box, size: [0.8, 0.4, 0.06]}, pose: {pos: [-0.1, 0, 0.03]}%s}"
    fixed, hinged = (
        mpm(resolve(f"  a: {sand}\n  board: {board % mount}"))
        for mount in ("", ", mount: {kind: hinge, axis: y, anchor: [0.4, 0, 0]}")
    )
    assert hinged.high[0] > 0.3 + 0.4, "its end, and half of its length"
    assert fixed.high[0] < 0.2
    assert hinged.high[1] < 0.2 + 0.4


def test_sand_needs_the_room_of_its_run_out() -> None:
    """A column of aspect 1 runs out by 1.24 of its height (Lube et al. 2004), not by what it fell."""
    sand = "{kind: granular, cell: 0.02, shape: {kind: cylinder, radius: 0.1, height: 0.1}, pose: {pos: [0, 0, 0.05]}}"
    assert mpm(resolve(f"  a: {sand}")).high[0] == pytest.approx(0.1 + 0.124 + 4 * 0.02, abs=0.02)


def test_a_run_stops_at_what_the_scene_cannot_give() -> None:
    def limit(actions: str = "", scene: str = FLOOR) -> float:
        return resolve(f"  a: {CUBE}}}", scene, actions).plan.max_speed

    fall = sqrt(2 * 9.81 * 0.35)
    assert limit() == pytest.approx(5 * fall + 10, rel=0.05)
    thrown = "actions: {controls: {go: {kind: initial_velocity, body: a, linear: [30, 0, 0]}}}"
    assert limit(thrown) == pytest.approx(5 * (fall + 30) + 10, rel=0.05)
    blown = "actions: {controls: {go: {kind: wind, direction: x, acceleration: 4}}}"
    assert limit(blown) == pytest.approx(5 * (fall + 4) + 10, rel=0.05)
    cart = "{kind: rigid, shape: {kind: sphere, radius: 0.1}, mount: {kind: slider, axis: x, initial_velocity: -60}}"
    assert resolve(f"  a: {CUBE}}}\n  cart: {cart}").plan.max_speed == pytest.approx(5 * (fall + 60) + 10, rel=0.05)
    assert limit(scene=f"max_speed: 300, {FLOOR}") == 300
    assert limit(scene="gravity: [0, 0, 0]") == 10
    rigid = resolve("  a: {kind: rigid, shape: {kind: sphere, radius: 0.1}}")
    assert rigid.plan.max_speed == 1000


def test_what_soft_bodies_do_not_touch_needs_no_room() -> None:
    wall = "wall: {shape: {kind: box, size: [3, 0.1, 2]}, pose: {pos: [0, 0.2, 0]}%s}"
    near, far, alone = (
        mpm(resolve(f"  a: {CUBE}}}", f"statics: {{floor: {{shape: {{kind: plane}}}}{also}}}"))
        for also in (", " + wall % "", ", " + wall % ", material: {touch_soft: false}", "")
    )
    assert (far.low, far.high) == (alone.low, alone.high)
    assert near.high[0] > alone.high[0]


def test_honey_spreads_as_a_viscous_current_and_water_as_a_splash() -> None:
    """Huppert (1982): R = 0.894 (g V^3 / (3 nu))^(1/8) t^(1/8); half as much again is spare. Water has more room."""
    drop = "{kind: liquid, shape: {kind: box, size: [0.06, 0.06, 0.06]}, pose: {pos: [0, 0, 0.2]}, material: {viscosity: %s}}"
    honey, water = (mpm(resolve(f"  a: {drop % viscosity}")) for viscosity in (10, 0))
    nu = 10 / 1000
    radius = 0.894 * (9.81 * 0.06**9 / (3 * nu)) ** 0.125
    margin = 4 * honey.cell
    assert honey.high[0] == pytest.approx(0.03 + 1.5 * radius + margin, abs=honey.cell)
    assert water.high[0] == pytest.approx(0.03 + 1.5 * (0.06 + 0.17) + margin, abs=water.cell)


def test_bounds_can_be_said() -> None:
    case = resolve(f"  a: {CUBE}}}", f"mpm: {{bounds: {{min: [-1, -1, -0.1], max: [1, 1, 1]}}}}, {FLOOR}")
    assert mpm(case).low == (-1.0, -1.0, -0.1)
    assert "mpm_bounds" not in case.settings.soft.why  # type: ignore[union-attr]


def test_sap_has_double_precision_and_a_floor_of_its_own() -> None:
    case = resolve(f"  a: {CUBE}, solver: fem}}", "statics: {floor: {shape: {kind: plane}, pose: {pos: [0, 0, 0.1]}}}")
    soft = case.settings.soft
    assert soft is not None and soft.fem is not None and soft.sap is not None
    assert (soft.precision, soft.fem.floor, soft.sap.floor, soft.sap.rigid) == ("64", 0.1, True, False)
    assert case.plan.statics[0].entities[0].options["collision"] is False
    bare = resolve(f"  a: {CUBE}, solver: fem}}", "statics: {}").settings.soft
    assert bare is not None and bare.sap is not None and not bare.sap.floor


def test_damping_of_fem_bodies_goes_to_their_solver() -> None:
    case = resolve(f"  a: {CUBE}, solver: fem, material: {{damping: 3.0}}}}")
    assert case.settings.soft is not None and case.settings.soft.fem is not None
    assert case.settings.soft.fem.damping_alpha == 3.0


def test_reasons_are_told() -> None:
    notes = resolve(f"  a: {CUBE}}}\n  b: {SHEET}").settings.notes()
    for name in (
        "model = particle",
        "mpm_cell = 0.02 m",
        "mpm_bounds = [",
        "pbd_size = 0.005 m",
        "stretch_iterations = 16: its own weight then stretches a cloth that hangs by 0.7%",
    ):
        assert any(note.startswith(name) for note in notes), name


@pytest.mark.parametrize(
    ("cell", "scene", "iterations"),
    [(0.02, "", 4), (0.01, "", 4), (0.007, "", 8), (0.005, "", 16), (0.003, "", 32), (0.005, "gravity: [0, 0, 0], ", 4),
     (0.005, "substeps: 20, ", 4), (0.005, "substeps: 5, ", 32), (0.005, "pbd: {stretch_iterations: 5}, ", 5)],
)  # fmt: skip
def test_finer_cloth_gets_more_sweeps(cell: float, scene: str, iterations: int) -> None:
    """A sheet of 0.5 m: 3 g h^2 L / (n c^2) is 1 % for 4 sweeps of 9.5 mm in substeps of 0.5 ms."""
    sheet = f"{{kind: cloth, cell: {cell}, shape: {{kind: sheet, size: [0.1, 0.5]}}, pose: {{pos: [0, 0, 1]}}}}"
    assert pbd(resolve(f"  a: {sheet}", f"dt: 0.005, {scene}{FLOOR}")).stretch_iterations == iterations


def test_soft_scenes_are_recorded_less_often() -> None:
    assert resolve(f"  a: {CUBE}}}").plan.every == 2
    assert resolve("  a: {kind: rigid, shape: {kind: sphere, radius: 0.1}}").plan.every == 1
    said: dict[str, Any] = {"scene": f"record: {{rate: 100}}, {FLOOR}"}
    assert resolve(f"  a: {CUBE}}}", **said).plan.every == 1


def test_a_ram_that_waits_for_an_event_needs_the_room_of_its_drive() -> None:
    ram = """  ram:
    kind: rigid
    shape: {kind: box, size: [0.1, 0.4, 0.4]}
    pose: {pos: [-0.3, 0, 0.2]}
    mount: {kind: slider, axis: x, actuator: {stiffness: 9000, damping: 900}}"""

    def x_of(on: str) -> float:
        drive = f"{{kind: drive, joint: ram, {on}position: {{kind: ramp, from: 0, to: 1.5, end: 0.8}}}}"
        fell = (
            "measures: {z: {kind: position, of: a, axis: z}}, events: {fell: {kind: threshold, measure: z, below: 0.1}}"
        )
        return mpm(resolve(f"  a: {CUBE}}}\n{ram}", FLOOR, f"actions: {{controls: {{go: {drive}}}, {fell}}}")).high[0]

    assert x_of("on: fell, ") == x_of("") > 1.0
