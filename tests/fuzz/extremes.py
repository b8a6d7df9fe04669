"""Every number of the language, in small cases, at values that nobody means.

python tests/fuzz/extremes.py             all of them; prints what went wrong, and what took long
python tests/fuzz/extremes.py --every 20  one in twenty
"""

import argparse
import copy
import json
import resource
import signal
import sys
import time
import traceback
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pydantic import BaseModel

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "spec_schema"))

from staged import edits_of, staged

from text2sim.spec_schema.errors import Text2SimError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.published.language_reference import load_examples
from text2sim.spec_schema.text.canonical import dump_case
from text2sim.spec_schema.vocabulary.words import Slot, fields_of

VALUES = (0, -0.0, 1e-29, -1e-3, 1e-15, 1e-6, 1e-3, 1e3, 1e6, 1e15, -1e15)
SECONDS = 3.0
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
    "{kind: ellipsoid, radii: [0.1, 0.1, 0.2]}",
    "{kind: torus, radius: 0.2, bar_radius: 0.05}",
    "{kind: tube, outer_radius: 0.2, inner_radius: 0.15, height: 0.2}",
    "{kind: cup, radius: 0.1, height: 0.2, thickness: 0.01}",
    "{kind: funnel, top_radius: 0.3, bottom_radius: 0.1, height: 0.3, thickness: 0.02}",
    "{kind: compound, parts: {a: {shape: {kind: box, size: [0.1, 0.1, 0.1]}, density: 500, pose: {euler_deg: [0, 5, 0]}}}}",
    "{kind: text, text: A, height: 0.2, depth: 0.05}",
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
    "cloth": "{kind: cloth, solver: pbd, shape: {kind: sheet, size: [0.4, 0.4]}, cell: 0.05, pose: {pos: [0, 0, 1]}}",
    "rope": "{kind: rope, length: 1, radius: 0.02, pose: {pos: [0, 0, 1]}}",
    "granular": "{kind: granular, shape: {kind: box, size: [0.2, 0.2, 0.2]}, cell: 0.05, pose: {pos: [0, 0, 1]}}",
    "liquid": "{kind: liquid, shape: {kind: box, size: [0.2, 0.2, 0.2]}, cell: 0.05, pose: {pos: [0, 0, 1]}}",
    "snow": "{kind: snow, shape: {kind: box, size: [0.2, 0.2, 0.2]}, cell: 0.05, pose: {pos: [0, 0, 1]}}",
    "driven": "{kind: driven, shape: {kind: box, size: [0.2, 0.2, 0.2]}, motion: {kind: waypoints, times: [0, 1], positions: [[0, 0, 1], [0, 0, 2]]}}",
}  # fmt: skip
ACTIONS = """\
  controls:
    go: {kind: initial_velocity, body: ball, linear: [1, 0, 0]}
    kick: {kind: impulse, body: ball, impulse: [1, 0, 0], at: 0.1}
    push: {kind: force, body: ball, force: [1, 0, 0], during: [0, 0.1], drag: 0.0}
    turn: {kind: torque, body: ball, torque: [0, 0, 1]}
  measures:
    height: {kind: position, of: ball, axis: z}
    fast: {kind: speed, of: ball}
  events:
    hit: {kind: contact, between: [ball, floor], min_impulse: 0.0}
    high: {kind: threshold, measure: height, above: 0.5}
    still: {kind: rest, of: ball}
  expect:
    low: {measure: height, at: 0.1, below: 2, above: -1}
    close: {measure: height, during: [0.1, 0.2], equals: 1, tolerance: 5}
    hits: {event: hit, within: [0, 1]}
render:
  cameras:
    main: {kind: still, from: [2, -2, 1], look_at: ball}
    orbit: {kind: orbit, look_at: ball, radius: 3, height: 1}
    follow: {kind: follow, body: ball, offset: [2, 0, 1]}
  lights:
    sun: {kind: sun, direction: [0, 0, -1]}
    lamp: {kind: softbox, direction: [0, 0.1, -1]}
"""


def case_of(body: str, rest: str = "") -> dict[str, Any]:
    """A case with one body, as plain data."""
    text = (
        "text2sim: 2\nname: extreme\nprompt: Something falls.\n"
        f"scene: {{duration: 0.2, statics: {{floor: {FLOOR}}}}}\nbodies:\n  ball: {body}\n"
    )
    return load_text(text + (f"actions:\n{rest}" if rest else "")).raw


def cases() -> Iterator[tuple[str, dict[str, Any]]]:
    """All cases by name."""
    for name, body in BODIES.items():
        yield name, case_of(body)
    yield "actions", case_of(BALL, ACTIONS)
    for section, kinds in load_examples().items():
        for kind in kinds:
            yield f"{section} {kind}", staged(edits_of(section, kind)).raw


def numbers(model: BaseModel, path: tuple[Any, ...] = ()) -> Iterator[tuple[tuple[Any, ...], Slot]]:
    """Yield the path of every number that a model holds or could hold."""
    for key, (attribute, slot) in fields_of(type(model)).items():
        value = getattr(model, attribute)
        yield from _numbers(value, slot, (*path, key))


def _numbers(value: Any, slot: Slot, path: tuple[Any, ...]) -> Iterator[tuple[tuple[Any, ...], Slot]]:
    if isinstance(value, BaseModel):
        yield from numbers(value, path)
    elif isinstance(value, dict):
        for key, inner in value.items():
            yield from _numbers(inner, slot, (*path, key))
    elif isinstance(value, list | tuple):
        for index, inner in enumerate(value[:2]):
            if isinstance(inner, int | float) and not isinstance(inner, bool):
                yield (*path, index), slot
            else:
                yield from _numbers(inner, slot, (*path, index))
    elif any(member.base in (int, float) for member in slot.members):
        yield path, slot


def changed(data: dict[str, Any], model: BaseModel, path: tuple[Any, ...], value: float) -> dict[str, Any] | None:
    """The data with another number at a path; None if there is no such place in it."""
    data = copy.deepcopy(data)
    at: Any = data
    source: Any = model
    for step in path[:-1]:
        inner = _step(source, step)
        if isinstance(at, dict) and step not in at:
            # A default of the model, written out.
            at[step] = inner.model_dump(mode="json", by_alias=True) if isinstance(inner, BaseModel) else _plain(inner)
        at, source = at[step], inner
        if not isinstance(at, dict | list):
            return None
    at[path[-1]] = value
    return data


def _step(source: Any, step: Any) -> Any:
    if isinstance(source, BaseModel):
        return getattr(source, fields_of(type(source))[step][0])
    return source[step]


def _plain(value: Any) -> Any:
    return [_plain(item) for item in value] if isinstance(value, list | tuple) else value


def documents(every: int = 1) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield each case with one number changed, or one in `every` of them."""
    count = 0
    seen: set[tuple[str, Any, float]] = set()
    for name, data in cases():
        model = load_text(dump_case(data)).case
        for path, slot in numbers(model):
            whole = all(member.base is not float for member in slot.members)
            for value in VALUES:
                number = int(value) if whole and value == int(value) else value
                key = (type(_owner(model, path)).__name__, path[-1], number)
                if key in seen and name != "actions":
                    continue
                seen.add(key)
                count += 1
                if count % every == 0 and (document := changed(data, model, path, number)) is not None:
                    yield f"{name}: {'.'.join(map(str, path))} = {number!r}", document


def _owner(model: BaseModel, path: tuple[Any, ...]) -> Any:
    source: Any = model
    for step in path[:-1]:
        source = _step(source, step)
    return source


class SlowError(BaseException):
    """It took too long."""


def _too_slow(*_: Any) -> None:
    raise SlowError


def examine(data: dict[str, Any]) -> str:
    """Check a case, as `text2sim check` does."""
    from text2sim.compiler.build import resolve_case
    from text2sim.lint import lint_case

    try:
        report = lint_case(resolve_case(load_text(dump_case(data))))
    except Text2SimError:
        return "refused"
    return "fine" if report.ok else "refused"


def trial(every: int) -> dict[str, Any]:
    """Check them; return how many there were, and what went wrong."""
    signal.signal(signal.SIGVTALRM, _too_slow)
    examine(case_of(BALL, ACTIONS))  # what is imported once
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    wrong, seen, slowest = [], {"fine": 0, "refused": 0}, ("", 0.0)
    for name, data in documents(every):
        begun = time.process_time()
        signal.setitimer(signal.ITIMER_VIRTUAL, SECONDS)
        try:
            seen[examine(data)] += 1
        except SlowError:
            wrong.append({"name": name, "why": f"more than {SECONDS} s", "at": traceback.format_exc(limit=-4)})
        except Exception:
            wrong.append({"name": name, "why": traceback.format_exc(limit=-4)})
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        took = time.process_time() - begun
        slowest = max(slowest, (name, took), key=lambda row: row[1])
    return {"seen": seen, "slowest": slowest, "wrong": wrong}


def main() -> None:
    """Run a trial, print what came of it, exit with 1 if anything was wrong."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    found = trial(options.every)
    if options.json:
        print(json.dumps(found))
    else:
        for row in found["wrong"]:
            print("---", row["name"], "\n", row.get("at", ""), row["why"])
        print({key: value for key, value in found.items() if key != "wrong"}, len(found["wrong"]), "wrong")
    sys.exit(bool(found["wrong"]))


if __name__ == "__main__":
    main()
