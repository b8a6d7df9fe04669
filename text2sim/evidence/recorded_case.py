"""Recording of a run together with its case."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np

from text2sim.evidence.contacts import ContactLog
from text2sim.evidence.gaps import Cloud
from text2sim.evidence.rigid_shapes import RigidShapes
from text2sim.evidence.selection import RecordedNames, RecordedTarget
from text2sim.recording.deformables import RecordedDeformable
from text2sim.recording.geometry import Geometry, depth_inside
from text2sim.recording.states import Array, RunStates
from text2sim.recording.vectors import rotate, rotate_back
from text2sim.spec_schema.models.case import Case
from text2sim.spec_schema.models.soft_bodies import Cloth
from text2sim.spec_schema.models.space import Region
from text2sim.spec_schema.names.selectors import body_of

MAX_CACHED_POINTS = 400_000_000
"""Most bytes of points that are cached for distances."""


@dataclass(frozen=True)
class RecordedCase:
    """A recording and its case: the input of measures and events."""

    states: RunStates
    names: RecordedNames
    geometry: Geometry
    contacts: ContactLog
    case: Case
    shapes: RigidShapes
    _clouds: dict[int, Cloud] = field(default_factory=dict, repr=False)

    @classmethod
    def load(cls, run_dir: Path, case: Case) -> "RecordedCase":
        """Open the recording of a run."""
        states = RunStates.load(run_dir)
        names = RecordedNames(states, case)
        shapes = RigidShapes(run_dir, states, case)
        return cls(states, names, Geometry.load(run_dir), ContactLog.of(names), case, shapes)

    @cached_property
    def masses(self) -> Array:
        """Masses of the links [kg], shape (L,)."""
        return np.array([link.mass for link in self.states.links])

    @cached_property
    def inertias(self) -> Array:
        """Inertia tensors about the centre of mass [kg m2], in the link's frame, shape (L, 3, 3)."""
        return np.array([link.inertia for link in self.states.links]).reshape(-1, 3, 3)

    def centers(self, links: Array) -> Array:
        """Return the centres of mass of links [m], world, shape (F, n, 3)."""
        local = np.array([self.states.links[i].com for i in links]).reshape(-1, 3)
        return self.states.pos[:, links] + rotate(self.states.quat[:, links].astype(float), local)

    def gone(self, copy: str) -> Array:
        """Return whether a copy has left the scene, shape (F,)."""
        return self.states.gone(copy)

    def there(self, links: Array) -> Array:
        """Return 1 where a link is in the scene and 0 where its body has left it, shape (F, n)."""
        rows = [~self.gone(self.states.links[i].body) for i in links]
        return np.array(rows, float).reshape(len(links), self.states.frames).T

    def _unless_gone(self, target: RecordedTarget, values: Array) -> Array:
        if target.copy in self.states.removed:
            values[self.gone(target.copy)] = np.nan
        return values

    def kinetic(self, links: Array) -> Array:
        """Return the kinetic energy of links [J], shape (F, n): 1/2 m v.v + 1/2 w.I w.

        v is the velocity of the centre of mass, w the angular velocity. w.I w has the same value in every
        frame, so w is turned into the link's, where I is constant. Rotors (armature) are not counted.
        """
        v = self.states.vel[:, links].astype(float)
        w = rotate_back(self.states.quat[:, links].astype(float), self.states.ang[:, links].astype(float))
        spin = np.einsum("fni,nij,fnj->fn", w, self.inertias[links], w)
        return 0.5 * self.masses[links] * (v * v).sum(axis=-1) + 0.5 * spin

    def potential(self, links: Array) -> Array:
        """Return the potential energy of links [J], shape (F, n): -m g.x, x the centre of mass; zero at the origin."""
        return -self.masses[links] * (self.centers(links) @ np.array(self.states.gravity))

    def deformable(self, target: RecordedTarget) -> RecordedDeformable | None:
        """Return the body of a target if it is deformable, else None."""
        return None if target.soft is None else self.states.deformables[target.soft]

    def thickness(self, body: RecordedDeformable) -> float:
        """Return the distance [m] below which parts of a cloth overlap."""
        model = self.case.bodies.get(body_of(body.body))
        if body.solver == "pbd" or not isinstance(model, Cloth):
            return body.spacing
        return model.material.thickness

    def cloud(self, body: RecordedDeformable) -> Cloud:
        """Return the sample points of a body, for distances; the last few are cached."""
        if body.index not in self._clouds:
            self._clouds[body.index] = Cloud.of(body)
            while (
                len(self._clouds) > 2
                and sum(cloud.points.nbytes for cloud in self._clouds.values()) > MAX_CACHED_POINTS
            ):
                del self._clouds[next(iter(self._clouds))]
        return self._clouds[body.index]

    def energies(self, targets: Sequence[RecordedTarget]) -> tuple[Array, Array]:
        """Return the kinetic and potential energy [J] of targets together, both (F,), each body counted once.

        For a deformable body, the kinetic energy is that of its points, and the potential energy that of its weight;
        elastic energy is not included.
        """
        links = links_of(targets)
        there = self.there(links)
        kinetic = (self.kinetic(links) * there).sum(axis=1)
        potential = (self.potential(links) * there).sum(axis=1)
        gravity = np.array(self.states.gravity)
        for number in soft_of(targets):
            body = self.states.deformables[number]
            kinetic = kinetic + self.states.soft_kinetic[:, number].astype(float)
            potential = potential - body.mass * (body.center @ gravity)
        return kinetic, potential

    def angular_momentum(self, targets: Sequence[RecordedTarget], about: tuple[float, float, float] | None) -> Array:
        """Return the sum of m (x - c) x (v - u) + S [kg m2/s] over links and deformable bodies, world, shape (F, 3).

        c is the common centre of mass and u its velocity, or c is the given point [m] and u is zero. S is the angular
        momentum about its own centre of mass: R I R^T w of a link, `soft_spin` of a deformable body.
        """
        links, soft = links_of(targets), soft_of(targets)
        there = self.there(links)
        masses, x, v = self.masses[links] * there, self.centers(links), self.states.vel[:, links].astype(float)
        if soft:
            bodies = [self.states.deformables[number] for number in soft]
            masses = np.hstack([masses, np.tile([body.mass for body in bodies], (len(masses), 1))])
            x = np.concatenate([x, np.stack([body.center for body in bodies], axis=1)], axis=1)
            v = np.concatenate([v, self.states.soft_velocity[:, soft].astype(float)], axis=1)
        if about is not None:
            x = x - np.array(about)
        elif masses.any():
            shares = (masses / np.maximum(masses.sum(axis=1, keepdims=True), 1e-300))[..., None]
            x, v = x - (shares * x).sum(axis=1, keepdims=True), v - (shares * v).sum(axis=1, keepdims=True)
        quat = self.states.quat[:, links].astype(float)
        own = np.einsum(
            "nij,fnj->fni", self.inertias[links], rotate_back(quat, self.states.ang[:, links].astype(float))
        )
        spins = (there[..., None] * rotate(quat, own)).sum(axis=1) + self.states.soft_spin[:, soft].sum(axis=1)
        return (masses[..., None] * np.cross(x, v)).sum(axis=1) + spins

    def velocity(self, target: RecordedTarget) -> Array:
        """Return the velocity of a target's centre of mass [m/s], world, shape (F, 3); nan after it left the scene."""
        if target.soft is not None:
            return self.states.soft_velocity[:, target.soft].astype(float)
        links = np.array(target.links)
        weights = self.masses[links]
        if len(links) == 1 or weights.sum() <= 0:
            return self._unless_gone(target, self.states.vel[:, target.root].astype(float))
        mean = np.einsum("fni,n->fi", self.states.vel[:, links].astype(float), weights / weights.sum())
        return self._unless_gone(target, mean)

    def fastest(self, target: RecordedTarget) -> tuple[Array, Array]:
        """Return the largest speed [m/s] and angular speed [rad/s] of a rigid target's links, shape (F,) each."""
        speeds = (
            np.linalg.norm(a[:, list(target.links)].astype(float), axis=-1).max(axis=1)
            for a in (self.states.vel, self.states.ang)
        )
        linear, angular = (self._unless_gone(target, speed) for speed in speeds)
        return linear, angular

    def origin(self, target: RecordedTarget) -> Array:
        """Return the origin of a target's frame [m], world, shape (F, 3); for a deformable body, its centre of mass.

        Nan after it has left the scene.
        """
        if target.soft is not None:
            return self.states.deformables[target.soft].center
        return self._unless_gone(target, self.states.pos[:, target.root].astype(float))

    def depth_in(self, region: Region, points: Array, frames: slice | int = slice(None)) -> Array:
        """Return depths of points inside a region [m], see `depth_inside`; a region attached to a body moves with it.

        Args:
            region: The region.
            points: One for each frame, shape (F, 3), or many at one frame, shape (n, 3).
            frames: The frame, if there is only one.
        """
        if (carrier := region.moves_with) is not None:
            (target,) = self.names.select(carrier)
            pos, quat = (rows[:, target.root].astype(float) for rows in (self.states.pos, self.states.quat))
            points = pos[0] + rotate(quat[0], rotate_back(quat[frames], points - pos[frames]))
        return depth_inside(region, points)


def links_of(targets: Sequence[RecordedTarget]) -> Array:
    """Return the indices of the links of targets, unique and sorted."""
    return np.array(sorted({link for target in targets for link in target.links}), dtype=np.int64)


def soft_of(targets: Sequence[RecordedTarget]) -> list[int]:
    """Return the indices of the deformable bodies among targets, unique and sorted."""
    return sorted({target.soft for target in targets if target.soft is not None})
