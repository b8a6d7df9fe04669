"""Diagnostics of a recording: energy, penetration, speed, joint limits, and non-finite values."""

from typing import Any

import numpy as np

from text2sim.evidence import soft_diagnostics
from text2sim.evidence.mechanical_work import work_of_motors, work_of_pushes
from text2sim.evidence.recorded_case import RecordedCase, links_of
from text2sim.evidence.spring_forces import work_of_springs
from text2sim.recording.states import Array
from text2sim.spec_schema.models.bodies import Rigid
from text2sim.spec_schema.models.controls import Force, Impulse, InitialVelocity, Torque
from text2sim.spec_schema.models.fields import Airflow, Attraction, Drag, Turbulence, Vortex, Wind
from text2sim.spec_schema.names.selectors import body_of

MADE_UP, MADE_UP_IN_JOINTS = 0.01, 0.05
"""Growth of the energy of a passive scene, over the energy in play, that is reported: for free bodies, and with joints,
where a double pendulum gains 1.7 % with steps of 0.5 ms (`tests/physics/test_pendulums.py`)."""
LIFT = 1e-4
"""The same as a height [m] by which all bodies rise: those that start a little inside each other are pushed out."""
FORCE_FIELDS = (Wind, Airflow, Drag, Attraction, Vortex, Turbulence)


def extremes(time: Array, values: Array) -> dict[str, Any]:
    """Return the first, last, smallest and largest value of a series, with times [s]; None if it is empty."""
    finite = np.flatnonzero(np.isfinite(values))
    if not len(finite):
        return dict.fromkeys(("first", "last", "min", "min_at", "max", "max_at"))
    low, high = finite[np.argmin(values[finite])], finite[np.argmax(values[finite])]
    return {
        "first": values[0], "last": values[-1], "min": values[low], "min_at": time[low],
        "max": values[high], "max_at": time[high],
    }  # fmt: skip


def energy_account(recording: RecordedCase) -> dict[str, Any]:
    """Return the mechanical energy of all loose bodies over the run, and the work of the motors [J].

    Work is the integral of force times velocity over the motors of hinges and sliders of loose bodies, and over forces,
    torques and springs, by the trapezoidal rule between frames. `change` is the energy gained beyond that: friction,
    damping and impacts make it negative; if positive, it came from what is `not_counted`, or is an artefact of the
    solver. For deformable bodies, the kinetic and gravitational energy of their points count.
    """
    states, names = recording.states, recording.names
    kinetic, potential = recording.energies(names.loose)
    total = kinetic + potential
    power, motors = work_of_motors(recording)
    work, pushed = sum(motors.values()), work_of_pushes(recording) | work_of_springs(recording)
    row = extremes(states.time, total)
    change = None if row["first"] is None else row["last"] - row["first"] - work - sum(pushed.values())
    till = 0 if row["max_at"] is None else int(np.searchsorted(states.time, row["max_at"])) + 1
    controls = recording.case.actions.controls
    pushes = [
        name
        for name, c in controls.items()
        if isinstance(c, (Force, Torque, Impulse, *FORCE_FIELDS)) and name not in pushed
    ]
    loose = {target.copy for target in names.loose}
    not_counted = [f"work of the control `{name}`" for name in pushes]
    not_counted += [f"work of the driven body `{name}`" for name in names.driven]
    not_counted += [f"work of the moving surface of `{name}`" for name in _belts(recording)]
    if any(not link.fixed and link.mass <= 0 for link in states.links if link.body in loose):
        not_counted.append("links without mass")
    soft = dict.fromkeys(body_of(t.copy) for t in names.loose if t.soft is not None)
    not_counted += [f"what deformation stores in `{name}`" for name in soft]
    return {
        "unit": "J", "start": row["first"], "end": row["last"], "min": row["min"], "min_at": row["min_at"],
        "max": row["max"], "max_at": row["max_at"], "work_of_motors": work,
        "work_until_max": float(np.trapezoid(power[:till], states.time[:till])) if till > 1 else 0.0,
        "works": {"motors": motors, "controls": pushed},
        "change": change, "not_counted": not_counted,
    }  # fmt: skip


def energy_from_nowhere(recording: RecordedCase) -> list[str]:
    """Return a message if the energy of a passive scene grows, else an empty list.

    In a passive scene nothing has a motor or a spring, and bodies have at most an initial velocity, so that its energy
    can only fall. The gain is compared with the larger of the kinetic energy and the change of the potential energy.
    """
    case, states = recording.case, recording.states
    bodies, controls = case.bodies.values(), case.actions.controls.values()
    if (
        not all(body.passive for body in bodies)
        or not all(isinstance(c, InitialVelocity) for c in controls)
        or _belts(recording)
        or states.frames < 2
    ):
        return []
    kinetic, potential = recording.energies(recording.names.loose)
    total = kinetic + potential
    if not np.isfinite(total).all():
        return []
    at = int(total.argmax())
    gain, scale = total[at] - total[0], max(kinetic.max(), np.ptp(potential))
    weight = recording.masses[links_of(recording.names.loose)].sum() * np.linalg.norm(states.gravity)
    least = (
        MADE_UP
        if all(isinstance(b, Rigid) and b.mount.kind in ("free", "fixed") for b in bodies)
        else MADE_UP_IN_JOINTS
    )
    if gain <= max(least * scale, LIFT * weight):
        return []
    return [
        f"energy grows by {100 * gain / scale:.2g} % in a scene that nothing drives, at {states.time[at]:.3g} s: the "
        "solver added it; use more substeps"
    ]


def _belts(recording: RecordedCase) -> list[str]:
    """Return the names of the statics whose surfaces move."""
    return [name for name, static in recording.case.scene.statics.items() if static.carries]


def energy_series(recording: RecordedCase) -> dict[str, Array]:
    """Return kinetic, potential and total energy (F,) [J] of all loose bodies."""
    kinetic, potential = recording.energies(recording.names.loose)
    return {"kinetic": kinetic, "potential": potential, "total": kinetic + potential}


def largest_penetration(recording: RecordedCase) -> dict[str, Any] | None:
    """Return the deepest penetration of the run [m], its links and its time; None without contacts."""
    log = recording.contacts
    rows = np.flatnonzero(np.isfinite(log.depth))
    if not len(rows):
        return None
    row = rows[np.argmax(log.depth[rows])]
    names = [recording.names.label_of_link(i) for i in log.links[row]]
    return {"value": log.depth[row], "unit": "m", "between": names, "time": log.step[row] * recording.states.dt}


def first_non_finite(recording: RecordedCase) -> dict[str, Any] | None:
    """Return the first frame with a non-finite recorded state, and the bodies affected; None if all are finite."""
    states = recording.states
    bad = np.zeros((states.frames, len(states.links)), dtype=bool)
    for rows in (states.pos, states.quat, states.vel, states.ang):
        bad |= ~np.isfinite(rows).all(axis=2)
    frames = np.flatnonzero(bad.any(axis=1))
    found = [(int(frames[0]), [states.links[i].body for i in np.flatnonzero(bad[frames[0]])])] if len(frames) else []
    soft = soft_diagnostics.first_non_finite(recording)
    found += [soft] if soft is not None else []
    if not found:
        return None
    frame = min(first for first, _ in found)
    struck = [name for first, names in found if first == frame for name in names]
    return {"time": states.time[frame], "frame": frame, "bodies": list(dict.fromkeys(struck))[:20]}


def speed_extremes(recording: RecordedCase) -> dict[str, Any]:
    """Return the largest speed [m/s] and angular speed [rad/s] of the links of each body, with time and copy."""
    found: dict[str, Any] = {}
    for name, target in recording.names.copies.items():
        if recording.names.is_static(name) or not recording.states.frames:
            continue
        if target.soft is None:
            rows = [*zip(("linear", "angular"), ("m/s", "rad/s"), recording.fastest(target), strict=True)]
        else:
            rows = [("linear", "m/s", np.linalg.norm(recording.velocity(target), axis=1))]
        for key, unit, speeds in rows:
            row = extremes(recording.states.time, speeds)
            fastest = found.setdefault(body_of(name), {})
            if row["max"] is not None and (key not in fastest or row["max"] > fastest[key]["max"]):
                fastest[key] = {"max": row["max"], "at": row["max_at"], "copy": name, "unit": unit}
    return found


def limit_overshoots(recording: RecordedCase) -> list[dict[str, Any]]:
    """Return how far joints exceeded their limits [rad or m], largest first."""
    states, found = recording.states, []
    for joint in states.joints:
        if joint.kind not in ("hinge", "slider") or not states.frames:
            continue
        position = states.qpos[:, joint.q[0]].astype(float)
        for end, limit, sign in (("lower", joint.limits[0], -1.0), ("upper", joint.limits[1], 1.0)):
            if limit is None:
                continue
            row = extremes(states.time, sign * (position - limit))
            if row["max"] is not None and row["max"] > 0:
                label = joint.body if joint.name == body_of(joint.body) else f"{joint.body}.{joint.name}"
                unit = "rad" if joint.kind == "hinge" else "m"
                found.append(
                    {"joint": label, "end": end, "limit": limit, "by": row["max"], "at": row["max_at"], "unit": unit}
                )
    return sorted(found, key=lambda row: (-row["by"], row["joint"], row["end"]))
