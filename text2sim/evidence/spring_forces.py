"""Forces of springs between bodies, and their work, from the recorded states."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from text2sim.evidence.recorded_case import RecordedCase
from text2sim.recording.states import Array
from text2sim.recording.vectors import rotate


@dataclass(frozen=True)
class _Spring:
    """A spring between points of two links."""

    control: str
    links: tuple[int, int]
    """Indices of the links of its ends."""
    points: Array
    """Its ends in their frames [m], shape (2, 3)."""
    stiffness: float
    """[N/m]"""
    damping: float
    """[N s/m]"""
    length: float | None
    """Length without load [m]; None for the distance of its ends as it begins."""
    pulls_only: bool
    start: float
    """[s]"""
    end: float

    def ends(self, pos: Array, quat: Array) -> Array:
        """Return where its ends are [m], shape (..., 2, 3).

        Args:
            pos: Positions of all links [m], shape (..., L, 3).
            quat: Their orientations (w, x, y, z), shape (..., L, 4).
        """
        links = list(self.links)
        return pos[..., links, :] + rotate(quat[..., links, :].astype(float), self.points)


@dataclass(frozen=True)
class _Motion:
    """A spring over the frames of a recording."""

    stretch: Array
    """Distance of its ends less its length [m], shape (F,); 0 of a slack cord."""
    growth: Array
    """Rate of that distance [m/s], shape (F,); likewise."""
    acting: Array
    """Whether it acts, shape (F,)."""
    along: Array
    """Unit vector from its first end to the second, shape (F, 3)."""
    velocity: Array
    """Velocities of its ends [m/s], shape (F, 2, 3)."""

    def pull(self, spring: _Spring) -> Array:
        """Return `k (d - length) + c d'` [N], shape (F,); a cord does not push."""
        pull = spring.stiffness * self.stretch + spring.damping * self.growth
        return np.where(self.acting, np.maximum(pull, 0.0) if spring.pulls_only else pull, 0.0)


def spring_force(recording: RecordedCase, control: str) -> Array:
    """Return the pull [N] of the springs of a control at each frame, shape (F,): negative while they push."""
    found = [spring for spring in _springs_in(recording.states.layout) if spring.control == control]
    return np.sum([_motion(recording, spring).pull(spring) for spring in found], axis=0)


def work_of_springs(recording: RecordedCase) -> dict[str, float]:
    """Return the work [J] of springs on loose bodies, by control.

    It is the loss of `k (d - length)^2 / 2` less the integral of `c d'^2`, by the trapezoidal rule between frames, and
    less the work on an end that is driven. (The integral of force times velocity would be wrong to first order in the
    step: the engine's positions and velocities are half a step apart.)
    """
    states, found = recording.states, {}
    loose = {target.copy for target in recording.names.loose}
    for spring in _springs_in(states.layout):
        motion = _motion(recording, spring)
        frames = np.flatnonzero(motion.acting)
        if len(frames) < 2:
            continue
        stored = 0.5 * spring.stiffness * motion.stretch[frames] ** 2
        lost = np.where(motion.pull(spring) != 0.0, spring.damping * motion.growth**2, 0.0)
        work = stored[0] - stored[-1] - np.trapezoid(lost[frames], states.time[frames])
        for end, sign in ((0, 1.0), (1, -1.0)):
            if states.links[spring.links[end]].body not in loose:
                power = sign * motion.pull(spring) * (motion.velocity[:, end] * motion.along).sum(axis=1)
                work -= np.trapezoid(power[frames], states.time[frames])
        found[spring.control] = found.get(spring.control, 0.0) + float(work)
    return found


def _motion(recording: RecordedCase, spring: _Spring) -> _Motion:
    states, links = recording.states, np.array(spring.links)
    ends = spring.ends(states.pos.astype(float), states.quat)
    arms = ends - recording.centers(links)
    velocity = states.vel[:, links].astype(float) + np.cross(states.ang[:, links].astype(float), arms)
    between = ends[:, 1] - ends[:, 0]
    distance = np.linalg.norm(between, axis=1)
    along = between / np.maximum(distance, 1e-9)[:, None]
    length = np.interp(spring.start, states.time, distance) if spring.length is None else spring.length
    stretch, growth = distance - length, ((velocity[:, 1] - velocity[:, 0]) * along).sum(axis=1)
    if spring.pulls_only:
        stretch, growth = np.maximum(stretch, 0.0), np.where(stretch > 0.0, growth, 0.0)
    acting = (states.time >= spring.start) & (states.time < spring.end)
    for link in links:
        acting &= ~recording.gone(states.links[link].body)
    return _Motion(stretch, growth, acting, along, velocity)


def _springs_in(layout: dict[str, Any]) -> list[_Spring]:
    """Return the springs of a run, from the layout of its recording, in the order of the case."""
    return [
        _Spring(
            str(row["control"]), (int(row["links"][0]), int(row["links"][1])), np.array(row["points"], dtype=float),
            float(row["stiffness"]), float(row["damping"]), None if row["length"] is None else float(row["length"]),
            bool(row["pulls_only"]), float(row["start"]), float(row["end"]),
        )
        for row in layout.get("springs", ())
    ]  # fmt: skip
