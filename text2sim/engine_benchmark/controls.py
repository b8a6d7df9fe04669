"""Targets of driven joints as tables over time."""

import ast
from bisect import bisect_right
from math import degrees
from typing import Any

from text2sim.compiler.plan import Plan
from text2sim.compiler.schedules import value_at
from text2sim.spec_schema.models.motion import Piecewise, Ramp, Sine, Steps


def tables(plan: Plan) -> list[dict[str, Any]]:
    """Return mode, gains, and the target at every time step of each driven joint.

    The force of the motor is, by mode: position: stiffness (target - position) + damping (target velocity - velocity);
    velocity: damping (target - velocity), both at most `max_force`; force: the target.
    """
    motors = {(motor.entity, motor.joint): motor for motor in plan.motors}
    times = [round(k * plan.dt, 9) for k in range(plan.steps + 1)]
    rows = []
    for drive in plan.drives:
        motor = motors.get((drive.entity, drive.joint))
        starts = [segment.start for segment in drive.segments]
        calls = [_call(str(segment.target)) for segment in drive.segments]
        targets = [_value(*calls[max(bisect_right(starts, t) - 1, 0)], t) for t in times]
        rows.append(
            {
                "body": drive.entity,
                "joint": drive.joint,
                "mode": drive.segments[0].mode,
                "stiffness": motor.stiffness if motor else 0.0,
                "damping": motor.damping if motor else 0.0,
                "max_force": motor.max_force if motor else None,
                "every": plan.dt,
                "targets": [float(f"{target:.9g}") for target in targets],
            }
        )
    return rows


def _call(code: str) -> tuple[str, dict[str, Any]]:
    """Name and arguments of a schedule's constructor in the code that the compiler writes."""
    node = ast.parse(code, mode="eval").body
    assert isinstance(node, ast.Call)
    assert isinstance(node.func, ast.Name)
    return node.func.id, {str(word.arg): ast.literal_eval(word.value) for word in node.keywords}


def _value(name: str, a: dict[str, Any], t: float) -> float:
    if name == "constant":
        return float(a["value"])
    if name == "ramp":
        u = {"kind": "ramp", "start": a["start"], "end": a["end"], "to": a["after"], "ease": a["ease"]}
        return value_at(Ramp.model_validate({**u, "from": a["before"]}), t)
    if name in ("sine", "fading_sine"):
        rest = {key: value for key, value in a.items() if key != "phase"}
        return value_at(Sine.model_validate({"kind": "sine", **rest, "phase_deg": degrees(a["phase"])}), t)
    if name == "steps":
        return value_at(Steps.model_validate({"kind": "steps", **a}), t)
    ease = {"piecewise": "linear", "spline": "spline" if any(a.get("slopes", [0])) else "smooth"}[name]
    rows = {"times": a["times"], "values": a["values"], "ease": ease}
    return value_at(Piecewise.model_validate({"kind": "piecewise", **rows}), t)
