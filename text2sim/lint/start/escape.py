"""Depths of overlaps, and the translations that resolve them.

Convex pieces move in straight lines: to find the exit along a direction, a piece is moved far away and swept back until
it touches (`compiler.shapes.sweep`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from text2sim.compiler.shapes.boxes import apart, moved, union
from text2sim.compiler.shapes.gjk import distance
from text2sim.compiler.shapes.rotation import Vec, quat_to_rows, vector_dot, vector_minus, vector_plus, vector_times
from text2sim.compiler.shapes.sweep import sweep
from text2sim.lint.parts import StandingPart
from text2sim.lint.start import concave

AXES: dict[Vec, str] = {
    (1.0, 0.0, 0.0): "+x",
    (-1.0, 0.0, 0.0): "-x",
    (0.0, 1.0, 0.0): "+y",
    (0.0, -1.0, 0.0): "-y",
    (0.0, 0.0, 1.0): "+z",
    (0.0, 0.0, -1.0): "-z",
}
MAX_AXIS_DETOUR = 1.5
"""A translation along an axis is preferred if it is at most this many times as long as the shortest."""
MAX_ROUNDS = 30
"""Largest number of times a body is moved on when leaving one piece makes it enter another."""
MAX_DIRECTION_PAIRS = 3
"""Largest number of pairs of pieces whose shapes give directions in which to escape."""
MAX_EXACT_PAIRS = 12
"""Largest number of pairs of pieces whose depth is computed in all directions."""
SWEEP_COST = 5
"""Steps that a sweep costs; a test costs one."""
ROUND_SWEEP_COST = 20
"""Steps that a sweep with a round piece costs, because it converges slowly."""
ROUND_PIECES = ("cylinder", "ellipsoid")
BOX_TESTS_PER_STEP = 100
"""Pairs of boxes that are compared in the time of a step."""
MAX_STEPS_PER_OVERLAP = 1200
"""Largest number of steps for one overlap."""
ROUNDING_OVERLAP = 1e-6
"""Overlap [m] of bounding boxes that is only rounding."""


class Effort:
    """Budget of steps, which bounds the cost of a heap of overlaps."""

    def __init__(self, steps: int) -> None:
        self.left = steps

    def spend(self, steps: int = 1) -> bool:
        """Spend steps; return whether the budget allowed it."""
        self.left -= steps
        return self.left >= 0


@dataclass(frozen=True)
class Escape:
    """A translation that frees a body from another."""

    direction: Vec
    """Unit vector."""
    length: float
    """[m]"""

    @property
    def words(self) -> str:
        """The direction as text: an axis such as `+z`, or a vector."""
        return AXES.get(self.direction) or "({})".format(", ".join(f"{c + 0.0:.2g}" for c in self.direction))


@dataclass(frozen=True)
class Overlap:
    """Two bodies inside each other."""

    depth: float
    """Depth [m] of the deepest pair of convex pieces, which the engine treats as a compressed contact."""
    thickness: float
    """Thickness [m] of the thinner piece of that pair."""
    pair: tuple[StandingPart, StandingPart]
    """That pair: a piece of the first body, and one of the second."""
    escapes: list[Escape]
    """Translations that free the first body as a whole, the shortest first."""


def overlapping(a: StandingPart, b: StandingPart) -> bool:
    """Return whether two pieces overlap."""
    if apart(a.box, b.box, ROUNDING_OVERLAP):
        return False
    if a.mesh is not None or b.mesh is not None:
        return concave.inside(a, b)
    if axis_aligned_box(a) and axis_aligned_box(b):
        return True
    return distance(a.solid, b.solid) == 0.0


def axis_aligned_box(part: StandingPart) -> bool:
    """Return whether a piece fills its bounding box."""
    if part.piece.kind != "box":
        return False
    return all(max(abs(c) for c in row) > 1 - 1e-12 for row in quat_to_rows(part.turn))


def overlap_of(
    movers: Sequence[StandingPart],
    others: Sequence[StandingPart],
    pairs: list[tuple[StandingPart, StandingPart]],
    effort: Effort,
) -> Overlap:
    """Return how two bodies overlap.

    Args:
        movers: Pieces of the first body.
        others: Pieces of the second.
        pairs: Overlapping pieces (of the first, of the second).
        effort: Budget; if it is exhausted, there may be no translations.
    """
    pairs = pairs[:: len(pairs) // MAX_EXACT_PAIRS + 1]
    directions = _directions(pairs)
    effort.spend(len(directions) * _cost(pairs))
    exits = {direction: [_exit(a, b, direction) for a, b in pairs] for direction in directions}
    depths = [min(column) for column in zip(*exits.values(), strict=True)]
    worst = max(range(len(depths)), key=depths.__getitem__)
    pair = pairs[worst]
    own = Effort(min(max(effort.left, 0), MAX_STEPS_PER_OVERLAP))
    effort.left -= own.left
    escapes = []
    for direction, first in exits.items():
        length = _free_length(movers, others, direction, max(first), own)
        if length is not None:
            escapes.append(Escape(direction, length))
    effort.left += max(own.left, 0)
    escapes.sort(key=lambda escape: (escape.length, escape.direction not in AXES))
    return Overlap(depths[worst], min(pair[0].thickness, pair[1].thickness), pair, escapes)


def axes_first(escapes: Sequence[Escape]) -> list[Escape]:
    """Return the translations, those along an axis first unless they are much longer than the shortest."""
    if not escapes:
        return []
    limit = MAX_AXIS_DETOUR * escapes[0].length
    return sorted(escapes, key=lambda escape: (escape.length > limit, escape.direction not in AXES, escape.length))


def _free_length(
    movers: Sequence[StandingPart], others: Sequence[StandingPart], direction: Vec, length: float, effort: Effort
) -> float | None:
    """Return a distance [m] of at least `length` after which no mover is in the others; None if it takes too long."""
    for _ in range(MAX_ROUNDS):
        step = vector_times(direction, length + ROUNDING_OVERLAP)
        away = [(a, moved(a.box, step)) for a in movers]
        around = union(box for _, box in away)
        near = [b for b in others if not apart(around, b.box, ROUNDING_OVERLAP)]
        if not effort.spend(len(away) * len(near) // BOX_TESTS_PER_STEP):
            return None
        boxes = ((a, b) for a, box in away for b in near if not apart(box, b.box, ROUNDING_OVERLAP))
        pairs = [(a, b) for a, b in boxes if _still_inside(a, b, step, effort)]
        if effort.left < 0:
            return None
        if not pairs:
            return length
        # A sample is enough: the next round finds the rest.
        pairs = pairs[:: len(pairs) // MAX_EXACT_PAIRS + 1]
        effort.spend(_cost(pairs))
        length = max([length, *(_exit(a, b, direction) for a, b in pairs)])
    return None


def _cost(pairs: list[tuple[StandingPart, StandingPart]]) -> int:
    """Return the steps that a sweep of each pair of pieces costs."""
    return sum(
        ROUND_SWEEP_COST if a.piece.kind in ROUND_PIECES or b.piece.kind in ROUND_PIECES else SWEEP_COST
        for a, b in pairs
    )


def moved_part(part: StandingPart, escape: Escape) -> StandingPart:
    """Return a piece after a translation."""
    return replace(part, pos=vector_plus(part.pos, vector_times(escape.direction, escape.length + ROUNDING_OVERLAP)))


def _still_inside(a: StandingPart, b: StandingPart, step: Vec, effort: Effort) -> bool:
    if not effort.spend():
        return False
    if a.mesh is not None or b.mesh is not None:
        return concave.inside(a, b, step)
    return distance(a.solid, b.solid, step) == 0.0


def _exit(one: StandingPart, other: StandingPart, direction: Vec) -> float:
    """Return the distance [m] along a direction after which one piece has left another."""
    if one.mesh is not None or other.mesh is not None:
        return concave.exit_length(one, other, direction)
    a, b = one.solid, other.solid
    far = vector_dot(vector_minus(b.center, a.center), direction) + a.ball + b.ball
    back = sweep([a], [b], vector_times(direction, -1.0), start=vector_times(direction, far))
    return 0.0 if back is None else far - back


def _directions(pairs: list[tuple[StandingPart, StandingPart]]) -> list[Vec]:
    """Return the axes and, of a few pairs, the lines between centres and the normals of boxes and cylinder ends."""
    found = dict.fromkeys(AXES)
    for a, b in pairs[:MAX_DIRECTION_PAIRS]:
        line = vector_minus(a.solid.center, b.solid.center)
        length = vector_dot(line, line) ** 0.5
        if length > 1e-9:
            found[_clean(vector_times(line, 1.0 / length))] = None
        for part in (a, b):
            if part.piece.kind in ("box", "cylinder"):
                for x, y, z in part.axes:
                    found |= dict.fromkeys((_clean((x, y, z)), _clean((-x, -y, -z))))
    return list(found)


def _clean(v: Vec) -> Vec:
    """Return a unit vector without rounding errors, so that an axis is recognised as such."""
    x, y, z = (0.0 if abs(c) < 1e-9 else 1.0 if c > 1 - 1e-9 else -1.0 if c < 1e-9 - 1 else c for c in v)
    return x, y, z
