"""Every number of the language, in small cases, at values that nobody means.

python tests/fuzz/extremes.py                all of them; says what goes wrong, and what took long
python tests/fuzz/extremes.py --every 20     one in twenty
python tests/fuzz/extremes.py --only Place   those of some models alone
"""

import argparse
import copy
import itertools
import json
import re
import resource
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "spec_schema"))

from staged import edits_of, staged

from text2sim.spec_schema.errors import Text2SimError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.models.case import Case
from text2sim.spec_schema.published.language_reference import load_examples
from text2sim.spec_schema.text.canonical import dump_case
from text2sim.spec_schema.vocabulary.words import LanguageSlot, fields_of, is_model, slot_of

VALUES = (0, -0.0, 1e-320, 1e-308, 1e-100, 1e-29, 1e-15, 1e-6, 1e-3, -1e-3, 1e3, 1e6, 1e15, -1e15, 1e100, 1e308)
SAMPLE = (0.1, 0.2, 0.3, 0.4)
"""What a vector is of which a case says nothing, but for one number."""
SECONDS = 5.0
"""Processor time [s] of one check."""
MEMORY = 3_000_000_000
"""Address space [bytes] of the whole trial."""

BALL = "{kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 1]}}"
FLOOR = "{shape: {kind: plane}}"
SHAPES = (
    "{kind: box, size: [0.2, 0.2, 0.2]}",
    "{kind: cylinder, radius: 0.1, height: 0.2}",
    "{kind: capsule, radius: 0.05, length: 0.1}",
    "{kind: cone, radius: 0.1, height: 0.2}",
    "{kind: polyhedron, points: [[0, 0, 0], [0.2, 0, 0], [0, 0.2, 0], [0, 0, 0.3], [0.2, 0.2, 0.1]]}",
    "{kind: ellipsoid, radii: [0.1, 0.1, 0.2]}",
    "{kind: torus, radius: 0.2, bar_radius: 0.05}",
    "{kind: tube, outer_radius: 0.2, inner_radius: 0.15, height: 0.2}",
    "{kind: cup, radius: 0.1, height: 0.2, thickness: 0.01}",
    "{kind: funnel, top_radius: 0.3, bottom_radius: 0.1, height: 0.3, thickness: 0.02}",
    "{kind: compound, parts: {a: {shape: {kind: box, size: [0.1, 0.1, 0.1]}, density: 500, pose: {euler_deg: [0, 5, 0]}}}}",
    "{kind: text, text: A, height: 0.2, depth: 0.05}",
    "{kind: extrusion, outline: [[0, 0], [0.2, 0], [0, 0.2]], holes: [[[0.02, 0.02], [0.1, 0.02], [0.02, 0.1]]], depth: 0.1}",
    "{kind: extrusion, outline: [[0, 0], [0.2, 0], [0.2, 0.2], [0, 0.1]], smooth: true, depth: 0.1}",
)
REPEATS = (
    "{kind: line, count: 3, step: [0.3, 0, 0]}",
    "{kind: grid, counts: [2, 2, 2], spacing: 0.3}",
    "{kind: grid, counts: [2, 2], spacing: [0.3, 0.3]}",
    "{kind: ring, count: 4, radius: 0.5}",
    "{kind: spiral, count: 6, inner_radius: 0.3, spacing: 0.3, pitch: 0.3}",
    "{kind: stack, count: 3}",
)
BODIES = {
    **{f"shape {k}": f"{{kind: rigid, shape: {shape}, pose: {{pos: [0, 0, 1]}}}}" for k, shape in enumerate(SHAPES)},
    **{f"repeat {k}": f"{{kind: rigid, shape: {{kind: sphere, radius: 0.1}}, pose: {{pos: [0, 0, 1]}}, repeat: {row}}}"
       for k, row in enumerate(REPEATS)},
    "placed": "{kind: rigid, shape: {kind: box, size: [0.2, 0.2, 0.2]}, material: {mass: 1, friction: 0.3, restitution: 0.3}, "
              "place: {above: floor, at: [0, 0], clearance: 0.1, offset: [0, 0, 0]}}",
    "wall": "{kind: rigid, shape: {kind: box, size: [0.2, 0.1, 0.1]}, repeat: {kind: running_bond, rows: 2, columns: 2}, place: {on: floor, at: [0, 0]}}",
    "packed": "{kind: rigid, shape: {kind: sphere, radius: 0.1}, repeat: {kind: packing, count: 5, region: {kind: box, min: [-1, -1, 1], max: [1, 1, 2]}}}",
    "hinged": "{kind: rigid, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0, 0, 1]}, mount: {kind: hinge, axis: y, "
              "anchor: [0, 0, 0.1], range_deg: [-60, 60], damping: 0.1, spring: 1, actuator: {stiffness: 10, damping: 1, max_force: 5}}}",
    "slider": "{kind: rigid, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0, 0, 1]}, mount: {kind: slider, axis: x, range: [-1, 1]}}",
    "chain": "{kind: chain, links: 4, link_length: 0.1, radius: 0.02, pose: {pos: [0, 0, 1]}}",
    "net": "{kind: net, cells: [2, 2], size: [0.4, 0.4], radius: 0.01, pose: {pos: [0, 0, 1]}}",
    "ragdoll": "{kind: ragdoll, height: 1.7, pose: {pos: [0, 0, 1.5]}}",
    "soft": "{kind: soft, solver: mpm, shape: {kind: box, size: [0.2, 0.2, 0.2]}, cell: 0.05, pose: {pos: [0, 0, 1]}}",
    "fem": "{kind: soft, solver: fem, shape: {kind: box, size: [0.2, 0.2, 0.2]}, cell: 0.1, pose: {pos: [0, 0, 1]}}",
    "cloth": "{kind: cloth, solver: pbd, shape: {kind: sheet, size: [0.4, 0.4]}, cell: 0.05, material: {youngs_modulus: 1e6, prestretch: 1.5}, pose: {pos: [0, 0, 1]}}",
    "rope": "{kind: rope, length: 1, radius: 0.02, pose: {pos: [0, 0, 1]}}",
    "beam": "{kind: beam, size: [1, 0.1, 0.02], segments: 4, youngs_modulus: 1e9, damping_ratio: 0.02, pose: {pos: [0, 0, 1]}}",
    "granular": "{kind: granular, shape: {kind: box, size: [0.2, 0.2, 0.2]}, cell: 0.05, pose: {pos: [0, 0, 1]}}",
    "liquid": "{kind: liquid, shape: {kind: box, size: [0.2, 0.2, 0.2]}, cell: 0.05, pose: {pos: [0, 0, 1]}}",
    "snow": "{kind: snow, shape: {kind: box, size: [0.2, 0.2, 0.2]}, cell: 0.05, pose: {pos: [0, 0, 1]}}",
    "jointed": "{kind: articulated, pose: {pos: [0, 0, 1]}, initial: {b: 0.1}, loops: {l: {between: [b, world]}}, links: "
               "{a: {shape: {kind: sphere, radius: 0.1}}, "
               "b: {parent: a, shape: {kind: sphere, radius: 0.1}, joint: {kind: slider, range: [-1, 1]}}, "
               "c: {parent: a, shape: {kind: sphere, radius: 0.1}, joint: {kind: ball}}, "
               "d: {parent: a, shape: {kind: sphere, radius: 0.1}, joint: {kind: hinge}}}}",
    "read": "{kind: articulated, file: arm.urdf, joints: {turn: {actuator: {}}}, pose: {pos: [0, 0, 1]}}",
    "lined": "{kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, repeat: {kind: line, count: 3, step: [0.3, 0, 0]}, "
             "look: {color: {palette: viridis}, pattern: {kind: planks}}}",
    "near": "{kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, place: {touching: floor, at: {nearest: [0, 0, 0]}}}",
    "driven": "{kind: driven, shape: {kind: box, size: [0.2, 0.2, 0.2]}, motion: {kind: waypoints, times: [0, 1], positions: [[0, 0, 1], [0, 0, 2]]}}",
}  # fmt: skip
ACTIONS = """\
  controls:
    go: {kind: initial_velocity, body: ball, linear: [1, 0, 0]}
    kick: {kind: impulse, body: ball, impulse: [1, 0, 0], at: 0.1}
    push: {kind: force, body: ball, force: [1, 0, 0], during: [0, 0.1], drag: 0.0}
    turn: {kind: torque, body: ball, torque: [0, 0, 1]}
    side: {kind: force, body: ball, force: [1, 0, 0], point: {box: {min: [-1, -1, -1], max: [1, 1, 1]}}}
  measures:
    height: {kind: position, of: ball, axis: z}
    fast: {kind: speed, of: ball}
  events:
    hit: {kind: contact, between: [ball, floor], min_impulse: 0.0}
    high: {kind: threshold, measure: height, above: 0.5}
    there: {kind: enters, of: ball, region: {kind: cylinder, center: [0, 0, 0], axis: z, radius: 1, height: 1}}
    still: {kind: rest, of: ball}
  expect:
    low: {measure: height, at: 0.1, below: 2, above: -1}
    close: {measure: height, during: [0.1, 0.2], equals: 1, tolerance: 5}
    hits: {event: hit, within: [0, 1]}
render:
  cameras:
    main: {kind: still, from: [2, -2, 1], look_at: ball}
    orbit: {kind: orbit, look_at: ball, radius: 3, height: 1, f_stop: 2.8}
    follow: {kind: follow, body: ball, offset: [2, 0, 1], f_stop: 2.8}
    stand: {kind: follow, body: ball, from: [2, 0, 1]}
    frame: {kind: still, frame: [ball], within: {min: [-1, -1, -1], max: [1, 1, 1]}}
    line: {kind: dolly, from: [-2, -3, 1], to: [2, -3, 1], look_at: ball, f_stop: 2.8}
    crane: {kind: keyframed, times: [0, 0.1], positions: [[0, -4, 1], [1, -3, 2]], look_at: ball, f_stop: 2.8}
    soft: {kind: still, from: [2, -2, 1], look_at: ball, f_stop: 2.8}
  shots:
    one: {camera: main, from: 0, to: 0.1}
  lights:
    sun: {kind: sun, direction: [0, 0, -1]}
    lamp: {kind: softbox, direction: [0, 0.1, -1]}
    spot: {kind: spot, pos: [0, -1, 3], look_at: ball}
"""
SOLVERS = """\
contact: {pairs: {ice: {between: [ball, floor], friction: 0.02}}}, domain: {min: [-1, -1, -1], max: [1, 1, 1]}, \
mpm: {bounds: {min: [-1, -1, -1], max: [1, 1, 2]}}, pbd: {bounds: {min: [-1, -1, -1], max: [1, 1, 2]}}, """
ARM = """\
<robot name="arm"><link name="a"/><link name="b"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link><joint name="turn" type="revolute"><parent link="a"/>
<child link="b"/><axis xyz="0 1 0"/><limit lower="-1" upper="2" effort="3" velocity="5"/></joint></robot>
"""


def case_of(body: str, rest: str = "", scene: str = "") -> dict[str, Any]:
    """A case with one body, as plain data."""
    text = (
        "text2sim: 2\nname: extreme\nprompt: Something falls.\n"
        f"scene: {{duration: 0.2, {scene}statics: {{floor: {FLOOR}}}}}\nbodies:\n  ball: {body}\n"
    )
    return load_text(text + (f"actions:\n{rest}" if rest else "")).raw


def cases() -> Iterator[tuple[str, dict[str, Any]]]:
    """All cases by name."""
    for name, body in BODIES.items():
        yield name, case_of(body)
    yield "actions", case_of(BALL, ACTIONS)
    yield "solvers", case_of(BODIES["soft"], scene=SOLVERS)
    for section, kinds in load_examples().items():
        for kind in kinds:
            yield f"{section} {kind}", staged(edits_of(section, kind)).raw


def numbers(model: BaseModel, path: tuple[Any, ...] = ()) -> Iterator[tuple[str, tuple[Any, ...], LanguageSlot]]:
    """Yield every number that a model holds or could hold: its field (`Pose.pos`), its path, what it may be."""
    for key, (attribute, slot) in fields_of(type(model)).items():
        for where, inner in _numbers(getattr(model, attribute), slot, (*path, key)):
            if isinstance(where, str):
                yield where, *inner
            else:
                yield f"{type(model).__name__}.{key}", where, inner


def _numbers(value: Any, slot: LanguageSlot, path: tuple[Any, ...]) -> Iterator[tuple[Any, Any]]:
    if isinstance(value, BaseModel):
        yield from ((field, rest) for field, *rest in numbers(value, path))
        return
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from _numbers(inner, slot_of(get_args(slot.base)[1]), (*path, key))
        return
    for member in slot.members:
        if member.base in (int, float):
            yield path, slot
        elif get_origin(member.base) is tuple and not isinstance(value, list | tuple) and holds_numbers(member):
            yield from (((*path, index), slot) for index in range(len(get_args(member.base))))
    for index, inner in enumerate(value[:3] if isinstance(value, list | tuple) else ()):
        if isinstance(inner, int | float):
            yield (*path, index), slot
        else:
            yield from _numbers(inner, slot, (*path, index))


def holds_numbers(slot: LanguageSlot) -> bool:
    """Whether a number may stand in a slot, or in a list or mapping of it."""
    return any(
        member.base in (int, float) or any(holds_numbers(slot_of(kind)) for kind in get_args(member.base))
        for member in slot.members
        if get_origin(member.base) is not Literal
    )


def fields_with_numbers() -> set[str]:
    """All fields of the language that take a number: `Pose.pos`."""
    models, found = [Case], set()
    for model in models:
        for key, (_, slot) in fields_of(model).items():
            if holds_numbers(slot):
                found.add(f"{model.__name__}.{key}")
            models += [inner for inner in dict.fromkeys(_models(slot)) if inner not in models]
    return found


def _models(slot: LanguageSlot) -> Iterator[type[BaseModel]]:
    for member in slot.members:
        if is_model(member.base):
            yield member.base
        elif get_origin(member.base) is not Literal:
            for kind in get_args(member.base):
                yield from _models(slot_of(kind))


def changed(data: dict[str, Any], model: BaseModel, path: tuple[Any, ...], value: float) -> dict[str, Any]:
    """The data with another number at a path; what is on the way and is not there is written out."""
    data = copy.deepcopy(data)
    at: Any = data
    source: Any = model
    slot: Any = None
    for step, following in itertools.pairwise(path):
        if isinstance(source, BaseModel):
            attribute, slot = fields_of(type(source))[step]
            source = getattr(source, attribute)
        else:
            source = source[step]
        here = at.get(step) if isinstance(at, dict) else at[step]
        if not isinstance(here, dict | list):
            if isinstance(source, BaseModel):
                here = source.model_dump(mode="json", by_alias=True)
            elif isinstance(following, int) and not isinstance(source, list | tuple):
                vector = next(m for m in slot.members if get_origin(m.base) is tuple and holds_numbers(m))
                here = list(SAMPLE[: len(get_args(vector.base))])
            else:
                here = json.loads(json.dumps(source))
            at[step] = here
        at = here
    at[path[-1]] = value
    return data


def documents(every: int = 1, only: tuple[str, ...] = ()) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield each case with one number changed, or one in `every` of them."""
    count = 0
    seen: set[tuple[Any, ...]] = set()
    for name, data in cases():
        model = load_text(dump_case(data)).case
        for field, path, slot in numbers(model):
            if only and not field.startswith(only):
                continue
            whole = all(member.base is not float for member in slot.members)
            for value in VALUES:
                number = int(value) if whole and value == int(value) else value
                key = (field, path[-1], repr(number))
                if key in seen and name != "actions":
                    continue
                seen.add(key)
                count += 1
                if count % every == 0:
                    yield f"{name}: {'.'.join(map(str, path))} = {number!r}", changed(data, model, path, number)


class SlowError(BaseException):
    """It took too long."""


def _too_slow(*_: Any) -> None:
    raise SlowError


def examine(data: dict[str, Any], folder: Path) -> str:
    """Check a case in a folder, as `text2sim check` does."""
    from text2sim.compiler.build import resolve_case
    from text2sim.lint import lint_case

    try:
        report = lint_case(resolve_case(load_text(dump_case(data), folder / "case.yaml")))
    except Text2SimError:
        return "refused"
    return "fine" if report.ok else "refused"


def _peak() -> int:
    """Most memory [bytes] that this process has had; `ru_maxrss` counts that of whoever forked it, too."""
    found = re.search(r"VmHWM:\s+(\d+) kB", Path("/proc/self/status").read_text())
    assert found is not None
    return int(found[1]) * 1024


def trial(every: int, only: tuple[str, ...], folder: Path) -> dict[str, Any]:
    """Check them; return how many there were, and what went wrong."""
    signal.signal(signal.SIGVTALRM, _too_slow)
    (folder / "arm.urdf").write_text(ARM)
    examine(case_of(BALL, ACTIONS), folder)  # what is imported once
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    wrong, seen, slowest = [], {"fine": 0, "refused": 0}, ("", 0.0)
    reached = {field for _, data in cases() for field, *_ in numbers(load_text(dump_case(data)).case)}
    for name, data in documents(every, only):
        begun = time.process_time()
        signal.setitimer(signal.ITIMER_VIRTUAL, SECONDS)
        try:
            seen[examine(data, folder)] += 1
        except SlowError:
            wrong.append({"name": name, "why": f"more than {SECONDS} s", "at": traceback.format_exc(limit=-4)})
        except Exception:
            wrong.append({"name": name, "why": traceback.format_exc(limit=-4)})
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        took = time.process_time() - begun
        if wrong and wrong[-1]["name"] == name:
            print("---", name, wrong[-1].get("at", ""), wrong[-1]["why"], file=sys.stderr, flush=True)
        slowest = max(slowest, (name, took), key=lambda row: row[1])
    memory = _peak()
    missed = sorted(fields_with_numbers() - reached)
    return {"seen": seen, "slowest": slowest, "memory": memory, "missed": missed, "wrong": wrong}


def main() -> None:
    """Run a trial, print what came of it, exit with 1 if anything was wrong."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--only", nargs="*", default=[])
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        found = trial(options.every, tuple(options.only), Path(folder))
    if options.json:
        print(json.dumps(found))
    else:
        print({key: value for key, value in found.items() if key != "wrong"}, len(found["wrong"]), "wrong")
    sys.exit(bool(found["wrong"] or found["missed"]))


if __name__ == "__main__":
    main()
