"""Marks for a picture of the start: joint axes, initial velocities, forces, cameras."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from math import hypot

import numpy as np

from text2sim.compiler.build import Resolution
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.piece import piece_reach
from text2sim.compiler.shapes.rotation import Quaternion, Vec, frame_apply, quat_rotate, vector_plus
from text2sim.compiler.trees.tree import StandingLink, TreeJoint, tree_links
from text2sim.drawing.prop import Prop
from text2sim.drawing.views import camera_pose, cameras, film_view
from text2sim.spec_schema.models.motion import Oscillate, Waypoints
from text2sim.spec_schema.models.placed import Linked

MAX_MARKS = 300
"""Largest numbers of joints, and of arrows of a control, that are drawn."""
UNITS = {"velocity": "m/s", "spin": "rad/s", "force": "N", "torque": "N m", "impulse": "N s"}


@dataclass(frozen=True)
class JointMark:
    """A joint of the case."""

    kind: str
    """hinge, slider, ball, path (of a driven body), or spring."""
    points: tuple[Vec, ...]
    """Ends of its axis or of the spring, points of the path, or the centre of a ball joint [m]."""
    body: str
    """Name of the body."""


@dataclass(frozen=True)
class ArrowMark:
    """A vector of the case."""

    kind: str
    """velocity, spin, force, torque or impulse."""
    start: Vec
    """Start of the arrow [m]."""
    vector: Vec
    """The vector, in its own unit."""
    text: str
    """Text beside it; empty if another arrow has it."""


@dataclass(frozen=True)
class CameraMark:
    """A camera of the case, and its field of view."""

    name: str
    eye: Vec
    target: Vec
    corners: tuple[Vec, ...]
    """Corners of the field of view at the distance of the target [m]."""


def joint_marks(resolution: Resolution) -> list[JointMark]:
    """Return springs, and joints of mounted, driven and articulated bodies; those of chains and nets are obvious."""
    copies = {copy.name: copy for group in resolution.placed.values() for copy in group}
    found: list[JointMark] = []
    for spring in resolution.plan.springs:
        a, b = copies[spring.a], copies[spring.b]
        ends = ((a, spring.a_link, spring.a_point), (b, spring.b_link, spring.b_point))
        poses = [(*(_place(resolution, copy, link) or (copy.pos, copy.quat)), point) for copy, link, point in ends]
        found.append(JointMark("spring", tuple(frame_apply(*pose) for pose in poses), a.body))
    for copy in _copies(resolution):
        tree = resolution.lowering.trees.get(copy.name)
        if tree is None or isinstance(copy.model, Linked):
            continue
        motion = getattr(copy.model, "motion", None)
        if isinstance(motion, Waypoints):
            found.append(JointMark("path", tuple(vector_plus(copy.pos, away) for away in motion.positions), copy.body))
            continue
        for standing in tree_links(tree, copy.pos, copy.quat):
            for _, joint in standing.link.all_joints():
                if joint.kind == "free":
                    continue
                if isinstance(motion, Oscillate):
                    joint = replace(joint, range=(-motion.amplitude, motion.amplitude))
                found.append(_joint(standing, joint, copy.body))
    return found[:: len(found) // MAX_MARKS + 1]


def _joint(standing: StandingLink, joint: TreeJoint, body: str) -> JointMark:
    anchor = frame_apply(standing.pos, standing.quat, joint.anchor)
    if joint.kind == "ball":
        return JointMark("ball", (anchor,), body)
    axis, back = joint.axis, (-joint.axis[0], -joint.axis[1], -joint.axis[2])
    level = sum(a * b for a, b in zip(joint.anchor, axis, strict=True))
    pieces = [geom.piece for geom in standing.link.geoms]
    low = min((-piece_reach(piece, back) - level for piece in pieces), default=0.0)
    high = max((piece_reach(piece, axis) - level for piece in pieces), default=0.0)
    axis = quat_rotate(standing.quat, axis)
    if joint.kind == "slider" and joint.range is not None:
        low, high = joint.range
    return JointMark(
        joint.kind, (_end_of_axis(anchor, axis, min(low, 0.0)), _end_of_axis(anchor, axis, max(high, 0.0))), body
    )


def arrow_marks(resolution: Resolution, props: Iterable[Prop]) -> list[ArrowMark]:
    """Return initial velocities, and forces, torques and impulses at any time."""
    centers = _centers(props)
    copies = {copy.name: copy for copy in _copies(resolution)}
    rows: dict[tuple[str, str], list[tuple[Vec, Vec]]] = {}
    notes: dict[tuple[str, str], str] = {}

    def add(kind: str, control: str, start: Vec, vector: Vec, note: str = "") -> None:
        if any(vector):
            rows.setdefault((kind, control), []).append((start, vector))
            notes[kind, control] = note

    for row in resolution.plan.velocities:
        start = centers.get(row.entity, copies[row.entity].pos)
        add("velocity", row.control, start, row.linear)
        add("spin", row.control, start, row.angular)
    for row in resolution.plan.wrenches:
        copy = copies[row.entity]
        start, quat = _place(resolution, copy, row.link) or (centers.get(row.entity, copy.pos), copy.quat)
        if row.point is not None:
            start = frame_apply(start if row.link else copy.pos, quat, row.point)
        when = "" if row.start <= 0 else f" at {row.start:g} s"
        force, torque = (quat_rotate(quat, v) if row.local else v for v in (row.force, row.torque))
        add("impulse" if row.start == row.end else "force", row.control, start, force, when)
        add("torque", row.control, start, torque, when)
    found = []
    for (kind, control), arrows in rows.items():
        sizes = [hypot(*vector) for _, vector in arrows]
        low, high = f"{min(sizes):.3g}", f"{max(sizes):.3g}"
        text = f"{low if low == high else f'{low} to {high}'} {UNITS[kind]}{notes[kind, control]}"
        drawn = arrows[:: len(arrows) // MAX_MARKS + 1]
        for number, (start, vector) in enumerate(drawn):
            # The text is only beside the middle arrow.
            found.append(ArrowMark(kind, start, vector, text if number == len(drawn) // 2 else ""))
    return found


def camera_marks(resolution: Resolution) -> list[CameraMark]:
    """Return the cameras of the case at the start; none if the camera is derived."""
    if not resolution.loaded.case.render.cameras:
        return []
    found = []
    for name in cameras(resolution):
        view = film_view(resolution, name, (160, 160))
        target = camera_pose(resolution, name).target
        reach = max(-float(view.local(np.asarray(target))[2]), view.near)
        corners = []
        for x, y in ((0, 0), (view.width, 0), (view.width, view.height), (0, view.height)):
            start, ray = view.sight(np.array([x], float), np.array([y], float))
            corners.append(_vec(start[:, 0] + reach * ray[:, 0]))
        found.append(CameraMark(name, _vec(view.origin), target, tuple(corners)))
    return found


def _place(resolution: Resolution, copy: Copy, link: str | None) -> tuple[Vec, Quaternion] | None:
    tree = resolution.lowering.trees.get(copy.name)
    if tree is None or link is None:
        return None
    for standing in tree_links(tree, copy.pos, copy.quat):
        if standing.link.name == link:
            return standing.pos, standing.quat
    return None


def _copies(resolution: Resolution) -> Iterator[Copy]:
    for name in resolution.loaded.case.bodies:
        yield from resolution.placed[name]


def _centers(props: Iterable[Prop]) -> dict[str, Vec]:
    """Centre [m] of the bounding box of each copy's triangles."""
    return {
        prop.name: _vec((points.min(axis=0) + points.max(axis=0)) / 2)
        for prop in props
        if len(points := prop.triangles.reshape(-1, 3))
    }


def _end_of_axis(point: Vec, axis: Vec, length: float) -> Vec:
    return (point[0] + length * axis[0], point[1] + length * axis[1], point[2] + length * axis[2])


def _vec(values: np.ndarray) -> Vec:
    x, y, z = values.tolist()
    return (x, y, z)
