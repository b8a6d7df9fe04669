"""Candidate cameras for a run, and their scores."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from text2sim.legibility.recorded import Recorded, raster_view
from text2sim.legibility.sight import Things, look
from text2sim.recording.film_record import FilmRecord
from text2sim.templates.cameras import View, framed
from text2sim.templates.viewpoints import place

Array = NDArray[Any]

AZIMUTHS = (-61, -119, -90, -75, -105, -30, -150, 0, 180, 61, 119, 90)
"""Azimuths [deg] of candidate cameras, from +x. The most usual come first: from the front, or its right."""
HEIGHTS = {24: 0.0, 40: 0.015, 12: 0.02, 62: 0.14}
"""Penalties by elevation [deg]: from high above, bodies do not seem to stand."""
LENSES = (42.0, 28.0, 70.0)
"""Focal lengths [mm], the most usual first."""
SIZE = (96, 54)
"""Size of the pictures in which candidates are compared [pixels]."""
COARSE, GRAINS = 16_000, 800
"""Largest numbers of triangles and particles for comparing candidates."""
ENOUGH = 0.06
"""Share of the picture above which a larger body does not score higher."""
APART = 0.12
"""Contrast above which a body does not score higher."""
BESIDE = 0.25
"""Weight of bodies that are not subjects of the script; that of subjects is 1."""
WORST = 0.35
"""Weight of the worst moment; the rest is that of the mean over all."""
LATERAL = 0.12
"""Bonus of a camera that sees all motion in the image plane, over one that sees it along the line of sight."""
TRIED_WITH_LENSES = 4
"""Number of candidates that are tried with other lenses."""
HABIT = 0.004
"""Penalty per step down the other lists above."""
FRAMED_AT = 40
"""Number of moments at which the bodies to be framed are sampled."""


@dataclass(frozen=True)
class Candidate:
    """A static camera and what it frames."""

    frame: tuple[str, ...]
    """Bodies and statics that it shows."""
    direction: tuple[float, float, float]
    """Direction from them to the camera."""
    lens: float
    """Focal length [mm]."""
    habit: float
    """Penalty for being unusual."""


class Scorer:
    """Scores cameras for a recorded run.

    Args:
        recording: The recording of the run.
        subjects: Subjects of the script; empty for all bodies.
        times: Sampled times [s].
        within: Lowest and highest corner [m] of the box in which bodies are followed; None for no limit.
    """

    def __init__(self, recording: FilmRecord, subjects: Sequence[str], times: Sequence[float], within: Any = None):
        self.recording, self.within = recording, within
        self.recorded = Recorded(recording, COARSE, GRAINS)
        names, statics = self.recorded.names, self.recorded.statics
        moving = [name for name in names if name not in statics]
        wanted = [name for name in subjects if name in moving] or moving
        self.weights = np.array([(1.0 if n in wanted else BESIDE) * (n in moving) for n in names])
        wide, tall = recording.film["resolution"]
        self._aspect = wide / tall
        self._size = (SIZE[0], max(2, round(SIZE[0] * tall / wide)))
        self._things = [self.recorded.things(t) for t in times]
        self._ways = self._motion()

    def camera(self, candidate: Candidate) -> dict[str, Any]:
        """Return the resolved camera of a candidate; see `templates/cameras.py`."""
        fov = 2 * math.degrees(math.atan(12.0 / candidate.lens))
        frame = {
            "bodies": list(candidate.frame),
            "margin": 0.08,
            "within": self.within,
            "direction": candidate.direction,
        }
        camera = {"kind": "still", "up": (0.0, 0.0, 1.0), "fov": fov, "frame": frame}
        return framed(camera, self._shown(candidate.frame), self._aspect)

    def score(self, candidate: Candidate) -> float:
        """Return the score of a candidate, about 0 to 1."""
        camera = self.camera(candidate)
        pos, look_at, up = (np.asarray(vector, float) for vector in place(camera, 0.0, 0.0, None))
        view = View(pos, look_at, up, camera["fov"], 1.0, 0.0)
        return self.judge([view] * len(self._things), look_at - pos) - candidate.habit

    def judge(self, views: Sequence[View], ahead: Array) -> float:
        """Return the score of a camera with the given view at each sampled time."""
        scores = [self._moment(things, view) for things, view in zip(self._things, views, strict=True)]
        return (1 - WORST) * float(np.mean(scores)) + WORST * min(scores) + LATERAL * self._across(ahead)

    def _moment(self, things: Things, view: View) -> float:
        """Return the weighted visibility of all bodies at one moment, 0 to 1."""
        sight = look(things, raster_view(view, self._size))
        colors = np.concatenate([self.recorded.colors, [self.recording.film["background"]]])
        picture = colors[sight.front].reshape(sight.view.height, sight.view.width, 3)
        total = 0.0
        for k, measures in enumerate(sight.measures(picture)):
            if self.weights[k]:
                large = min(1.0, measures.share / ENOUGH) ** 0.4
                stands_out = 1.0 if measures.contrast is None else min(1.0, measures.contrast / APART)
                free = 1 - (measures.hidden or 0.0)
                total += self.weights[k] * measures.inside * free * large * (0.7 + 0.3 * stands_out)
        return total / max(float(self.weights.sum()), 1e-9)

    def _motion(self) -> Array:
        """Return the weighted displacements [m] of the centres of all bodies between sampled times, shape (n, 3)."""
        count = len(self.recorded.names)
        middles = []
        for things in self._things:
            corners, owner = things.triangles[:, 0], things.owner
            sums = np.stack([np.bincount(owner, corners[:, i], count) for i in range(3)], axis=1)
            number = np.bincount(owner, minlength=count)
            middles.append(sums / np.where(number > 0, number, np.nan)[:, None])  # nan where it is absent
        return (np.nan_to_num(np.diff(np.array(middles), axis=0)) * self.weights[:, None]).reshape(-1, 3)

    def _across(self, ahead: Array) -> float:
        """Return the fraction of all motion that is parallel to the image plane, 0 to 1."""
        ahead = ahead / np.linalg.norm(ahead)
        across = self._ways - np.outer(self._ways @ ahead, ahead)
        whole = np.linalg.norm(self._ways, axis=1).sum()
        return float(np.linalg.norm(across, axis=1).sum() / whole) if whole > 1e-9 else 1.0

    def strays(self, bodies: tuple[str, ...]) -> bool:
        """Return whether some of these bodies leave the box in which they are followed."""
        if self.within is None:
            return False
        low, high = self.within
        points = self._outermost(bodies)
        return bool(((points < low) | (points > high)).any())

    def _shown(self, bodies: tuple[str, ...]) -> Array:
        """Return the points that a camera must show [m], shape (n, 3)."""
        points = self._outermost(bodies)
        if self.within is None:
            return points
        low, high = self.within
        near = points[((points >= low) & (points <= high)).all(axis=1)]
        return near if len(near) else points

    def _outermost(self, bodies: tuple[str, ...]) -> Array:
        """Return the extreme points of bodies over the film [m], shape (n, 3)."""
        return np.concatenate([self._points[name] for name in bodies])

    @cached_property
    def _points(self) -> dict[str, Array]:
        """Extreme points of each body over the film [m], read in one pass because chunks of soft bodies are large."""
        states, film = self.recording.states, self.recording.film
        found: dict[str, list[Array]] = {name: [] for name in self.recorded.names}
        for t in np.linspace(film["start"], min(film["end"], self.recording.last), FRAMED_AT):
            for name, clouds in found.items():
                points = np.asarray(states.bounds([name], float(t)), float)
                clouds.append(points[np.isfinite(points).all(axis=1)])
        return {name: np.concatenate(clouds) for name, clouds in found.items()}


def directions() -> list[tuple[tuple[float, float, float], float]]:
    """Return the directions of candidate cameras, each with a penalty for unusual ones."""
    found = []
    for height, loss in HEIGHTS.items():
        for k, azimuth in enumerate(AZIMUTHS):
            up, round_ = math.radians(height), math.radians(azimuth)
            direction = (math.cos(up) * math.cos(round_), math.cos(up) * math.sin(round_), math.sin(up))
            found.append(((round(direction[0], 3), round(direction[1], 3), round(direction[2], 3)), loss + HABIT * k))
    return found


def best(scorer: Scorer, frames: Sequence[tuple[str, ...]]) -> list[tuple[float, Candidate]]:
    """Return the best cameras with their scores, best first: a search over directions and frames, then over lenses.

    Args:
        scorer: Scorer of the run.
        frames: Sets of bodies that a camera may frame, the most usual first.
    """
    first = [
        Candidate(frame, direction, LENSES[0], habit + HABIT * n)
        for n, frame in enumerate(frames)
        for direction, habit in directions()
    ]
    ranked = sorted(((scorer.score(one), one) for one in first), key=lambda row: -row[0])
    lenses = [
        Candidate(one.frame, one.direction, lens, one.habit + 2 * HABIT * n)
        for _, one in ranked[:TRIED_WITH_LENSES]
        for n, lens in enumerate(LENSES)
        if n
    ]
    return sorted([*ranked, *((scorer.score(one), one) for one in lenses)], key=lambda row: -row[0])
