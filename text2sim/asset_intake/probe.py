"""A small signal on each joint of a mechanism, one after the other in the engine: which of them answer, and how far."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from text2sim.asset_intake.mechanism_check import MechanismReport, Subject, report_of, resolved
from text2sim.asset_intake.tiny_case import BODY, TrialOutcome, run_trial, tiny_case
from text2sim.assets.manifest import Control, Motor
from text2sim.spec_schema.errors import AssetError

WINDOW = 0.3
"""Seconds for each joint; there are at most `WINDOWS` of them, in which several joints may move."""
WINDOWS = 12
MAX_JOINTS = 60
STEP = 0.005
ANGLE, WAY = 0.15, 0.03
"""How far a joint is asked to go [rad and m], where its range has room for it."""
ROOM = 0.4
"""It is asked to go this part of the room that it has, at most."""
ANSWERS = 0.5
"""A joint answers if it comes this part of the way."""
PACE = 20.0
"""Of the motors that are put on a mechanism that has none [rad/s]."""


@dataclass(frozen=True)
class JointResponse:
    """What a joint did."""

    target: float
    """How far it was asked to go [rad or m]."""
    moved: float
    """How far it came [rad or m]."""
    answers: bool
    """Whether that is half of the way at least, in the right direction; what dry friction holds creeps a third."""


@dataclass(frozen=True)
class ProbeReport:
    """What came of a probe."""

    ok: bool
    """Whether it ran to its end and every joint answered."""
    state: str
    message: str
    """Why it ended early, or why a joint may not have answered."""
    joints: Mapping[str, JointResponse]
    given: tuple[str, ...]
    """Joints that have no motor of their own, and were given one for the probe."""
    left_out: tuple[str, ...]
    """Joints that were not asked: balls, names that a case cannot say, too many."""
    control: Mapping[str, Control]
    """The joints with what they did, for the manifest; motors that were given stand in it as proposals."""
    report: MechanismReport
    wall: float
    """Seconds that it took."""


@dataclass(frozen=True)
class _Signal:
    """What a joint is asked for."""

    joint: str
    start: float
    """Its position at the start [rad or m]."""
    target: float
    """Difference from that."""
    motor: Motor
    begin: float
    """[s]"""


def probe(what: Path | Mapping[str, Any], folder: Path | None = None) -> ProbeReport:
    """Move each joint of a mechanism a little, without gravity and with its root held.

    Args:
        what: An MJCF or URDF file, or the data of an `articulated` body.
        folder: The folder in which all of its files lie; that of the file if None.

    Raises:
        AssetError: if it cannot be used, or no joint of it can be asked.
        MachineError: if this machine cannot run the engine.
    """
    subject = Subject.of(what, folder)
    report = report_of(resolved(subject))
    asked = [n for n, one in report.control.items() if one.kind != "ball" and n.isidentifier() and n.isascii()]
    asked = asked[:MAX_JOINTS]
    if not asked:
        raise AssetError("has no hinge or slider that could be asked to move")
    signals = _signals(subject, report, asked)
    given = tuple(signal.joint for signal in signals if report.control[signal.joint].actuator is None)
    outcome = run_trial(_case(subject, signals, given))
    recorded = bool(outcome.series.get("time"))
    answers = {s.joint: _answer(n, s, outcome) for n, s in enumerate(signals)} if recorded else {}
    return ProbeReport(
        ok=outcome.ok and len(answers) == len(asked) and all(one.answers for one in answers.values()),
        state=outcome.state,
        message=outcome.message or _excuse(report, answers),
        joints=answers,
        given=given,
        left_out=tuple(name for name in report.control if name not in asked),
        control={name: _control(name, report, signals, answers) for name in report.control},
        report=report,
        wall=outcome.wall,
    )


def _excuse(report: MechanismReport, answers: Mapping[str, JointResponse]) -> str:
    """Return why joints that were asked one by one may not have answered, if the mechanism gives a reason."""
    if report.loops and not all(one.answers for one in answers.values()):
        return "joints that constraints tie together hold each other back when one is driven alone"
    return ""


def _signals(subject: Subject, report: MechanismReport, asked: list[str]) -> list[_Signal]:
    initial = subject.body.get("initial") or {}
    windows = min(len(asked), WINDOWS)
    found = []
    for number, name in enumerate(asked):
        one = report.control[name]
        low, high = one.range or (-math.inf, math.inf)
        start = float(initial.get(name, 0.0))
        if not low <= start <= high:
            start = (low + high) / 2
        up = high - start >= (start - low) * (1 - 1e-9)
        room = ROOM * (high - start if up else start - low)
        target = min(WAY if one.unit == "m" else ANGLE, room) * (1 if up else -1)
        motor = one.actuator or _proposal(one, report)
        found.append(_Signal(name, start, target, motor, STEP * 4 + WINDOW * (number % windows)))
    return found


def _proposal(one: Control, report: MechanismReport) -> Motor:
    """Return a motor that moves any joint of a mechanism of this mass and size at some pace."""
    reach = max(max(report.size) / 2, 0.01)
    inertia = max(report.mass, 1e-3) * (1.0 if one.kind == "slider" else reach**2)
    return Motor(stiffness=float(f"{inertia * PACE**2:.3g}"), damping=float(f"{2 * inertia * PACE:.3g}"))


def _case(subject: Subject, signals: list[_Signal], given: tuple[str, ...]) -> Any:
    body = dict(subject.body)
    out_of_range = {signal.joint: signal.start for signal in signals if signal.start != 0.0}
    if out_of_range:
        body["initial"] = {**(body.get("initial") or {}), **out_of_range}
    motors = {s.joint: {"actuator": s.motor.model_dump(exclude_none=True)} for s in signals if s.joint in given}
    if motors and "file" in body:
        body["joints"] = {**(body.get("joints") or {}), **motors}
    elif motors:
        links = {name: dict(link) for name, link in body["links"].items()}
        for name, change in motors.items():
            links[name]["joint"] = {**links[name]["joint"], **change}
        body["links"] = links
    duration = max(signal.begin for signal in signals) + WINDOW
    scene = {"duration": duration, "dt": STEP, "gravity": [0, 0, 0]}
    actions = {
        "controls": {f"drive_{n}": _drive(signal) for n, signal in enumerate(signals)},
        "measures": {f"joint_{n}": {"kind": "joint_position", "of": _of(s)} for n, s in enumerate(signals)},
    }
    return tiny_case(subject.folder, body, scene, actions=actions)


def _of(signal: _Signal) -> str:
    return f"{BODY}.{signal.joint}"


def _drive(signal: _Signal) -> dict[str, Any]:
    motor, drive = signal.motor, {"kind": "drive", "joint": _of(signal)}
    times = [signal.begin, signal.begin + WINDOW / 2]
    if motor.stiffness > 0:
        return drive | {"position": {"kind": "piecewise", "times": times, "values": [signal.start, _goal(signal)]}}
    if motor.damping > 0:
        speed = signal.target / WINDOW
        return drive | {"velocity": {"kind": "steps", "times": [times[0], times[0] + WINDOW], "values": [speed, 0.0]}}
    force = math.copysign(min(0.2 * (motor.max_force or 5.0), 1.0), signal.target)
    return drive | {"force": {"kind": "steps", "times": [times[0], times[0] + WINDOW], "values": [force, 0.0]}}


def _goal(signal: _Signal) -> float:
    return signal.start + signal.target


def _answer(number: int, signal: _Signal, outcome: TrialOutcome) -> JointResponse:
    times = outcome.series["time"]
    values = outcome.series[f"joint_{number}"]
    begin = min(range(len(times)), key=lambda k: abs(times[k] - signal.begin))
    end = min(range(len(times)), key=lambda k: abs(times[k] - signal.begin - WINDOW))
    moved = values[end] - values[begin]
    moved = moved if math.isfinite(moved) else 0.0
    share = moved / signal.target if signal.target else 0.0
    return JointResponse(signal.target, float(f"{moved:.6g}"), share >= ANSWERS)


def _control(
    name: str, report: MechanismReport, signals: list[_Signal], answers: Mapping[str, JointResponse]
) -> Control:
    one = report.control[name]
    signal = next((signal for signal in signals if signal.joint == name), None)
    if signal is None or name not in answers:
        return one
    target = float(f"{signal.target:.6g}")
    return one.model_copy(update={"actuator": signal.motor, "target": target, "moved": answers[name].moved})
