"""The speed above which a scene with deformable bodies must have diverged.

Three of the engine's solvers never check their own numbers, which may be finite and yet far from anything that the
scene could do. Everything that could cause speed is added up here, generously.
"""

from collections.abc import Iterable
from math import hypot, sqrt
from pathlib import Path
from typing import Any

from text2sim.compiler.action_rows import Airflow
from text2sim.compiler.controls import ControlRows
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.prescribed import top_speed
from text2sim.compiler.schedules import largest
from text2sim.compiler.soft.settings import snap_speed
from text2sim.compiler.soft.setup import MAX_SPEED
from text2sim.compiler.soft.solver_domain import extents_of, floor_height
from text2sim.compiler.soft.streams import stream_velocity
from text2sim.spec_schema.models.bodies import Articulated, Driven
from text2sim.spec_schema.models.controls import Control
from text2sim.spec_schema.models.fields import Attraction, Drag, Turbulence, Vortex, Wind
from text2sim.spec_schema.models.motion import Spin
from text2sim.spec_schema.models.scene import Scene, Static

SPEED_FACTOR, SPEED_MARGIN = 5.0, 10.0
"""The limit is this many times the sum of all speeds, plus this [m/s]: corners of cloth whip, drops splash, and heavy
bodies throw light ones at twice their speed."""
MOTOR_SPEED = 20.0
"""Speed [m/s] that any motor is assumed to cause, since a stiff one jumps to its target."""
PART_SPEED_FACTOR = 4.0
"""Speed that a force gives the part of a body on which it acts, over that of the whole body."""
GUST_FACTOR = 4.0
"""Speed of the strongest gust over its root mean square."""


def speed_limit(
    scene: Scene,
    controls: Iterable[Control],
    rows: ControlRows,
    placed: dict[str, list[Copy]],
    masses: dict[str, float],
    folder: Path,
) -> tuple[float, str]:
    """Return the speed [m/s] at which a run stops as diverged, and why it is that.

    Args:
        scene: The section.
        controls: Of the case.
        rows: Controls, lowered.
        placed: Copies by static and body.
        masses: Mass [kg] of deformable bodies by copy.
        folder: The case's folder.

    Raises:
        AssetError: if a file of a shape cannot be used.
    """
    if rows.wrenches:
        return MAX_SPEED, "forces push rigid bodies: nothing is said of how fast"
    time = scene.duration
    floors, tops = [], []
    for copy in (copy for group in placed.values() for copy in group):
        if (height := floor_height(copy)) is not None:
            floors.append(height)
        elif copy.shape is None or copy.shape.kind != "plane":
            tops.append(extents_of(copy, folder)[1][2])
    joints = [_joint_start(copy) for group in placed.values() for copy in group]
    given = {
        "falling": _fall(scene, floors, tops),
        "starts": max([hypot(*v.linear) + hypot(*v.angular) for v in rows.velocities] + joints, default=0.0),
        "streams": max((hypot(*(stream_velocity(c) or ())) for g in placed.values() for c in g), default=0.0),
        "motors": MOTOR_SPEED if rows.joints.targets else 0.0,
        "prescribed motion": max((_driven(c, time, folder) for g in placed.values() for c in g), default=0.0),
        "forces": sum(_push(push, masses, time) for push in rows.pushes),
        "stretched cloth": max((snap_speed(copy.model) for group in placed.values() for copy in group), default=0.0),
        "air": max((_flow(row) for row in rows.airflows), default=0.0),
        "fields": sum(_field(control, time) for control in controls) * time,
    }
    most = SPEED_FACTOR * sum(given.values()) + SPEED_MARGIN
    if most >= MAX_SPEED:
        return MAX_SPEED, "as in every scene"
    listed = ", ".join(f"{what} {speed:.2g}" for what, speed in given.items() if speed >= 0.05)
    why = f"{SPEED_FACTOR:g} times what the scene gives ({listed or 'nothing'} m/s), and {SPEED_MARGIN:g} m/s"
    return float(f"{most:.2g}"), why


def impact_speed(scene: Scene, rows: ControlRows, placed: dict[str, list[Copy]], folder: Path) -> float:
    """Return the speed [m/s] at which an mpm body may be hit: by a fall, a start, a stream or a prescribed motion.

    Args:
        scene: The section.
        rows: Controls, lowered.
        placed: Copies by static and body.
        folder: The case's folder.

    Raises:
        AssetError: if a file of a shape cannot be used.
    """
    copies = [copy for group in placed.values() for copy in group]
    solid = [copy for copy in copies if copy.shape is None or copy.shape.kind != "plane"]
    boxes = {copy.name: extents_of(copy, folder) for copy in solid}
    floors = [height for copy in copies if (height := floor_height(copy)) is not None]
    tops = [boxes[copy.name][1][2] for copy in solid if not isinstance(copy.model, Static | Driven)]
    given = [hypot(*row.linear) for row in rows.velocities]
    given += [hypot(*(stream_velocity(copy) or ())) for copy in copies]
    given += [_joint_start(copy) for copy in copies]
    given += [_driven(copy, scene.duration, folder) for copy in copies]
    return hypot(_fall(scene, floors or [low[2] for low, _ in boxes.values()], tops), max(given, default=0.0))


def _fall(scene: Scene, floors: list[float], tops: list[float]) -> float:
    """Return the speed [m/s] after a fall to the lowest floor, or for the whole run if there is none.

    Args:
        scene: Gravity and duration.
        floors: Heights [m].
        tops: Heights [m] of what may fall.
    """
    size = hypot(*scene.gravity)
    free = size * scene.duration
    if not floors or scene.gravity[2] > -0.9 * size:
        return free
    return min(free, sqrt(2 * size * max(max(tops, default=0.0) - min(floors), 0.0)))


def _joint_start(copy: Copy) -> float:
    """Return the largest speed [m/s] with which joints of a body start, 1 m from the axis of a hinge."""
    links = (copy.model.links or {}) if isinstance(copy.model, Articulated) else {}
    joints = [getattr(copy.model, "mount", None), *(link.joint for link in links.values())]
    return max(abs(getattr(joint, "initial_velocity", 0.0)) for joint in joints)


def _driven(copy: Copy, duration: float, folder: Path) -> float:
    """Return the largest speed [m/s] of a point of a body with prescribed motion."""
    if not isinstance(copy.model, Driven):
        return 0.0
    motion = copy.model.motion
    if isinstance(motion, Spin):
        low, high = extents_of(copy, folder)
        radius = max(hypot(*(x - c for x, c in zip(corner, copy.pos, strict=True))) for corner in (low, high))
        return largest(motion.speed, duration) * radius
    return top_speed(motion)


def _push(push: Any, masses: dict[str, float], duration: float) -> float:
    """Return the speed [m/s] that a force or impulse gives the part of a body on which it acts."""
    force, mass = hypot(*push.force), masses.get(push.entity, 0.0)
    if not mass:
        return 0.0
    if push.scale is not None:
        return MAX_SPEED  # its scale may have any value
    span = min(push.end, duration) - push.start
    speed = PART_SPEED_FACTOR * force / mass * (span if push.end > push.start else 1.0)
    return min(speed, force / push.drag) if push.drag else speed


def _flow(row: Airflow) -> float:
    """Return the largest speed [m/s] of the air that flows past a cloth, gusts included."""
    return row.strongest * hypot(*row.velocity) * (1 + GUST_FACTOR * row.gusts)


def _field(control: Control, duration: float) -> float:
    """Return the largest acceleration [m/s2] of a field."""
    if not isinstance(control, Wind | Drag | Attraction | Vortex | Turbulence):
        return 0.0
    scale = largest(control.scale, duration)
    if isinstance(control, Wind):
        return scale * control.acceleration
    if isinstance(control, Turbulence | Attraction):
        return scale * abs(control.strength)
    return scale * (abs(control.swirl) + abs(control.inward)) if isinstance(control, Vortex) else 0.0
