"""How far motors, prescribed motion, start velocities, forces and fields move bodies."""

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from itertools import pairwise
from math import hypot, inf

from text2sim.compiler.action_rows import Hold, Weld
from text2sim.compiler.controls import ControlRows
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.prescribed import displacements
from text2sim.compiler.schedules import SCHEDULE_SAMPLES, largest, value_at
from text2sim.compiler.shapes.boxes import NOWHERE, Bounds, around
from text2sim.compiler.shapes.rotation import Vec, quat_rotate, vector_plus, vector_times, vector_unit
from text2sim.compiler.soft.streams import stream_velocity
from text2sim.spec_schema.models.base import span_of
from text2sim.spec_schema.models.bodies import Articulated, Driven, FixedMount, Rigid, SliderMount
from text2sim.spec_schema.models.controls import Control
from text2sim.spec_schema.models.fields import Attraction, Vortex, Wind
from text2sim.spec_schema.models.motion import Schedule, Spin
from text2sim.spec_schema.models.scene import Static
from text2sim.spec_schema.models.sheets import Sheet
from text2sim.spec_schema.models.soft_bodies import Soft

MAX_FOLLOWED_DISTANCE = 2.0
"""How far [m] a body that nothing stops is followed."""


@dataclass(frozen=True)
class Travel:
    """Displacements from the start, as boxes [m], by copy; whatever is missing stays where it is."""

    motors: dict[str, Bounds]
    """Displacements of bodies of links."""
    spins: frozenset[str]
    """Bodies that turn by a prescribed rotation, or from the start."""
    holds: dict[str, Bounds]
    """Displacements of deformable bodies by what holds them."""
    flights: dict[str, Vec]
    """Displacements of deformable bodies by forces and fields."""
    starts: dict[str, Vec]
    """Velocities [m/s] of deformable bodies at the start, and of streams."""
    hanging: frozenset[str]
    """Soft bodies that something which cannot fall holds throughout, so that they fall by their length at most."""


def travel(
    rows: ControlRows,
    controls: Iterable[Control],
    placed: dict[str, list[Copy]],
    masses: dict[str, float],
    gravity: float,
    duration: float,
) -> Travel:
    """Return how far bodies are moved.

    Args:
        rows: Controls, lowered.
        controls: Controls, as in the case.
        placed: Copies by static and body.
        masses: Mass [kg] of deformable bodies by copy.
        gravity: Its size [m/s2].
        duration: Of the run [s].
    """
    copies = {copy.name: copy for group in placed.values() for copy in group}
    motors: dict[str, Bounds] = {}
    for copy in copies.values():
        if isinstance(copy.model, Driven):
            motors[copy.name] = displacements(copy.model.motion)
    for name, joint in rows.joints.targets:
        mount = _slider(copies[name], joint)
        if mount is None:
            continue
        # What begins at an event may begin at the very start.
        reach = _reach([(row.mode, row.schedule) for row in rows.joints.all_of(name, joint)], duration)
        low, high = mount.range or (-inf, inf)
        axis = quat_rotate(copies[name].quat, vector_unit(mount.axis))
        ends = [vector_times(axis, min(max(s, low), high)) for s in reach]
        motors[name] = around([*motors.get(name, NOWHERE), *ends])
    towed = _towed(motors, rows.welds, copies)
    holds: dict[str, Bounds] = {}
    for hold in rows.holds:
        corners = [corner for name in hold.to for corner in towed.get(name, NOWHERE)]
        if corners:
            holds[hold.entity] = around([*holds.get(hold.entity, NOWHERE), *corners])
    flights: dict[str, Vec] = {}
    starts = {row.entity: row.linear for row in rows.velocities if row.entity in masses}
    starts |= {name: velocity for name in masses if (velocity := stream_velocity(copies[name])) is not None}
    for push in rows.pushes:
        force, mass = hypot(*push.force), masses.get(push.entity, 1.0)
        if not force:
            continue
        span = min(push.end, duration) - push.start
        distance = force / mass * span**2 / 2
        if push.start == push.end:  # an impulse: until gravity and friction stop the body, or the run ends
            distance = force / mass * (min(duration, 2 * force / mass / gravity) if gravity else duration)
        elif push.drag:
            distance = min(distance, force / push.drag * span)
        _fly(flights, push.entity, push.force, min(distance, MAX_FOLLOWED_DISTANCE) / force)
    held = {name for hold in rows.holds for name in (hold.entity, *(hold.to if hold.seam is not None else ()))}
    sails = {hold.entity for hold in rows.holds if any(_is_free(copies[name]) for name in hold.to)}
    for flow in rows.airflows:
        if fast := hypot(*flow.velocity):
            shape = copies[flow.entity].shape
            far = min(flow.strongest * fast * duration, MAX_FOLLOWED_DISTANCE)
            if flow.entity in held and isinstance(shape, Sheet):  # it may be blown to the other side
                far = 2 * hypot(*shape.size) + (far if flow.entity in sails else 0.0)
            _fly(flights, flow.entity, flow.velocity, far / fast)
    for control in controls:
        for name in masses:
            _carry(flights, control, copies[name], duration)
    spins = {name for name, copy in copies.items() if isinstance(getattr(copy.model, "motion", None), Spin)}
    spins |= {row.entity for row in rows.velocities if hypot(*row.angular) and row.entity in masses}
    hanging = {hold.entity for hold in rows.holds if _holds_up(hold, copies, motors)}
    return Travel(motors, frozenset(spins), holds, flights, starts, frozenset(hanging))


def _towed(motors: dict[str, Bounds], welds: Iterable[Weld], copies: dict[str, Copy]) -> dict[str, Bounds]:
    """Return displacements of what motors move, and of ropes and free bodies that are welded to it, one to the next."""
    towed = dict(motors)
    tied = [pair for weld in welds for pair in ((weld.a, weld.b), (weld.b, weld.a))]
    while new := {
        other: towed[one]
        for one, other in tied
        if one in towed and other not in towed and other in copies and _is_loose(copies[other])
    }:
        towed |= new
    return towed


def _is_loose(copy: Copy) -> bool:
    """Return whether what is tied to a body takes it along."""
    return copy.model.kind in ("rope", "chain") or _is_free(copy)


def _holds_up(hold: Hold, copies: dict[str, Copy], motors: Collection[str]) -> bool:
    """Return whether a soft body cannot fall, since what is fixed, or what `motors` move, always holds it."""
    model = copies[hold.entity].model
    if not isinstance(model, Soft) or model.material.tear_stretch is not None or hold.until or hold.start > 0.0:
        return False
    return all(
        name in motors
        or isinstance(copies[name].model, Static)
        or isinstance(getattr(copies[name].model, "mount", None), FixedMount)
        for name in hold.to
    )


def _is_free(copy: Copy) -> bool:
    """Return whether nothing joins a body to the world: a sail takes its boat along."""
    model = copy.model
    return getattr(getattr(model, "mount", None), "kind", None) == "free" or getattr(model, "base", None) == "free"


def _fly(flights: dict[str, Vec], name: str, displacement: Vec, times: float) -> None:
    flights[name] = vector_plus(flights.get(name, (0.0, 0.0, 0.0)), vector_times(displacement, times))


def _carry(flights: dict[str, Vec], field: Control, copy: Copy, duration: float) -> None:
    """Add how far a field takes a body: along a wind, around a vortex, towards what attracts it."""
    if not isinstance(field, Wind | Vortex | Attraction):
        return
    start, end = span_of(field.during, duration)
    square = largest(field.scale, duration) * max(min(end, duration) - start, 0.0) ** 2 / 2
    if isinstance(field, Wind):
        far = min(field.acceleration * square, MAX_FOLLOWED_DISTANCE / 2)
        _fly(flights, copy.name, vector_unit(field.direction), far)
        return
    x, y, z = (c - p for c, p in zip(field.center, copy.pos, strict=True))
    if isinstance(field, Attraction):
        size = hypot(x, y, z)
        if field.strength > 0:
            far = min(field.strength * square, 2 * size)
        else:
            far = -min(-field.strength * square, MAX_FOLLOWED_DISTANCE)
        _fly(flights, copy.name, (x, y, z), far / size if size else 0.0)
        return
    size = hypot(x, y)
    sign = 1.0 if field.swirl > 0 else -1.0
    far = min(abs(field.swirl) * square, MAX_FOLLOWED_DISTANCE)
    _fly(flights, copy.name, (y * sign, -x * sign, 0.0), far / size if size else 0.0)


def _slider(copy: Copy, joint: str) -> SliderMount | None:
    """Return the slider that a drive moves; None for other kinds of joint."""
    model = copy.model
    mount = model.mount if isinstance(model, Rigid) else None
    if isinstance(model, Articulated) and model.links is not None and joint in model.links:
        mount = model.links[joint].joint
    return mount if isinstance(mount, SliderMount) else None


def _reach(targets: list[tuple[str, Schedule]], duration: float) -> tuple[float, float]:
    """Return the lowest and highest position [m] that drives of a slider ask for.

    A position is followed wherever it is; a velocity is not, since something may stop the slider.
    """
    times = [duration * k / SCHEDULE_SAMPLES for k in range(SCHEDULE_SAMPLES + 1)]
    values = [0.0]
    for mode, schedule in targets:
        if mode == "position":
            values += [value_at(schedule, t) for t in times]
        elif mode == "velocity":
            position = 0.0
            for a, b in pairwise(times):
                position += value_at(schedule, (a + b) / 2) * (b - a)
                values.append(min(max(position, -MAX_FOLLOWED_DISTANCE), MAX_FOLLOWED_DISTANCE))
    return min(values), max(values)
