"""Probe of a mechanism: the engine drives its joints one after another, and each response is measured."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from text2sim.asset_intake.mechanism_check import MechanismReport, Subject, report_of, resolve_subject
from text2sim.asset_intake.tiny_case import BODY, TrialOutcome, run_trial, tiny_case
from text2sim.assets.manifest import Control, Motor
from text2sim.spec_schema.errors import AssetError

JOINT_TIME = 0.3
"""Time [s] for each joint; above `MAX_WINDOWS` joints, several move at the same time."""
MAX_WINDOWS = 12
MAX_JOINTS = 60
STEP = 0.005
TARGET_ANGLE, TARGET_DISTANCE = 0.15, 0.03
"""Targets [rad, m] of joints whose range is large enough."""
TARGET_SHARE = 0.4
"""Largest target, as a part of the free range."""
MIN_RESPONSE = 0.5
"""Part of the target that a joint must reach to respond."""
MOTOR_FREQUENCY = 20.0
"""Natural frequency [rad/s] of motors that the probe adds."""


@dataclass(frozen=True)
class JointResponse:
    """Response of a joint."""

    target: float
    """Target relative to the start [rad or m]."""
    moved: float
    """Distance that it moved [rad or m]."""
    answers: bool
    """Whether that is at least half of the target; a joint that dry friction holds creeps a third."""


@dataclass(frozen=True)
class ProbeReport:
    """Result of a probe."""

    ok: bool
    """Whether it ran to its end and every joint responded."""
    state: str
    message: str
    """Why it ended early, or why a joint may not have responded."""
    joints: Mapping[str, JointResponse]
    given: tuple[str, ...]
    """Joints without a motor, which got one for the probe."""
    left_out: tuple[str, ...]
    """Joints that were not driven: balls, names that a case cannot use, too many."""
    control: Mapping[str, Control]
    """Joints with their responses, for the manifest; it proposes the motors that the probe added."""
    report: MechanismReport
    wall: float
    """Wall time [s]."""


@dataclass(frozen=True)
class _Signal:
    """Signal for a joint."""

    joint: str
    start: float
    """Position at the start [rad or m]."""
    target: float
    """Target relative to the start [rad or m]."""
    motor: Motor
    begin: float
    """Time of its beginning [s]."""


def probe(what: Path | Mapping[str, Any], folder: Path | None = None) -> ProbeReport:
    """Move each joint of a mechanism a little, without gravity and with its root held.

    Raises:
        AssetError: if it cannot be used, or has no joint that can be driven.
        MachineError: if this machine cannot run the engine.
    """
    subject = Subject.of(what, folder)
    resolution = resolve_subject(subject)
    report, starts = report_of(resolution), resolution.lowering.trees[BODY].initial
    driven = [n for n, control in report.control.items() if control.kind != "ball" and n.isidentifier() and n.isascii()]
    driven = driven[:MAX_JOINTS]
    if not driven:
        raise AssetError("has no hinge or slider that can be driven")
    signals = _signals(starts, report, driven)
    given = tuple(signal.joint for signal in signals if report.control[signal.joint].actuator is None)
    outcome = run_trial(_case(subject, signals, given))
    recorded = bool(outcome.series.get("time"))
    responses = {s.joint: _response(n, s, outcome) for n, s in enumerate(signals)} if recorded else {}
    all_respond = all(response.answers for response in responses.values())
    message = outcome.message
    if not message and report.loops and not all_respond:
        message = "joints that are coupled by constraints block each other when only one is driven"
    return ProbeReport(
        ok=outcome.ok and len(responses) == len(driven) and all_respond,
        state=outcome.state,
        message=message,
        joints=responses,
        given=given,
        left_out=tuple(name for name in report.control if name not in driven),
        control={name: _control(name, report, signals, responses) for name in report.control},
        report=report,
        wall=outcome.wall,
    )


def _signals(starts: Mapping[str, float], report: MechanismReport, driven: list[str]) -> list[_Signal]:
    windows = min(len(driven), MAX_WINDOWS)
    found = []
    for number, name in enumerate(driven):
        control = report.control[name]
        low, high = control.range or (-math.inf, math.inf)
        start = starts.get(name, 0.0)
        if not low <= start <= high:
            start = (low + high) / 2
        up = high - start >= (start - low) * (1 - 1e-9)
        room = TARGET_SHARE * (high - start if up else start - low)
        target = min(TARGET_DISTANCE if control.unit == "m" else TARGET_ANGLE, room) * (1 if up else -1)
        motor = control.actuator or _proposal(control, report)
        found.append(_Signal(name, start, target, motor, STEP * 4 + JOINT_TIME * (number % windows)))
    return found


def _proposal(control: Control, report: MechanismReport) -> Motor:
    """A motor that is strong enough for any joint of a mechanism of this mass and size."""
    reach = max(max(report.size) / 2, 0.01)
    inertia = max(report.mass, 1e-3) * (1.0 if control.kind == "slider" else reach**2)
    return Motor(
        stiffness=float(f"{inertia * MOTOR_FREQUENCY**2:.3g}"), damping=float(f"{2 * inertia * MOTOR_FREQUENCY:.3g}")
    )


def _case(subject: Subject, signals: list[_Signal], given: tuple[str, ...]) -> Any:
    body = dict(subject.body)
    starts = {signal.joint: signal.start for signal in signals if signal.start != 0.0}
    if starts:
        body["initial"] = {**(body.get("initial") or {}), **starts}
    motors = {s.joint: {"actuator": s.motor.model_dump(exclude_none=True)} for s in signals if s.joint in given}
    if motors and "file" in body:
        body["joints"] = {**(body.get("joints") or {}), **motors}
    elif motors:
        links = {name: dict(link) for name, link in body["links"].items()}
        for name, change in motors.items():
            links[name]["joint"] = {**links[name]["joint"], **change}
        body["links"] = links
    duration = max(signal.begin for signal in signals) + JOINT_TIME
    scene = {"duration": duration, "dt": STEP, "gravity": [0, 0, 0]}
    actions = {
        "controls": {f"drive_{n}": _drive(signal) for n, signal in enumerate(signals)},
        "measures": {f"joint_{n}": {"kind": "joint_position", "of": _selector_of(s)} for n, s in enumerate(signals)},
    }
    return tiny_case(subject.folder, body, scene, actions=actions)


def _selector_of(signal: _Signal) -> str:
    return f"{BODY}.{signal.joint}"


def _drive(signal: _Signal) -> dict[str, Any]:
    motor, drive = signal.motor, {"kind": "drive", "joint": _selector_of(signal)}
    begin, end = signal.begin, signal.begin + JOINT_TIME
    if motor.stiffness > 0:
        times, values = [begin, begin + JOINT_TIME / 2], [signal.start, signal.start + signal.target]
        return drive | {"position": {"kind": "piecewise", "times": times, "values": values}}
    if motor.damping > 0:
        speed = signal.target / JOINT_TIME
        return drive | {"velocity": {"kind": "steps", "times": [begin, end], "values": [speed, 0.0]}}
    force = math.copysign(min(0.2 * (motor.max_force or 5.0), 1.0), signal.target)
    return drive | {"force": {"kind": "steps", "times": [begin, end], "values": [force, 0.0]}}


def _response(number: int, signal: _Signal, outcome: TrialOutcome) -> JointResponse:
    times = outcome.series["time"]
    values = outcome.series[f"joint_{number}"]
    begin = min(range(len(times)), key=lambda k: abs(times[k] - signal.begin))
    end = min(range(len(times)), key=lambda k: abs(times[k] - signal.begin - JOINT_TIME))
    moved = values[end] - values[begin]
    moved = moved if math.isfinite(moved) else 0.0
    share = moved / signal.target if signal.target else 0.0
    return JointResponse(signal.target, float(f"{moved:.6g}"), share >= MIN_RESPONSE)


def _control(
    name: str, report: MechanismReport, signals: list[_Signal], responses: Mapping[str, JointResponse]
) -> Control:
    control = report.control[name]
    signal = next((signal for signal in signals if signal.joint == name), None)
    if signal is None or name not in responses:
        return control
    target = float(f"{signal.target:.6g}")
    return control.model_copy(update={"actuator": signal.motor, "target": target, "moved": responses[name].moved})
