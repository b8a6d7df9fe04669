"""What absurd numbers do: scenes that no engine can be right about, and what is said of each, as a table.

    python benchmarks/absurd.py                    all that was not run yet, then the table
    python benchmarks/absurd.py --only pile_of_500 …   these again
    python benchmarks/absurd.py --all --docs       all again, and the table into docs/limits.md

Each scene has one expectation that only physics decides (nothing is lost below a floor, nothing gets faster by itself).
Where it is missed, something must have been said about why: by the lint before the run, by the end of the run, or by
the suspicions of its evidence. A row in which nobody said anything ends in **silent**, and the exit code is 1.
"""

import argparse
import json
import math
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

sys.path.insert(0, str(ROOT / "tests"))

import pytest  # noqa: E402
from warm_engine import WarmEngine  # noqa: E402

from benchmarks.softlab.documents import engine, keep, known, paste  # noqa: E402
from text2sim.compiler.build import compile_case, resolve_case  # noqa: E402
from text2sim.evidence.evidence import judge  # noqa: E402
from text2sim.lint import lint_case  # noqa: E402
from text2sim.spec_schema.errors import SpecError  # noqa: E402
from text2sim.spec_schema.load import load_case  # noqa: E402

HEAD = "text2sim: 2\nname: absurd\n"
FLOOR = "statics: {floor: {shape: {kind: plane}}}"
ABOVE = (
    "actions: {%smeasures: {z: {kind: position, of: ball, axis: z}}, "
    "expect: {stays: {measure: z, during: all, above: %s}}}\n"
)
CALM = (
    "actions: {%smeasures: {v: {kind: speed, of: %s}}, "
    "expect: {calm: {measure: v, during: all, stat: max, below: %s}}}\n"
)


@dataclass(frozen=True)
class Scene:
    """One absurdity."""

    words: str
    """What it is, for the table."""
    text: str
    """The case below its head."""
    wrong: str
    """What happens if the expectation is missed."""
    model: str = ""
    """The model file, for those that have one."""


def _fall(scene: str, ball: str, height: float, *, others: str = "", controls: str = "", below: float = 0.0) -> str:
    """Something called `ball` that must not be lost below a height."""
    bodies = f"bodies:\n  ball: {{kind: rigid, {ball}, pose: {{pos: [0, 0, {height}]}}}}\n{others}"
    return f"scene: {{duration: 1.0, {scene}}}\n{bodies}{ABOVE % (controls, below)}"


def _ball(radius: float = 0.05, mass: float = 1.0, friction: float = 0.5) -> str:
    return f"shape: {{kind: sphere, radius: {radius}}}, material: {{mass: {mass:g}, friction: {friction:g}}}"


def _box(name: str, size: str, z: float, mass: float, friction: float = 0.5) -> str:
    material = f"material: {{mass: {mass:g}, friction: {friction:g}}}"
    return f"  {name}: {{kind: rigid, shape: {{kind: box, size: {size}}}, {material}, pose: {{pos: [0, 0, {z}]}}}}\n"


def _plate(thickness: float, speed: float, extra: str = "") -> str:
    shape = f"shape: {{kind: box, size: [1, 1, {thickness:g}]}}, pose: {{pos: [0, 0, 1]}}"
    launch = f"controls: {{shot: {{kind: initial_velocity, body: ball, linear: [0, 0, -{speed:g}]}}}}, "
    return _fall(
        f"gravity: [0, 0, 0], {extra}statics: {{plate: {{{shape}}}}}", _ball(0.01), 1.3, controls=launch, below=0.9
    )


def _slope(friction: float, degrees: float) -> str:
    shape = f"shape: {{kind: box, size: [4, 1, 0.1]}}, pose: {{pos: [0, 0, 0.5], euler_deg: [0, {degrees:g}, 0]}}"
    statics = f"statics: {{ramp: {{{shape}, material: {{friction: {friction:g}}}}}}}"
    body = f"shape: {{kind: box, size: [0.1, 0.1, 0.1]}}, material: {{friction: {friction:g}}}"
    turn = math.radians(degrees)
    place = [round(0.1001 * math.sin(turn), 5), 0, round(0.5 + 0.1001 * math.cos(turn), 5)]
    pose = f"pose: {{pos: {place}, euler_deg: [0, {degrees:g}, 0]}}"
    bodies = f"bodies: {{crate: {{kind: rigid, {body}, {pose}}}}}\n"
    calm = CALM.replace("during: all", "during: [0.5, end]") % ("", "crate", 3.5 if friction < 0.1 else 0.05)
    return f"scene: {{duration: 1.0, {statics}}}\n{bodies}{calm}"


def _swing(dt: float, extra: str = "") -> str:
    mount = f"mount: {{kind: hinge, axis: y, anchor: [0, 0, 0.3]{extra}}}"
    pose = "pose: {pos: [0, 0, 2], euler_deg: [0, 90, 0]}"
    bob = f"kind: rigid, shape: {{kind: box, size: [0.05, 0.05, 0.6]}}, {mount}, {pose}"
    return f"scene: {{duration: 4.0, dt: {dt:g}}}\nbodies: {{ball: {{{bob}}}}}\n{CALM % ('', 'ball', 2.3)}"


def _geared(gear: float) -> str:
    joint = "mount: {kind: hinge, axis: z, actuator: {stiffness: %g, damping: %g}}"
    body = "kind: rigid, shape: {kind: box, size: [0.4, 0.05, 0.05]}, " + joint % (gear, gear / 10)
    drive = "controls: {go: {kind: drive, joint: ball, position: {kind: ramp, to: 1.0, start: 0.0, end: 0.5}}}, "
    bodies = f"bodies: {{ball: {{{body}, pose: {{pos: [0, 0, 0.5]}}}}}}\n"
    angle = "measures: {q: {kind: joint_position, of: ball}}, "
    expect = "expect: {follows: {measure: q, at: end, equals: 1.0, tolerance: 0.05}}"
    return f"scene: {{duration: 1.0, {FLOOR}}}\n{bodies}actions: {{{drive}{angle}{expect}}}\n"


def _model(inside: str) -> str:
    """An MJCF file of two turning arms of 1 kg, `slow` and `fast`, and what ties or drives them."""
    arms = "".join(
        f'<body name="{name}" pos="0 0 {z}"><joint name="{name}" axis="0 0 1"/>'
        f'<geom type="box" size="0.2 0.025 0.025" mass="1"/></body>'
        for name, z in (("slow", 0.5), ("fast", 0.8))
    )
    return f'<mujoco><compiler angle="radian"/><worldbody>{arms}</worldbody>{inside}</mujoco>'


def _tied(ratio: float) -> Scene:
    """Two arms of a file of which one turns `ratio` times as far as the other, which a motor turns by 1 rad."""
    tie = f'<equality><joint joint1="fast" joint2="slow" polycoef="0 {ratio:g} 0 0 0"/></equality>'
    motor = '<actuator><position joint="slow" kp="100" kv="10"/></actuator>'
    expect = (
        "follows: {measure: slow, at: end, equals: 1.0, tolerance: 0.05}, "
        f"tied: {{measure: fast, at: end, equals: {ratio!r}, tolerance: {max(0.05 * ratio, 0.05):g}}}"
    )
    return Scene(f"two joints of a file tied 1:{ratio:g}", _driven(expect), "does not follow", _model(tie + motor))


def _driven(expect: str) -> str:
    drive = "go: {kind: drive, joint: arm.slow, position: {kind: ramp, to: 1.0, start: 0.0, end: 0.5}}"
    angles = ", ".join(f"{name}: {{kind: joint_position, of: arm.{name}}}" for name in ("slow", "fast"))
    actions = f"actions: {{controls: {{{drive}}}, measures: {{{angles}}}, expect: {{{expect}}}}}"
    body = "bodies: {arm: {kind: articulated, file: model.xml, base: fixed}}"
    return f"scene: {{duration: 1.0, {FLOOR}}}\n{body}\n{actions}\n"


def _heap(kind: str, extra: str = "") -> str:
    shape = {"sphere": "{kind: sphere, radius: 0.03}", "box": "{kind: box, size: [0.05, 0.05, 0.05]}"}[kind]
    repeat = "repeat: {kind: grid, counts: [10, 10, 5], spacing: 0.065}"
    ball = f"kind: rigid, shape: {shape}, {repeat}, pose: {{pos: [0, 0, 0.05]}}"
    low = ABOVE.replace("kind: position", "kind: extent").replace("axis: z", "axis: z, stat: min") % ("", -0.03)
    return f"scene: {{duration: 0.6, {extra}{FLOOR}}}\nbodies: {{ball: {{{ball}}}}}\n{low}"


OF_THE_TRIAL = ("passes-at-rest", "cannot-fail", "cannot-hold", "implausible-density", "empty-frame")
"""Rules that find fault with how the trial asks, or with what is no material; not with what will happen."""
LOST, FASTER = "ends below what carries it", "gets faster by itself"
SHOT = "controls: {shot: {kind: initial_velocity, body: ball, linear: [%s]}}, "
SCENES = {
    "mass_1e-12": Scene("a ball of 1e-12 kg falls", _fall(FLOOR, _ball(mass=1e-12), 0.3), LOST),
    "mass_1e12": Scene("a ball of 1e12 kg falls", _fall(FLOOR, _ball(mass=1e12), 0.3), LOST),
    "mass_1e8": Scene("a ball of 1e8 kg falls", _fall(FLOOR, _ball(mass=1e8), 0.3), LOST),
    "mass_1e12_on_1e-12": Scene(
        "1e6 kg falls on 1e-6 kg",
        _fall(FLOOR, _ball(mass=1e6), 0.4, others=_box("crate", "[0.2, 0.2, 0.2]", 0.1, 1e-6), below=0.2),
        "goes through it",
    ),
    "heavy_on_light": Scene(
        "1000 kg stand on 1 g",
        _fall(
            FLOOR,
            "shape: {kind: box, size: [0.2, 0.2, 0.2]}, material: {mass: 1000}",
            0.3,
            others=_box("crate", "[0.2, 0.2, 0.2]", 0.1, 0.001),
            below=0.2,
        ),
        "sinks into it",
    ),
    "heavy_falls_on_light": Scene(
        "1000 kg fall on 10 g",
        _fall(
            FLOOR,
            "shape: {kind: box, size: [0.2, 0.2, 0.2]}, material: {mass: 1000}",
            0.5,
            others=_box("crate", "[0.2, 0.2, 0.2]", 0.1, 0.01),
            below=0.2,
        ),
        "sinks into it",
    ),
    "dt_0.1": Scene("a ball falls 1 m at dt 0.1", _fall(f"dt: 0.1, substeps: 1, {FLOOR}", _ball(), 1.0), LOST),
    "dt_0.1_high": Scene("a ball falls 4.5 m at dt 0.1", _fall(f"dt: 0.1, substeps: 1, {FLOOR}", _ball(), 4.5), LOST),
    "dt_1e-6": Scene(
        "a ball falls at dt 1e-6, for 0.2 ms",
        _fall(f"dt: 1.0e-6, record: {{rate: 50000}}, {FLOOR}", _ball(), 0.0501).replace(
            "duration: 1.0", "duration: 0.0002"
        ),
        LOST,
    ),
    "pendulum_dt_0.1": Scene("a pendulum at dt 0.1", _swing(0.1), FASTER),
    "bounce_dt_0.05": Scene(
        "a ball with restitution 0.9 at dt 0.05",
        _fall(
            f"dt: 0.05, substeps: 1, {FLOOR}",
            "shape: {kind: sphere, radius: 0.05}, material: {mass: 1, restitution: 0.9}",
            0.5,
        ),
        LOST,
    ),
    "friction_0": Scene("a crate on a slope of 20 deg, friction 0", _slope(0, 20), FASTER),
    "friction_100": Scene("a crate on a slope of 70 deg, friction 100", _slope(100, 70), "slides"),
    "friction_5": Scene("a crate on a slope of 40 deg, friction 5", _slope(5, 40), "slides"),
    "friction_0.01": Scene("a crate on a slope of 20 deg, friction 0.01", _slope(0.01, 20), FASTER),
    "friction_100_thrown": Scene(
        "a crate slides at 5 m/s, friction 100",
        f"scene: {{duration: 1.0, {FLOOR.replace('plane}', 'plane}, material: {friction: 100}')}}}\nbodies:\n"
        + _box("ball", "[0.1, 0.1, 0.1]", 0.05, 1, 100)
        + CALM % (SHOT % "5, 0, 0", "ball", 5.5),
        FASTER,
    ),
    "inside_box": Scene(
        "two crates in the same place",
        f"scene: {{duration: 1.0, {FLOOR}}}\nbodies:\n"
        + _box("ball", "[0.2, 0.2, 0.2]", 0.1, 1)
        + _box("crate", "[0.2, 0.2, 0.2]", 0.1, 1)
        + CALM % ("", "ball", 1),
        "are thrown apart",
    ),
    "inside_small": Scene(
        "a ball wholly inside a crate",
        _fall(f"{FLOOR}", _ball(0.03), 0.1, others=_box("crate", "[0.2, 0.2, 0.2]", 0.1, 1)),
        LOST,
    ),
    "inside_wall": Scene(
        "a ball wholly inside a static block",
        "scene: {duration: 1.0, statics: {block: {shape: {kind: box, size: [1, 1, 1]}}}}\nbodies:\n"
        + "  ball: {kind: rigid, shape: {kind: sphere, radius: 0.05}}\n"
        + CALM % ("", "ball", 2),
        "is thrown out, or lost",
    ),
    "below_floor": Scene(
        "a ball starts 0.3 m below the floor",
        _fall(FLOOR, _ball(), -0.3),
        LOST,
    ),
    "half_below_floor": Scene(
        "a crate starts half in the floor",
        f"scene: {{duration: 1.0, {FLOOR}}}\nbodies:\n"
        + _box("ball", "[0.2, 0.2, 0.2]", 0.02, 1)
        + CALM % ("", "ball", 0.5),
        "is thrown up",
    ),
    "plate_1mm_30": Scene("a ball at 30 m/s meets a plate of 1 mm", _plate(0.001, 30), "goes through it"),
    "plate_1mm_fixed_substeps": Scene(
        "the same, one substep of 10 ms", _plate(0.001, 30, "dt: 0.01, substeps: 1, "), "goes through it"
    ),
    "plate_1e-6": Scene("a ball at 1 m/s meets a plate of 1 um", _plate(1e-6, 1), "goes through it"),
    "plate_falls": Scene(
        "a plate of 0.1 mm falls 1 m",
        _fall(FLOOR, "shape: {kind: box, size: [0.3, 0.3, 0.0001]}, material: {mass: 1}", 1.0),
        LOST,
    ),
    "thrown_1e4": Scene("a ball is thrown at a wall at 1e4 m/s", _plate(0.1, 1e4), "goes through it"),
    "pushed_1e9": Scene(
        "a ball is pushed with 1e9 N",
        _fall(FLOOR, _ball(), 0.06, controls="controls: {push: {kind: force, body: ball, force: [0, 0, -1.0e+9]}}, "),
        LOST,
    ),
    "gravity_1e6": Scene("a ball falls at 1e6 m/s2", _fall(f"gravity: [0, 0, -1.0e+6], {FLOOR}", _ball(), 0.3), LOST),
    "gear_1e6": Scene("a motor of 1e6 N m/rad on 1 kg (a gear of 1:1000, twice)", _geared(1e6), "does not follow"),
    "gear_1e12": Scene("a motor of 1e12 N m/rad on 1 kg (a gear of 1:1e6)", _geared(1e12), "does not follow"),
    "gear_1e-6": Scene("a motor of 1e-6 N m/rad on 1 kg", _geared(1e-6), "does not follow"),
    "gear_of_a_file": Scene(
        "a motor of a file with gear 1e6",
        _driven("follows: {measure: slow, at: end, equals: 1.0, tolerance: 0.05}"),
        "does not follow",
        _model('<actuator><position joint="slow" kp="100" kv="10" gear="1e6"/></actuator>'),
    ),
    "tied_1e6": _tied(1e6),
    "tied_1e-6": _tied(1e-6),
    "tied_3": _tied(3.0),
    "liquid_1e-6": Scene(
        "a layer of water of 1 um, in cells of 20 mm",
        f"scene: {{duration: 0.1, {FLOOR}}}\nbodies: {{film: {{kind: liquid, cell: 0.02, "
        "shape: {kind: box, size: [0.3, 0.3, 1.0e-6]}, pose: {pos: [0, 0, 0.05]}}}\n",
        "",
    ),
    "pile_of_500": Scene("500 spheres fall in a heap", _heap("sphere"), LOST),
    "pile_of_500_boxes": Scene("500 cubes fall in a heap", _heap("box"), LOST),
    "pile_dt_0.05": Scene("500 spheres at dt 0.05", _heap("sphere", "dt: 0.05, substeps: 1, "), LOST),
}


def main() -> None:
    """Run what is wanted and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", choices=SCENES, help="run these again")
    parser.add_argument("--all", action="store_true", help="run all again")
    parser.add_argument("--docs", action="store_true", help="put the table into docs/limits.md")
    options = parser.parse_args()
    results = {name: row for name, row in known("absurd").items() if name in SCENES}
    warm = WarmEngine(Path(tempfile.mkdtemp(prefix="absurd_")))
    for name in options.only or [name for name in SCENES if options.all or name not in results]:
        results[name] = tried(SCENES[name], warm)
        keep("absurd", results)
        print(f"{name}: {json.dumps(results[name])}", file=sys.stderr, flush=True)
    warm.stop()
    text = table(results)
    print(text)
    if options.docs:
        paste("limits.md", "absurd", text)
    sys.exit(any(silent(row) for row in results.values()))


def tried(scene: Scene, engine: WarmEngine) -> dict[str, Any]:
    """Check and run one scene, and return what was said of it. What the lint refuses is run all the same."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "case.yaml").write_text(HEAD + scene.text)
        (folder / "model.xml").write_text(scene.model)
        found: dict[str, Any] = {"state": "finished", "message": "", "sound": None, "suspicions": []}
        try:
            loaded = load_case(folder)
            said = lint_case(resolve_case(loaded)).problems
            compile_case(loaded, folder / "program")
        except SpecError as error:
            return found | {"state": "refused", "lint": [], "message": error.problems[0].message}
        found["lint"] = sorted({f"{p.rule} {p.severity}" for p in said if p.rule not in OF_THE_TRIAL})
        try:
            engine.run(folder / "program", folder / "run")
        except pytest.fail.Exception as error:
            return found | {"state": "stops", "message": str(error).partition(" ended as ")[2] or str(error)[-200:]}
        evidence = judge(folder / "run", loaded.case)
        sound = all(row["ok"] for row in evidence["expect"].values())
        return found | {"sound": sound, "suspicions": evidence["suspicions"]}


def silent(row: dict[str, Any]) -> bool:
    """Whether something went wrong and nobody said why."""
    return row["sound"] is False and row["state"] == "finished" and not row["suspicions"] and not row["lint"]


def table(results: dict[str, Any]) -> str:
    """Return what came of all scenes as Markdown."""
    lines = ["| what | before the run | the run, where it is made all the same |", "|---|---|---|"]
    for name, scene in SCENES.items():
        if name not in results:
            continue
        row = results[name]
        said = ", ".join(f"`{rule.split()[0]}` ({rule.split()[1]})" for rule in row["lint"]) or "–"
        if row["state"] != "finished":
            shown = f"{row['state']}: {row['message']}"
        else:
            shown = scene.wrong if not row["sound"] else "as it should be" if scene.wrong else "ends, and shows nothing"
            shown += (
                f"; it says that {row['suspicions'][0].partition(': ')[0]}"
                if row["suspicions"]
                else "; **silent**"
                if silent(row)
                else ""
            )
        lines.append(f"| {scene.words} | {said} | {shown} |")
    return "\n".join(lines) + f"\n\n{engine()}."


if __name__ == "__main__":
    main()
