"""Springs of a recording as meshes: coils, and elastic cords that sag while they are slack."""

from typing import NamedTuple

import numpy as np

TURN, SIDES = 20, 10  # points along each turn of a wire, and around it
CORD, BISECTIONS = 48, 30  # points along a cord; halvings of the range of its sag
PITCH = 0.75  # of a coil without load, over its radius
HOOK = 0.07  # share of a coil at each end that runs straight to the point where it is fastened
SLIM, WIRE = 0.09, 0.16  # radius of a coil over its length without load, and of its wire over its own
FINE, NARROW, WIDE = 0.012, 0.002, 0.02  # radius of a cord over its length, its smallest and its largest [m]


class Strand(NamedTuple):
    """A drawn spring."""

    control: str
    form: str
    vertices: np.ndarray  # [m], shape (n, 3)
    faces: np.ndarray
    normals: np.ndarray


class Coils:
    """The springs of a recording.

    Args:
        states: The recorded states.
        looks: Form and radius [m] of the springs of each control; a radius may be None.
    """

    def __init__(self, states, looks: dict[str, dict]):
        self._states, self._rows = states, []
        for k, row in enumerate(states.layout.get("springs", ())):
            if row["control"] not in looks:
                continue
            length = row["length"]
            if length is None:
                length = float(np.linalg.norm(np.subtract(*states.spring_ends(row["start"])[k])))
            self._rows.append((k, row, looks[row["control"]], max(length, 1e-3)))

    def at(self, t: float) -> list[Strand]:
        """Return the springs that act at a time [s]."""
        found, ends = [], self._states.spring_ends(t)
        for k, row, look, length in self._rows:
            a, b = ends[k]
            if not row["start"] <= t + 1e-9 < row["end"] or not np.isfinite(ends[k]).all():
                continue
            draw = coil if look["form"] == "coil" else cord
            found.append(Strand(row["control"], look["form"], *draw(a, b, length, look["radius"])))
        return found


def coil(a, b, length: float, radius: float | None = None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return vertices, faces and normals of a coil from a to b [m].

    Args:
        a: One end, shape (3,).
        b: The other, shape (3,).
        length: Its length without load [m], on which the number of its turns depends.
        radius: Radius of the coil [m]; None for one that suits its length.
    """
    radius = SLIM * length if radius is None else radius
    turns = int(np.clip(round((1.0 - 2.0 * HOOK) * length / (PITCH * radius)), 4, 40))
    share = np.linspace(0.0, 1.0, turns * TURN + 1)
    # Straight hooks, then half a turn in which the wire swings out to its radius.
    inner = np.clip((share - HOOK) / (1.0 - 2.0 * HOOK), 0.0, 1.0)
    out = np.clip(np.minimum(inner, 1.0 - inner) * 2.0 * turns, 0.0, 1.0)
    angle = 2.0 * np.pi * turns * inner
    across, up = _across(b - a)
    spread = (radius * (1.0 - WIRE) * out**2 * (3.0 - 2.0 * out))[:, None]
    line = a + share[:, None] * (b - a) + spread * (np.cos(angle)[:, None] * across + np.sin(angle)[:, None] * up)
    return _tube(line, WIRE * radius)


def cord(a, b, length: float, radius: float | None = None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return vertices, faces and normals of a cord from a to b [m]; longer ones than their distance sag.

    A stretched cord gets thinner by the square root of its stretch, so that it keeps its volume. A slack one hangs in a
    parabola that is as long as the cord.

    Args:
        a: One end, shape (3,).
        b: The other, shape (3,).
        length: Its length without load [m].
        radius: Its radius without load [m]; None for one that suits its length.
    """
    radius = float(np.clip(FINE * length, NARROW, WIDE)) if radius is None else radius
    distance = float(np.linalg.norm(b - a))
    share = np.linspace(0.0, 1.0, CORD + 1)[:, None]
    straight, drop = a + share * (b - a), 4.0 * share * (1.0 - share) * np.array([0.0, 0.0, -1.0])
    low, high = 0.0, length if length > distance else 0.0
    for _ in range(BISECTIONS if high else 0):
        sag = (low + high) / 2.0
        arc = np.linalg.norm(np.diff(straight + sag * drop, axis=0), axis=1).sum()
        low, high = (sag, high) if arc < length else (low, sag)
    line = straight + low * drop
    return _tube(line, radius * min(1.0, np.sqrt(length / max(distance, 1e-9))))


def _across(along) -> tuple[np.ndarray, np.ndarray]:
    """Return two unit vectors that are perpendicular to each other and to another vector."""
    along = along / max(float(np.linalg.norm(along)), 1e-9)
    other = np.eye(3)[int(np.abs(along).argmin())]
    first = np.cross(along, other)
    first /= max(float(np.linalg.norm(first)), 1e-9)
    return first, np.cross(along, first)


def _tube(line: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a round tube along a line, shape (n, 3), with flat ends; its cross-section does not twist."""
    tangents = np.gradient(line, axis=0)
    tangents /= np.maximum(np.linalg.norm(tangents, axis=1, keepdims=True), 1e-12)
    sides = np.empty_like(line)
    sides[0] = _across(tangents[0])[0]
    for k in range(1, len(line)):
        side = sides[k - 1] - (sides[k - 1] @ tangents[k]) * tangents[k]
        size = float(np.linalg.norm(side))
        sides[k] = side / size if size > 1e-6 else _across(tangents[k])[0]
    others = np.cross(tangents, sides)
    turn = np.linspace(0.0, 2.0 * np.pi, SIDES, endpoint=False)[None, :, None]
    normals = np.cos(turn) * sides[:, None] + np.sin(turn) * others[:, None]
    rings = (line[:, None] + radius * normals).reshape(-1, 3)
    k = np.arange(len(line) - 1)[:, None] * SIDES
    j = np.arange(SIDES)[None]
    near, far = k + j, k + (j + 1) % SIDES
    faces = np.concatenate([np.stack([near, far, near + SIDES], 2), np.stack([far, far + SIDES, near + SIDES], 2)], 1)
    fan = np.stack([np.zeros(SIDES - 2, int), np.arange(2, SIDES), np.arange(1, SIDES - 1)], 1)
    caps = [fan, fan[:, ::-1] + (len(line) - 1) * SIDES]
    return rings, np.concatenate([faces.reshape(-1, 3), *caps]).astype(np.int32), normals.reshape(-1, 3)
