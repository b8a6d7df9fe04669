"""Inverse kinematics: where the end of an arm is to be becomes targets of its joints.

Damped least squares (Wampler 1986), from the joint positions of the previous target, so that a redundant arm turns its
joints no more than it has to. Where this gets stuck, it starts again from other positions, always the same ones.
"""

import math
from collections.abc import Collection, Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from text2sim.compiler.action_rows import Origin
from text2sim.compiler.drives import DriveTarget
from text2sim.compiler.placing.place_error import ReachError
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.rotation import (
    Quaternion,
    Vec,
    frame_apply,
    quat_conjugate,
    quat_from_euler_deg,
    quat_multiply,
)
from text2sim.compiler.trees.tree import Tree, TreeJoint, TreeLink, moved_frame
from text2sim.spec_schema.models.controls import Reach
from text2sim.spec_schema.models.motion import Ramp

Array = NDArray[Any]

POSITION_TOLERANCE, ROTATION_TOLERANCE = 5e-4, 5e-3
"""How far [m] and [rad] a solution may be off."""
DAMPING = 0.01
MAX_STEP = 0.4
"""Largest change of a joint in one iteration [rad or m]."""
MAX_ITERATIONS, MAX_TRIES = 120, 24
DIFFERENCE_STEP = 1e-6
"""Change of a joint for the differences that give slopes [rad or m]."""


class Arm:
    """The joints from the world to a link of a tree.

    Args:
        copy: Where the body stands.
        tree: Its links.
        link: Name of the last one.
    """

    def __init__(self, copy: Copy, tree: Tree, link: str):
        self.copy, self.link = copy, link
        self.chain = _chain(tree.roots, link)
        joints = [row for part in self.chain for row in part.all_joints()]
        odd = next((name for name, joint in joints if joint.kind not in ("hinge", "slider")), None)
        if odd is not None:
            raise ReachError(f"`{odd}` between the world and `{link}` is not a hinge or slider", "body")
        if tree.loops:
            raise ReachError(f"`{copy.body}` has closed loops, whose joints depend on each other", "body")
        self.joints: dict[str, TreeJoint] = dict(joints)
        if not self.joints:
            raise ReachError(f"`{link}` has no joint to move it", "body")
        self.start = np.array([tree.initial.get(name, 0.0) for name in self.joints])
        ranges = [joint.range or (-np.inf, np.inf) for joint in self.joints.values()]
        self.low, self.high = np.array(ranges, float).T

    def frame(self, q: Array) -> tuple[Vec, Quaternion]:
        """Return the position [m] and orientation of the link in the world at joint positions."""
        positions = dict(zip(self.joints, q.tolist(), strict=True))
        pos, quat = self.copy.pos, self.copy.quat
        for link in self.chain:
            pos, quat = moved_frame(link, positions, pos, quat)
        return pos, quat

    def solve(self, goal: "Goal", q: Array) -> tuple[Array, float, float]:
        """Return joint positions, and by how much [m] and [rad] the goal is missed there, beginning at `q`."""
        random = np.random.default_rng(0)
        low = np.where(np.isfinite(self.low), self.low, self.start - np.pi)
        high = np.where(np.isfinite(self.high), self.high, self.start + np.pi)
        found = []
        for trial in range(MAX_TRIES):
            tried = self._descend(goal, q if trial == 0 else random.uniform(low, high))
            miss = self.miss(goal, tried)
            found.append((tried, float(np.linalg.norm(miss[:3])), float(np.linalg.norm(miss[3:]))))
            if found[-1][1] <= POSITION_TOLERANCE and found[-1][2] <= ROTATION_TOLERANCE:
                return found[-1]
        return min(found, key=lambda row: row[1] / POSITION_TOLERANCE + row[2] / ROTATION_TOLERANCE)

    def _descend(self, goal: "Goal", q: Array) -> Array:
        for _ in range(MAX_ITERATIONS):
            miss = self.miss(goal, q)
            if (
                np.linalg.norm(miss[:3]) < POSITION_TOLERANCE / 10
                and np.linalg.norm(miss[3:]) < ROTATION_TOLERANCE / 10
            ):
                break
            steps = DIFFERENCE_STEP * np.eye(len(q))
            slopes = np.array([(miss - self.miss(goal, q + step)) / DIFFERENCE_STEP for step in steps]).T
            q = np.clip(q + self._change(slopes, miss, q), self.low, self.high)
        return q

    def _change(self, slopes: Array, miss: Array, q: Array) -> Array:
        """Return how joints move next: one that would leave its range stays, and the others make up for it."""
        free = np.ones(len(q), bool)
        while True:
            own = slopes * free
            try:
                change = own.T @ np.linalg.solve(own @ own.T + DAMPING**2 * np.eye(len(miss)), miss)
            except np.linalg.LinAlgError:  # so far away that the damping is lost to rounding
                return np.zeros_like(q)
            stuck = free & (((q <= self.low) & (change < 0)) | ((q >= self.high) & (change > 0)))
            if not stuck.any():
                return change * min(1.0, MAX_STEP / max(float(np.abs(change).max()), 1e-12))
            free &= ~stuck

    def miss(self, goal: "Goal", q: Array) -> Array:
        """Return what is left to go [m] and, if the goal says how it is turned, to turn [rad], shape (3,) or (6,)."""
        pos, quat = self.frame(q)
        left = np.array(goal.at) - frame_apply(pos, quat, goal.point)
        if goal.quat is None:
            return left
        w, *axis = quat_multiply(goal.quat, quat_conjugate(quat))
        axis = np.array(axis) if w >= 0 else -np.array(axis)  # the shorter turn
        return np.concatenate([left, axis * 2 * np.arctan2(size := np.linalg.norm(axis), abs(w)) / max(size, 1e-12)])


class Goal(NamedTuple):
    """Where a point of a link is to be."""

    at: Vec
    """[m], world"""
    point: Vec
    """[m], in the link's frame"""
    quat: Quaternion | None
    """Orientation of the link; None for any."""


def _chain(roots: Iterable[TreeLink], name: str) -> list[TreeLink]:
    """Return the links from the world to the link of this name."""
    for link in roots:
        if link.name == name:
            return [link]
        if below := _chain(link.children, name):
            return [link, *below]
    return []


def reach_targets(
    control: Reach, arm: Arm, held: Collection[str], before: Mapping[str, float], origin: Origin
) -> dict[str, list[DriveTarget]]:
    """Return the targets of every joint between the world and a link, by joint.

    Args:
        control: What is to be reached.
        arm: What is to reach it.
        held: Joints whose actuators have a stiffness.
        before: Where earlier position targets leave joints [rad or m].
        origin: The control.

    Raises:
        ReachError: if a target is out of reach, or a joint has no motor that holds positions.
    """
    idle = next((joint for joint in arm.joints if joint not in held), None)
    if idle is not None:
        message = f"`{arm.copy.body}.{idle}` moves `{arm.link}`, and has no actuator with a stiffness to hold it"
        raise ReachError(message, "body")
    q = np.array([before.get(joint, start) for joint, start in zip(arm.joints, arm.start, strict=True)])
    outside = (q < arm.low) | (q > arm.high)
    q[outside] = (arm.low[outside] + arm.high[outside]) / 2
    turns = control.turns
    found: dict[str, list[DriveTarget]] = {joint: [] for joint in arm.joints}
    since = control.start
    for k, (t, at) in enumerate(zip(control.times, control.positions, strict=True)):
        quat = None if turns is None else quat_from_euler_deg(turns[k])
        q, off, askew = arm.solve(Goal(at, control.point, quat), q)
        if off > POSITION_TOLERANCE or askew > ROTATION_TOLERANCE:
            nearest = f"the nearest it comes is {off:.3g} m off"
            nearest += f" and {math.degrees(askew):.3g} deg askew" if quat is not None else ""
            raise ReachError(f"`{arm.copy.body}.{arm.link}` cannot get there: {nearest}", "positions", k)
        for joint, value in zip(arm.joints, q.tolist(), strict=True):
            ramp = Ramp(kind="ramp", to=value, start=since, end=t, ease=control.ease)
            found[joint].append(DriveTarget(since, "position", ramp, *origin))
        since = t
    return found
