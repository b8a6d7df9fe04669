"""Distances of driven bodies from the path that the case prescribes."""

from typing import Any

import numpy as np

from text2sim.compiler.placing.patterns import copy_variables
from text2sim.compiler.prescribed import displacement
from text2sim.compiler.schedules import value_at
from text2sim.compiler.shapes.rotation import vector_unit
from text2sim.evidence.recorded_case import RecordedCase
from text2sim.evidence.selection import RecordedTarget
from text2sim.recording.states import Array
from text2sim.recording.vectors import rotate
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.models.bodies import Body, Driven
from text2sim.spec_schema.models.motion import Spin
from text2sim.spec_schema.models.repeat import Divided
from text2sim.spec_schema.names.selectors import body_of

OFF_PATH, OFF_TURN = 2e-3, 0.02
"""Deviation [m, rad] beyond which a driven body was held up."""


def off_path(recording: RecordedCase, loaded: LoadedCase | None = None) -> list[dict[str, Any]]:
    """Return the largest deviation of each driven body's copies [m; rad if it spins], and its time.

    Args:
        recording: The run.
        loaded: The case as it was read, for bodies whose copies move differently;
            without it they count as the first does.
    """
    found: dict[str, dict[str, Any]] = {}
    states = recording.states
    for copy in recording.names.driven if states.frames else ():
        name, target = body_of(copy), recording.names.copies[copy]
        body = _own(recording.case.bodies[name], copy, loaded)
        if body is None:
            continue
        if isinstance(body.motion, Spin):
            unit, gaps = "rad", _angle(recording, target, body.motion)
        else:
            unit, gaps = "m", _distance(recording, target, body)
        gaps = np.where(np.isfinite(gaps), gaps, -np.inf)
        at = int(gaps.argmax())
        if np.isfinite(gaps[at]) and (name not in found or gaps[at] > found[name]["value"]):
            time = float(states.time[at])
            found[name] = {"copy": copy, "value": float(gaps[at]), "unit": unit, "at": time}
    return list(found.values())


def held_up(rows: list[dict[str, Any]]) -> list[str]:
    """Return a message for each body that is far off its path."""
    sentences = []
    for row in rows:
        if row["value"] > (OFF_PATH if row["unit"] == "m" else OFF_TURN):
            size = f"{1e3 * row['value']:.3g} mm" if row["unit"] == "m" else f"{row['value']:.3g} rad"
            sentences.append(
                f"`{row['copy']}` is {size} off its prescribed path at {row['at']:.3g} s: what it met is too heavy, or "
                "cannot give way"
            )
    return sentences


def _own(body: Body, copy: str, loaded: LoadedCase | None) -> Driven | None:
    """Return the driven body as one copy has it; None if that is not known."""
    assert isinstance(body, Driven)
    name = body_of(copy)
    if body.repeat is None or loaded is None or not loaded.varies(("bodies", name, "motion")):
        return body
    number = int(copy[len(name) + 1 : -1])
    variables = () if isinstance(body.repeat, Divided) else copy_variables(body.repeat)
    own = loaded.body_copy(name, variables[number]) if number < len(variables) else None
    return own if isinstance(own, Driven) else None


def _distance(recording: RecordedCase, target: RecordedTarget, body: Driven) -> Array:
    """Distance [m] from the prescribed position, shape (F,)."""
    path = np.array([displacement(body.motion, float(t)) for t in recording.states.time])
    positions = recording.states.pos[:, target.root].astype(float)
    return np.linalg.norm(positions - positions[0] - (path - path[0]), axis=1)


def _angle(recording: RecordedCase, target: RecordedTarget, motion: Spin) -> Array:
    """Angle [rad] from the prescribed one, shape (F,): the program prescribes the sum of speed times step."""
    states = recording.states
    speeds = [value_at(motion.speed, k * states.dt) for k in range(int(states.steps[-1]))]
    angle = np.concatenate([[0.0], np.cumsum(speeds) * states.dt])[states.steps]
    half = (angle / 2)[:, None]
    axis = np.array(vector_unit(motion.axis))
    quat = states.quat[:, target.root].astype(float)
    turn = np.concatenate([np.cos(half), np.sin(half) * axis], axis=1)
    axes = [rotate(quat, e) - rotate(turn, rotate(quat[:1], e)) for e in np.eye(3)]
    # The squared distances of the axes of two frames at an angle to each other sum to 8 sin^2(angle / 2).
    return 2 * np.arcsin(np.minimum(np.sqrt(sum((gap * gap).sum(axis=1) for gap in axes) / 8), 1.0))
