"""What holds for every program: plain imports, same bytes, and no word of the author that becomes code."""

import ast
import json
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from text2sim.compiler.build import compile_case, plan_case
from text2sim.compiler.emit import COPIED_MODULES, COPIED_SOFT, MODULES
from text2sim.compiler.emit_actions import COPIED_ACTIONS
from text2sim.compiler.literal import Code, comment, identifier, literal
from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.load import load_case

SOMETIMES = (
    "ipc_coupler.py",
    "cloth_on_grid.py",
    "cloth_friction.py",
    "bending.py",
    "elastic_sheets.py",
    "corotated.py",
    "damp_sand.py",
    "hardening_snow.py",
    "viscous_liquid.py",
    "solid_walls.py",
    "grid_step.py",
    "singular_values.py",
    "threads.py",
    "transfers.py",
    "liquid_volume.py",
    "adhesion.py",
    "coils.py",
    "spring_film.py",
)
PROGRAM = (*MODULES, *COPIED_MODULES, *COPIED_SOFT, *COPIED_ACTIONS, *SOMETIMES)
# `quadrants`, the compiler of the engine, and `torch` come with it.
ALLOWED = {
    "genesis",
    "quadrants",
    "numpy",
    "torch",
    "av",
    "PIL",
    *(Path(n).stem for n in PROGRAM),
    *sys.stdlib_module_names,
}

CASE = """\
text2sim: 1
name: probe
prompt: "'''); import os; os.system('x') #"
scene: {duration: 1.0, statics: {floor: {shape: {kind: plane}}}}
bodies:
  ball:
    kind: rigid
    shape: {kind: sphere, radius: 0.1}
    pose: {pos: [0, 0, 1]}
  class:
    kind: rigid
    shape: {kind: capsule, radius: 0.1, length: 0.2}
    pose: {pos: [1, 0, 1]}
"""


def test_damping_of_free_bodies_is_in_programs_that_have_it_alone(tmp_path: Path) -> None:
    damped = CASE.replace(
        "radius: 0.1}\n",
        "radius: 0.1}\n    mount: {kind: free, damping: 0.5}\n    repeat: {kind: line, count: 2, step: [0, 1, 0]}\n",
        1,
    )
    for text, rates in ((CASE, None), (damped, {"ball[0]": 0.5, "ball[1]": 0.5})):
        compile_case(load_case(write(tmp_path, text)), tmp_path / "program")
        source = (tmp_path / "program" / "bodies.py").read_text()
        found = [node.value for node in ast.parse(source).body if isinstance(node, ast.Assign) and node.targets[0].id == "DAMPED"]  # type: ignore[attr-defined]  # fmt: skip
        assert [ast.literal_eval(value) for value in found] == ([] if rates is None else [rates])
        assert ("set_dofs_damping" in source) == (rates is not None)


def write(folder: Path, text: str) -> Path:
    (folder / "case.yaml").write_text(text)
    return folder


def test_program_imports_engine_numpy_and_standard_library_only(cases: Path, tmp_path: Path) -> None:
    for case in sorted(path.parent for path in cases.glob("*/case.yaml")):
        compile_case(load_case(case), tmp_path / case.name)
    for module in tmp_path.rglob("*.py"):
        for node in ast.walk(ast.parse(module.read_text())):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert {name.split(".")[0] for name in names} <= ALLOWED, module


SHEETS = """\
text2sim: 2
name: stiff
scene: {duration: 1, statics: {floor: {shape: {kind: plane}}}}
bodies:
  plain: {kind: cloth, cell: 0.05, shape: {kind: sheet, size: [0.5, 0.5]}, pose: {pos: [0, 0, 1]}}
  card: {kind: cloth, shape: {kind: sheet, size: [0.5, 0.5]}, material: {rigidity: 0.001}, pose: {pos: [0, 1, 1]}}
  foil: {kind: cloth, shape: {kind: sheet, size: [0.5, 0.5], sag: 0.1}, material: {crease_radius: 0.05, rest_shape: start}, pose: {pos: [0, 2, 1]}}
"""
SANDS = """\
text2sim: 2
name: damp
scene: {duration: 1, statics: {floor: {shape: {kind: plane}}}}
bodies:
  sand: {kind: granular, repeat: {kind: line, count: 2, step: [1, 0, 0]}, cell: 0.03, shape: {kind: box, size: [0.2, 0.2, 0.2]}, material: {cohesion: "${%s}"}, pose: {pos: [0, 0, 0.2]}}
"""


def test_bending_of_sheets_that_ask_for_it(tmp_path: Path) -> None:
    compile_case(load_case(write(tmp_path, SHEETS)), tmp_path / "program")
    bodies = (tmp_path / "program" / "bodies.py").read_text()
    assert '"card": (0.001, None, False)' in bodies
    assert '"foil": (None, 0.05, True)' in bodies
    assert '"plain": (' not in bodies
    assert (tmp_path / "program" / "bending.py").is_file()


@pytest.mark.parametrize("cohesion", ["500 * i", "500 - 500 * i"])
def test_all_copies_of_damp_sand_have_its_law(tmp_path: Path, cohesion: str) -> None:
    compile_case(load_case(write(tmp_path, SANDS % cohesion)), tmp_path / "program")
    bodies = (tmp_path / "program" / "bodies.py").read_text()
    assert "material=DampSand(" in bodies
    assert "MPM.Sand" not in bodies
    assert (tmp_path / "program" / "damp_sand.py").is_file()


TOFU = """\
text2sim: 2
name: tofu
scene: {duration: 1, statics: {floor: {shape: {kind: plane}}}}
bodies:
  tofu: {kind: soft, shape: {kind: box, size: [0.1, 0.1, 0.1]}, material: {%s}, pose: {pos: [0, 0, 0.1]}}
"""


def test_a_solid_that_tears_has_its_own_law_and_record(tmp_path: Path) -> None:
    compile_case(load_case(write(tmp_path, TOFU % "tear_stretch: 1.2")), tmp_path / "program")
    assert "tear_stretch=1.2" in (tmp_path / "program" / "bodies.py").read_text()
    assert "recorder = TearRecorder(" in (tmp_path / "program" / "main.py").read_text()
    assert (tmp_path / "program" / "tearing_solid.py").is_file()
    compile_case(load_case(write(tmp_path, TOFU % "")), tmp_path / "plain")
    assert "Tear" not in (tmp_path / "plain" / "main.py").read_text() + (tmp_path / "plain" / "bodies.py").read_text()


BALLOON = """\
text2sim: 2
name: balloon
scene: {duration: 1, statics: {floor: {shape: {kind: plane}}}}
bodies:
  balloon: {kind: cloth, shape: {kind: sphere, radius: 0.2}, material: {pressure: 300, gas_modulus: 1000}, pose: {pos: [0, 0, 0.4]}}
"""


def test_gas_acts_in_each_substep(tmp_path: Path) -> None:
    plan = compile_case(load_case(write(tmp_path, BALLOON)), tmp_path / "program")
    assert '"balloon": (300.0, 1000.0)' in (tmp_path / "program" / "bodies.py").read_text()
    assert "for name, row in GASES.items()" in (tmp_path / "program" / "actions.py").read_text()
    assert (tmp_path / "program" / "points.py").is_file()
    assert plan.deformables["balloon"].mass == pytest.approx(0.3 * 4 * 3.14159 * 0.2**2, rel=0.02)


STREAMS = """\
text2sim: 2
name: taps
scene: {duration: 1, statics: {floor: {shape: {kind: plane}}}}
bodies:
  tap: {kind: liquid, repeat: {kind: line, count: 2, step: [1, 0, 0]}, shape: {kind: stream, radius: 0.03, speed: 1, duration: 0.5}, material: {viscosity: "${i}"}, pose: {pos: [0, 0, 0.4]}}
"""


def test_streams_flow_before_each_step(tmp_path: Path) -> None:
    compile_case(load_case(write(tmp_path, STREAMS)), tmp_path / "program")
    bodies = (tmp_path / "program" / "bodies.py").read_text()
    assert 'Nowhere(n_particles=len(STREAMS[f"tap[{i}]"]))' in bodies
    assert '"stream": STREAMS["tap[1]"]' in bodies
    assert "ViscousLiquid(" in bodies
    assert "MPM.Liquid" not in bodies, "all copies are of one class"
    assert "Flows(scene, STREAMS, bodies, DT)," in (tmp_path / "program" / "actions.py").read_text()


FOAM = """\
text2sim: 2
name: foam
scene: {duration: 1, statics: {floor: {shape: {kind: plane}}}}
bodies:
  dab: {kind: soft, repeat: {kind: line, count: 2, step: [1, 0, 0]}, shape: {kind: box, size: [0.1, 0.1, 0.1]}, material: {model: elasto_plastic, yield_stress: 300, viscosity: "${20 * i}"}, pose: {pos: [0, 0, 0.1]}}
"""


def test_plastic_solids_with_a_viscosity_know_their_substep(tmp_path: Path) -> None:
    compile_case(load_case(write(tmp_path, FOAM)), tmp_path / "program")
    bodies = (tmp_path / "program" / "bodies.py").read_text()
    assert "from viscoplastic import Viscoplastic" in bodies
    assert "from scene import DT" in bodies
    assert "substep=DT / " in bodies
    assert "MPM.ElastoPlastic" not in bodies, "all copies are of one class"
    assert (tmp_path / "program" / "viscoplastic.py").exists()


def test_same_case_same_bytes(tmp_path: Path) -> None:
    case = load_case(write(tmp_path, CASE))
    compile_case(case, tmp_path / "a")
    compile_case(load_case(tmp_path), tmp_path / "b")
    read = [{p.name: p.read_bytes() for p in sorted((tmp_path / x).rglob("*")) if p.is_file()} for x in "ab"]
    assert read[0] == read[1]


def test_keywords_are_fine_as_names_and_prompts_stay_out_of_the_program(tmp_path: Path) -> None:
    compile_case(load_case(write(tmp_path, CASE)), tmp_path / "program")
    text = "".join(p.read_text() for p in (tmp_path / "program").glob("*.py"))
    assert "def add_class(scene)" in text
    assert "os.system" not in text


def test_entities_carry_the_line_of_the_case(tmp_path: Path) -> None:
    compile_case(load_case(write(tmp_path, CASE)), tmp_path / "program")
    bodies = (tmp_path / "program/bodies.py").read_text()
    assert "# case.yaml:6\n" in bodies
    assert "# case.yaml:10\n" in bodies


def test_looks_and_film_do_not_change_what_is_simulated(tmp_path: Path) -> None:
    base = plan_case(load_case(write(tmp_path, CASE)))
    painted = plan_case(load_case(write(tmp_path, CASE + "    look: {color: red}\nrender: {fps: 50}\n# a remark\n")))
    heavier = plan_case(load_case(write(tmp_path, CASE + "    material: {density: 2000}\n")))
    assert base.sim_digest == painted.sim_digest != heavier.sim_digest
    assert base.render_digest != painted.render_digest


def test_colours_of_model_files_are_looks(tmp_path: Path) -> None:
    """Compounds, mounts and mechanisms go to the engine as MJCF, which has colours in it."""
    gate = CASE + (
        "  gate:\n    kind: rigid\n    mount: {kind: hinge, axis: z}\n    pose: {pos: [0, 3, 1]}\n    look: {color: teal}\n"
        "    shape: {kind: box, size: [0.1, 1, 1]}\n"
    )
    teal = plan_case(load_case(write(tmp_path, gate)))
    red = plan_case(load_case(write(tmp_path, gate.replace("teal", "red"))))
    wide = plan_case(load_case(write(tmp_path, gate.replace("[0.1, 1, 1]", "[0.2, 1, 1]"))))
    assert any(path.endswith(".xml") for path in teal.files)
    assert teal.sim_digest == red.sim_digest != wide.sim_digest
    assert teal.render_digest != red.render_digest


@pytest.mark.parametrize("value", [float("nan"), float("inf"), object(), {1, 2}, b"x"])
def test_what_has_no_literal_is_refused(value: object) -> None:
    with pytest.raises((TypeError, ValueError)):
        literal(value)


def test_a_crowd_that_no_machine_can_hold_is_refused(tmp_path: Path) -> None:
    crowd = "pose: {pos: [0, 0, 1]}\n    repeat: {kind: line, count: 30000, step: [1, 0, 0]}"
    with pytest.raises(SpecError, match="convex pieces") as caught:
        plan_case(load_case(write(tmp_path, CASE.replace("pose: {pos: [0, 0, 1]}", crowd))))
    assert [problem.path for problem in caught.value.problems] == ["/bodies/ball"]


@pytest.mark.parametrize("resolution", [(1280, 720), (720, 1280)])
def test_a_derived_camera_just_sees_everything(tmp_path: Path, resolution: tuple[int, int]) -> None:
    row = "pose: {pos: [-3, 2, 1]}\n    repeat: {kind: line, count: 7, step: [1, 0, 0]}"
    text = CASE.replace("pose: {pos: [0, 0, 1]}", row) + f"render: {{resolution: {list(resolution)}}}\n"
    (camera,) = plan_case(load_case(write(tmp_path, text))).render["cameras"].values()
    forward = np.subtract(camera["look_at"], camera["pos"])
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, (0, 0, 1)) / np.linalg.norm(np.cross(forward, (0, 0, 1)))
    balls = np.array([(i - 3, 2, z) for i in range(7) for z in (0.0, 1.0)] + [(1, 0, 0.0), (1, 0, 1.0)])
    seen = balls - camera["pos"]
    slope = math.tan(math.radians(camera["fov"] / 2))
    across = np.abs(seen @ right) / (seen @ forward) / slope / (resolution[0] / resolution[1])
    along = np.abs(seen @ np.cross(right, forward)) / (seen @ forward) / slope
    assert 0.6 < max(across.max(), along.max()) < 0.95


@pytest.mark.parametrize(
    "value",
    ["'); import os #", '"""', "\\", "\n", "{{ x }}", "\u2028", 0.1, -0.0, 10**30, (1,), [], {"a": (1.5, None)}],
)
def test_literals_come_back_as_they_were(value: object) -> None:
    assert ast.literal_eval(literal(value)) == value


def test_only_our_own_text_is_code() -> None:
    assert literal(Code("a + b")) == "a + b"
    assert literal("a + b") == "'a + b'"
    with pytest.raises(ValueError, match="identifier"):
        identifier("a\nimport os")
    assert "\n" not in comment("a\nimport os") and '"' not in comment('"""')


STAND_INS = {
    "genesis.py": "cpu = gpu = None\nclass GenesisException(Exception): pass\n",
    "actions.py": "class Actions:\n    def __init__(self, *given): pass\n",
    "bodies.py": "def add_bodies(scene): return {}\ndef configure(bodies): pass\n",
    "film.py": "class NoOpenGL(Exception): pass\nadd_cameras = film = vis_options = lambda *given: {}\n",
    "scene.py": "DT = MAX_SPEED = RECORD_EVERY = STEPS = 1\nadd_statics = make_scene = start_engine = lambda given: {}\n",
    "recorder.py": """\
import signal
from contextlib import suppress

class Divergence(Exception): pass

class Progress:
    def __init__(self, out): pass
    def __call__(self, *given, **named): pass

Recorder = None

def build(scene):
    with suppress(BaseException):
        signal.raise_signal(signal.SIGTERM)
""",
}


@pytest.mark.usefixtures("engine")
@pytest.mark.skipif(sys.platform == "win32", reason="signals of other systems")
def test_a_signal_that_the_engine_swallows_stops_the_program_all_the_same(tmp_path: Path) -> None:
    compile_case(load_case(write(tmp_path, CASE)), tmp_path)
    for name, text in STAND_INS.items():
        (tmp_path / name).write_text(text)
    done = subprocess.run([sys.executable, "main.py", "--out", "out"], cwd=tmp_path, timeout=60, check=False)
    assert done.returncode == 130
    assert json.loads((tmp_path / "out" / "status.json").read_text())["state"] == "interrupted"


@pytest.mark.parametrize(
    ("target", "wanted"),
    [
        (
            "position: {kind: constant, value: 0.3, start: 1.0}",
            [(0.0, "constant(value=0.0)"), (1.0, "constant(value=0.3)")],
        ),
        ("velocity: {kind: steps, times: [0.5, 0.8], values: [1, 2]}", [(0.0, "constant(value=0.0)"), (0.5, "steps(")]),
        ("position: {kind: ramp, to: 0.3, start: 1.0, end: 2.0}", [(0.0, "ramp(start=1.0")]),
        (
            "position: {kind: ramp, from: 0.2, to: 0.3, start: 1.0, end: 2.0}",
            [(0.0, "constant(value=0.0)"), (1.0, "ramp(start=1.0")],
        ),
        ("velocity: {kind: ramp, from: 0, to: 3, start: 1.0, end: 2.0}", [(0.0, "ramp(start=1.0")]),
        ("force: 2.0", [(0.0, "constant(value=2.0)")]),
    ],
)
def test_a_joint_is_held_until_its_first_drive_begins(tmp_path, target, wanted):
    (tmp_path / "case.yaml").write_text(
        "text2sim: 2\nname: probe\nscene: {duration: 3}\nbodies:\n  arm: {kind: rigid, shape: {kind: box, size: [1, 1, 1]}, "
        "mount: {kind: hinge, actuator: {stiffness: 9, damping: 9}}}\n"
        f"actions: {{controls: {{go: {{kind: drive, joint: arm, {target}}}}}}}\n"
    )
    (drive,) = plan_case(load_case(tmp_path)).drives
    assert [segment.start for segment in drive.segments] == [start for start, _ in wanted]
    for segment, (_, code) in zip(drive.segments, wanted, strict=True):
        assert str(segment.target).startswith(code) or code in repr(segment.target)
