"""Loads of motors in mechanisms with loops, by virtual work.

A motor that moves the mechanism slowly does the work of its potential energy: its load is `-dU/dq`, where q is the
position of its joint, and all other joints follow so that the loops stay closed. They are found by Newton's method, in
small steps from the start. Joints that no loop moves stay where they are, as do those that other drives hold.
"""

from collections.abc import Collection
from dataclasses import replace
from math import ceil

from text2sim.compiler.shapes.inertials import Inertial
from text2sim.compiler.shapes.rotation import (
    ORIGIN,
    Vec,
    frame_apply,
    quat_conjugate,
    quat_rotate,
    vector_dot,
    vector_minus,
    vector_plus,
)
from text2sim.compiler.trees.tree import StandingLink, Tree, tree_links
from text2sim.lint.joints.loaded_joint import LoadedJoint

STEP = 0.05
"""Largest step from one solution to the next [rad or m]."""
SLOPE = 1e-4
"""Change of a joint for differences [rad or m]."""
CLOSED = 1e-5
"""Gap [m] up to which a loop counts as closed."""
SOLVED = 1e-10
"""Last change of a joint [rad or m] in a solution."""
MAX_ITERATIONS = 20
MAX_STEPS = 200
LEAST_PART = 1e-6
"""Smallest motion of a loop by a joint, per that of the joint that moves it most, that counts."""

_CORNERS: tuple[Vec, ...] = (ORIGIN, (0.1, 0.0, 0.0), (0.0, 0.1, 0.0), (0.0, 0.0, 0.1))
"""Points [m] that coincide in two links that are welded; of those that are connected, the first."""


class Linkage:
    """A mechanism with loops, moved by one of its joints.

    Args:
        joint: The joint with the motor.
        tree: The links.
        held: Names of joints that other drives hold.
        gravity: Gravity [m/s2].
        carried: What is welded to links from the start, by name of link, in the world at the start.
    """

    def __init__(
        self,
        joint: LoadedJoint,
        tree: Tree,
        held: Collection[str],
        gravity: Vec,
        carried: Collection[tuple[str, Inertial]] = (),
    ) -> None:
        self.joint, self.tree, self.gravity = joint, tree, gravity
        self._springs = {name: spec.spring for name, spec in tree.joints() if spec.spring}
        self._frictions = {name: spec.friction for name, spec in tree.joints() if spec.friction}
        start = {row.link.name: row for row in self._standing(tree.initial)}
        self._masses = [(link.name, link.inertial.mass, link.inertial.center) for link in tree.links()]
        for name, inertial in carried:
            self._masses.append((name, inertial.mass, _local(start[name], inertial.center)))
        # As the engine does, loops are closed where all joints are at 0.
        zero = {row.link.name: row for row in self._standing({})}
        self._ends: list[tuple[str, Vec, str | None, Vec]] = []
        self._gears = [(loop.a, loop.b, loop.ratio) for loop in tree.loops if loop.kind == "gear" and loop.b]
        for loop in tree.loops:
            if loop.kind == "gear":
                continue
            for offset in _CORNERS[: 1 if loop.kind == "connect" else None]:
                point = vector_plus(loop.anchor, offset)
                world = frame_apply(zero[loop.a].pos, zero[loop.a].quat, point)
                self._ends.append((loop.a, point, loop.b, _local(zero[loop.b], world) if loop.b else world))
        following = [name for name, spec in tree.joints() if spec.kind in ("hinge", "slider")]
        self._following = [name for name in following if name != joint.name and name not in held]
        if self._following:
            sizes = [max(map(abs, column)) for column in self._slopes(tree.initial)]
            moving = zip(self._following, sizes, strict=True)
            self._following = [name for name, size in moving if size > LEAST_PART * max(sizes)]

    def load(self, q: float) -> float | None:
        """Return the torque [N m] or force [N] of gravity and springs on the joint at a position, less dry friction.

        None if the loops cannot be closed there, or leave more than one joint free.
        """
        here = self._positions(q)
        if here is None:
            return None
        high, low = (self._close({**here, self.joint.name: q + change}) for change in (SLOPE, -SLOPE))
        if high is None or low is None:
            return None
        load = (self._potential(low) - self._potential(high)) / (2 * SLOPE)
        friction = sum(
            size * abs(high.get(name, 0.0) - low.get(name, 0.0)) / (2 * SLOPE)
            for name, size in self._frictions.items()
            if name != self.joint.name
        )
        return max(0.0, abs(load) - friction) * (1.0 if load >= 0.0 else -1.0)

    def _positions(self, q: float) -> dict[str, float] | None:
        """Return the positions of all joints where the one with the motor is at q; None if that cannot be reached."""
        start = self.joint.start
        count = max(1, ceil(abs(q - start) / STEP))
        found = self._close({**self.tree.initial, self.joint.name: start}) if count <= MAX_STEPS else None
        for k in range(1, count + 1):
            if found is None:
                break
            found = self._close({**found, self.joint.name: start + (q - start) * k / count})
        return found

    def _close(self, positions: dict[str, float]) -> dict[str, float] | None:
        """Return positions that close the loops, near others; None if there are none, or if they are not unique."""
        import numpy as np  # arrays, which few cases need

        for _ in range(MAX_ITERATIONS):
            gap = np.array(self._gaps(positions))
            change = np.zeros(0)
            if self._following:
                slopes = np.array(self._slopes(positions)).T
                change, _, rank, _ = np.linalg.lstsq(slopes, -gap, rcond=1e-6)
                if rank < len(self._following):
                    return None
            if float(np.abs(change).max(initial=0.0)) < SOLVED:
                return positions if float(np.abs(gap).max()) < CLOSED else None
            moved = zip(self._following, change.tolist(), strict=True)
            positions = {**positions, **{name: positions.get(name, 0.0) + by for name, by in moved}}
        return None

    def _slopes(self, positions: dict[str, float]) -> list[list[float]]:
        """Return how the gaps of the loops grow with each joint that follows, by joint."""
        columns = []
        for name in self._following:
            at = positions.get(name, 0.0)
            high, low = (self._gaps({**positions, name: at + change}) for change in (SLOPE, -SLOPE))
            columns.append([(a - b) / (2 * SLOPE) for a, b in zip(high, low, strict=True)])
        return columns

    def _gaps(self, positions: dict[str, float]) -> list[float]:
        """Return the gaps of the loops [m], three for each point that should coincide, and of gears [rad or m]."""
        at = {row.link.name: row for row in self._standing(positions)}
        gaps = [positions.get(a, 0.0) - ratio * positions.get(b, 0.0) for a, b, ratio in self._gears]
        for a, point, b, other in self._ends:
            here = frame_apply(at[a].pos, at[a].quat, point)
            there = other if b is None else frame_apply(at[b].pos, at[b].quat, other)
            gaps += vector_minus(here, there)
        return gaps

    def _potential(self, positions: dict[str, float]) -> float:
        """Return the potential energy [J]: of weight, and of springs, which are at rest at 0."""
        at = {row.link.name: row for row in self._standing(positions)}
        weight = sum(
            mass * vector_dot(self.gravity, frame_apply(at[name].pos, at[name].quat, center))
            for name, mass, center in self._masses
        )
        return sum(k * positions.get(name, 0.0) ** 2 / 2 for name, k in self._springs.items()) - weight

    def _standing(self, positions: dict[str, float]) -> list[StandingLink]:
        copy = self.joint.copy
        return tree_links(replace(self.tree, initial=positions), copy.pos, copy.quat)


def _local(frame: StandingLink, point: Vec) -> Vec:
    return quat_rotate(quat_conjugate(frame.quat), vector_minus(point, frame.pos))
