"""Finds a place for a camera that has none, where moving bodies are visible, stand out and fill the picture."""

import math
from typing import Any

import numpy as np

if __package__:
    from .cameras import View, framed, project  # noqa: TID252
    from .viewpoints import place  # noqa: TID252
else:  # in a program, where it lies beside this module
    from cameras import View, framed, project
    from viewpoints import place

FRAMING_MOMENTS = 20
"""Number of moments of the recording at which the framing is checked."""
OCCLUSION_MOMENTS = 5
"""Number of moments at which occlusion is checked."""
MANY_BODIES, TYPICAL_SHARE, STRAY = 20, 0.9, 1.25
"""With this many bodies or more, the picture may cut off what is farther from their middle than `STRAY` times the
distance within which this share of them is: one shard that flies off must not make all others small."""
AZIMUTHS = (-61, -119, -75, -105, -90, -30, -150, 0, 180, 119, 61, 90)
ELEVATIONS = {13: 0.0, 19: 0.01, 8: 0.05, 27: 0.05, 42: 0.14}
"""Candidate directions to the camera [deg]: azimuths from +x, the most usual first, and elevations above the horizon
with the score that each costs."""
ELEVATIONS_ALOFT, ALOFT = {-5: 0.0, 3: 0.02, 8: 0.06, 13: 0.1}, 0.3
"""Elevations out of doors for bodies that stay at least `ALOFT` times their vertical extent above the ground: flags,
kites and laundry are seen against the sky."""
LEAST_HEIGHT = 0.08
"""Least height of such a camera above the ground, as a fraction of its distance."""
UNUSUAL_COST, BEHIND_COST = 0.006, 0.06
"""Score that each step down the list of azimuths costs, and that a view from behind costs: scenes face -y."""
HIDDEN_WEIGHT, FILLED_WEIGHT, MOTION_WEIGHT, BROAD_SIDE_WEIGHT, CONTRAST_WEIGHT = 1.0, 0.5, 0.3, 0.25, 0.35
"""Weights of a camera's score: hidden bodies, the share of the picture that bodies fill, motion across the picture,
broad sides of bodies, and contrast with the background."""
MAX_USEFUL_CONTRAST = 0.25
"""Colour distance above which contrast does not increase the score further."""
SURROUNDINGS, BENEATH = 0.3, 0.15
"""How much of statics is shown beside and above what moves, and below it, in sizes of what moves."""
SLACK = 0.02
"""How far beyond the points that are shown at the sampled moments others are shown too, in sizes of all of them."""
POINTS_PER_BODY = 3
"""Points of a body from which occlusion is checked."""
MAX_SIGHT_TESTS = 1_500_000
"""Largest number of tests of a line of sight against a box, for all cameras together."""


def best_camera(film: dict, camera: dict, states: Any, times: np.ndarray, tracks: np.ndarray) -> dict:
    """Return the still camera with the best score that shows the whole film; its frame is `within` what it shows.

    Args:
        film: Constants of `render.py`.
        camera: Camera that was derived before the simulation; its direction is one of the candidates.
        states: Recorded states, see `playback.States`.
        times: Moments [s], shape (T,).
        tracks: Points of all moving bodies at these moments [m], shape (T, n, 3).
    """
    auto, frame = film["auto"], camera["frame"]
    aspect = film["resolution"][0] / film["resolution"][1]
    moments = _moments(times, tracks)
    clouds = [states.bounds(auto["moving"], float(t)) for t in moments]
    clouds = [within(cloud[np.isfinite(cloud).all(axis=1)], frame["within"]) for cloud in clouds]
    standing = states.bounds(auto["statics"], float(moments[0])) if auto["statics"] else np.zeros((0, 3))
    every = np.concatenate(clouds)
    bodies = len(states.boxes(auto["moving"]).names)
    clouds[1:] = [typical(cloud, bodies) for cloud in clouds[1:]]
    clouds[0] = np.concatenate(
        [clouds[0], within(states.spring_ends(float(moments[0])).reshape(-1, 3), frame["within"])]
    )
    shown = np.concatenate(clouds)
    points = np.concatenate([shown, _clipped_to_surroundings(standing, shown)])
    if not len(points):
        return camera
    room = SLACK * np.ptp(points, axis=0).max()
    frame = frame | {"within": (points.min(axis=0) - room, points.max(axis=0) + room)}
    sights = _Sights(film, states, moments)
    displacements = np.diff(tracks[:: max(1, len(tracks) // FRAMING_MOMENTS)], axis=0).reshape(-1, 3)
    best, best_score = camera | {"frame": frame}, -math.inf
    ground = _ground_below(film, every, states, float(moments[0]))
    elevations = ELEVATIONS if ground is None else ELEVATIONS_ALOFT
    for direction, cost in _directions(frame["direction"], elevations, free=auto["turn_lights"]):
        tried = framed(camera | {"frame": frame | {"direction": direction}}, points, aspect)
        if ground is not None and tried["pos"][2] - ground < LEAST_HEIGHT * math.dist(tried["pos"], tried["look_at"]):
            continue
        view, toward = view_of(tried), np.asarray(direction) / np.linalg.norm(direction)
        filled = float(np.mean([_filled_share(view, cloud, aspect) for cloud in clouds if len(cloud)]))
        hidden, contrast = sights.visibility(toward, float(np.linalg.norm(view.pos - view.look_at)))
        total = (
            FILLED_WEIGHT * filled
            - HIDDEN_WEIGHT * hidden
            + CONTRAST_WEIGHT * contrast
            + MOTION_WEIGHT * _motion_across(displacements, view)
        )
        total += BROAD_SIDE_WEIGHT * sights.broad(toward) - cost
        if total > best_score:
            best, best_score = tried, total
    return best


def _moments(times: np.ndarray, tracks: np.ndarray) -> np.ndarray:
    """Return times [s], including the first and last: half their density is uniform, half is proportional to motion."""
    moved = np.linalg.norm(np.diff(tracks, axis=0), axis=2).mean(axis=1)
    even = np.full(len(moved), 1 / len(moved))
    share = even if moved.sum() < 1e-12 else (even + moved / moved.sum()) / 2
    return np.interp(np.linspace(0, 1, FRAMING_MOMENTS), np.append(0.0, np.cumsum(share)), times)


def _ground_below(film: dict, moving: np.ndarray, states: Any, t: float) -> float | None:
    """Height of the ground [m] if what moves (n, 3) stays well above it, out of doors and on nothing; else None."""
    backdrop = film.get("backdrop", {})
    level = backdrop.get("level")
    if level is None or "skyline" not in backdrop or not len(moving):
        return None
    low, high = moving.min(axis=0), moving.max(axis=0)
    tall = float(high[2] - low[2])
    for name in film["auto"]["standing"]:
        points = states.bounds([name], t)
        under = len(points) and abs(points[:, 2].max() - low[2]) <= ALOFT * tall
        if under and ((points.min(axis=0) < (low + high) / 2) & ((low + high) / 2 < points.max(axis=0)))[:2].all():
            return None  # a table, a bridge
    return level if low[2] - level > ALOFT * tall else None


def _directions(
    derived: Any, elevations: dict[int, float], *, free: bool
) -> list[tuple[tuple[float, float, float], float]]:
    """Directions to the camera, and the score that each costs: the derived one, and if `free` all candidates."""
    x, y, z = (float(c) for c in derived)
    derived_elevation = math.degrees(math.atan2(z, math.hypot(x, y)))
    angles = sorted(elevations)
    directions = [((x, y, z), float(np.interp(derived_elevation, angles, [elevations[angle] for angle in angles])))]
    for elevation, cost in elevations.items():
        for k, azimuth in enumerate(AZIMUTHS):
            up, turn = math.radians(elevation), math.radians(azimuth)
            direction = (math.cos(up) * math.cos(turn), math.cos(up) * math.sin(turn), math.sin(up))
            directions.append((direction, cost + UNUSUAL_COST * k + BEHIND_COST * (direction[1] > 0.1)))
    return directions if free else directions[:1]


class _Sights:
    """Occlusion and contrast of moving bodies, computed with a box for each body.

    Args:
        film: Constants of `render.py`.
        states: Recorded states, see `playback.States`.
        moments: Sampled times [s].
    """

    def __init__(self, film: dict, states: Any, moments: np.ndarray):
        auto = film["auto"]
        every = states.boxes([*auto["moving"], *auto["standing"]])
        names = [name.split("[")[0] for name in every.names]
        self._bodies = {name: k for k, name in enumerate(dict.fromkeys(names))}
        self._body = np.array([self._bodies[name] for name in names], int)
        self._color, self._solid = every.color, every.solid & ~np.isin(names, auto["clear"])
        moves = np.flatnonzero(np.isin(names, auto["moving"]))
        directions = len(AZIMUTHS) * len(ELEVATIONS)
        tests = OCCLUSION_MOMENTS * POINTS_PER_BODY * directions * max(len(names), 1) * max(len(moves), 1)
        some = moves[:: max(1, math.ceil(tests / MAX_SIGHT_TESTS))]
        _, one_of_each = np.unique(self._body[moves], return_index=True)
        self._sampled = np.union1d(some, moves[one_of_each])
        chosen = moments[np.unique(np.linspace(0, len(moments) - 1, OCCLUSION_MOMENTS).round().astype(int))]
        self._placed = [states.placed(every, float(t)) for t in chosen]
        self._background = np.asarray(film["background"], float)

    def visibility(self, direction: np.ndarray, distance: float) -> tuple[float, float]:
        """Return the hidden share of moving bodies as seen by a camera, and their contrast, each 0 to 1.

        Args:
            direction: Unit vector towards the camera.
            distance: Distance of the camera [m].
        """
        sampled, hidden, contrasts = self._sampled, [], []
        if not len(sampled):
            return 0.0, 1.0
        same = self._body[sampled][:, None] == self._body[None]
        for centers, axes, half in self._placed:
            for spot in np.linspace(-0.7, 0.7, POINTS_PER_BODY):
                points = centers[sampled] + spot * np.einsum("nij,nj->ni", axes[sampled], half[sampled])
                ahead = np.where(same | ~self._solid, np.inf, _entry_distances(points, direction, centers, axes, half))
                hidden.append((ahead < distance).any(axis=1))
                behind = np.where(same, np.inf, _entry_distances(points, -direction, centers, axes, half))
                k = behind.argmin(axis=1)
                nothing = np.isinf(behind[np.arange(len(k)), k])
                colors = np.where(nothing[:, None], self._background, self._color[k])
                far = np.linalg.norm(colors - self._color[sampled], axis=1) / math.sqrt(3)
                contrasts.append(np.clip(far / MAX_USEFUL_CONTRAST, 0, 1))
        return self._mean(np.mean(hidden, axis=0)), self._mean(np.mean(contrasts, axis=0))

    def broad(self, direction: np.ndarray) -> float:
        """Return how much of their broad sides the bodies show, 0 to 1; `direction` points to the camera."""
        _, axes, half = (array[self._sampled] for array in self._placed[0])
        faces = np.stack([half[:, 1] * half[:, 2], half[:, 0] * half[:, 2], half[:, 0] * half[:, 1]], axis=1)
        seen = (np.abs(np.einsum("nij,i->nj", axes, direction)) * faces).sum(axis=1)
        return self._mean(seen / np.maximum(np.linalg.norm(faces, axis=1), 1e-12)) if len(seen) else 1.0

    def _mean(self, values: np.ndarray) -> float:
        """Mean over bodies, with the copies of each averaged first: one ball counts as much as a wall of bricks."""
        bodies = self._body[self._sampled]
        counts = np.bincount(bodies)
        sums = np.bincount(bodies, values)
        return float((sums[counts > 0] / counts[counts > 0]).mean())


def _entry_distances(
    points: np.ndarray, direction: np.ndarray, centers: np.ndarray, axes: np.ndarray, half: np.ndarray
) -> np.ndarray:
    """Return the distance [m] at which rays from points enter boxes, inf if they miss, shape (points, boxes)."""
    local = np.einsum("pbi,bij->pbj", points[:, None] - centers[None], axes)
    along = np.einsum("i,bij->bj", direction, axes)
    along = np.where(np.abs(along) < 1e-9, 1e-9, along)
    a, b = (-half - local) / along, (half - local) / along
    first, last = np.minimum(a, b).max(axis=2), np.maximum(a, b).min(axis=2)
    return np.where((last > np.maximum(first, 0.0)) & (first > 1e-4), first, np.inf)


def _motion_across(displacements: np.ndarray, view: View) -> float:
    """Share of all motion that goes across the picture, 0 to 1."""
    ahead = (view.look_at - view.pos) / np.linalg.norm(view.look_at - view.pos)
    whole = np.linalg.norm(displacements, axis=1).sum()
    across = np.linalg.norm(displacements - np.outer(displacements @ ahead, ahead), axis=1).sum()
    return float(across / whole) if whole > 1e-9 else 1.0


def _filled_share(view: View, cloud: np.ndarray, aspect: float) -> float:
    """Size of the subjects: square root of the share of the picture that a box around most of them fills."""
    places = np.clip(project(view, cloud, aspect)[:, :2], -1, 1)
    wide, tall = np.diff(np.percentile(places, (4, 96), axis=0), axis=0)[0] / 2
    return float(math.sqrt(max(wide * tall, 0.0)))


def within(cloud: np.ndarray, space: Any) -> np.ndarray:
    """Return the points (n, 3) within a box, given by its lowest and highest corner [m].

    Returns all points if the box is None or contains none.
    """
    if space is None or not len(cloud):
        return cloud
    low, high = (np.asarray(corner, float) for corner in space)
    near = cloud[((cloud >= low) & (cloud <= high)).all(axis=1)]
    return near if len(near) else cloud


def _clipped_to_surroundings(standing: np.ndarray, shown: np.ndarray) -> np.ndarray:
    """Points of statics, clamped to a box around what moves: of a large table, the part that matters is shown."""
    if not len(shown) or not len(standing):
        return standing
    low, high = shown.min(axis=0), shown.max(axis=0)
    beside, below = SURROUNDINGS * float((high - low).max()), BENEATH * float((high - low).max())
    return np.clip(standing, low - (beside, beside, below), high + beside)


def typical(points: np.ndarray, bodies: int) -> np.ndarray:
    """Return the points (n, 3) of a number of bodies at one moment; of many bodies, without the strays.

    Args:
        points: Outermost points of the bodies [m].
        bodies: How many bodies these are.
    """
    if bodies < MANY_BODIES or not len(points):
        return points
    away = np.linalg.norm(points - np.median(points, axis=0), axis=1)
    return points[away <= STRAY * np.quantile(away, TYPICAL_SHARE)]


def view_of(camera: dict) -> View:
    """Return the view of a still camera."""
    pos, look_at, up = (np.asarray(vector, float) for vector in place(camera, 0.0, 0.0, None))
    return View(pos, look_at, up, float(camera["fov"]), 1.0, 0.0)
