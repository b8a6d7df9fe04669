"""Joint with everything beyond it as one rigid body; see `mechanics`."""

from dataclasses import dataclass
from math import atan2, ceil, cos, floor, pi, sin

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.plan import Motor
from text2sim.compiler.shapes.inertials import Inertial
from text2sim.compiler.shapes.rotation import Vec, vector_cross, vector_dot
from text2sim.compiler.trees.tree import TreeJoint


@dataclass(frozen=True)
class LoadedJoint:
    """A hinge or slider and everything beyond it."""

    copy: Copy
    name: str
    """Name of the joint."""
    spec: TreeJoint
    """Its kind, axis, range, friction, damping and spring."""
    motor: Motor | None
    axis: Vec
    """Axis in the world, at the start."""
    start: float
    """Position at the start [rad or m]."""
    mass: float
    """Mass of its load [kg]."""
    inertia: float
    """Inertia about its axis, or mass, with the armature [kg m2 or kg]; 0 if it is not known."""
    pull: tuple[float, float]
    """Coefficients of gravity's torque [N m], which is `pull[0] cos q + pull[1] sin q` at the angle q from the start;
    for a slider, the first is the force [N] along its axis."""
    closed: bool
    """Whether loops or welds connect it to something else that helps to hold it."""
    floating: bool
    """Whether the root of its tree moves freely."""
    size: float
    """Largest distance [m] of a piece from the joint."""

    @property
    def hinge(self) -> bool:
        """Whether it rotates."""
        return self.spec.kind == "hinge"

    @property
    def units(self) -> tuple[str, str]:
        """Units of position and force."""
        return ("rad", "N m") if self.hinge else ("m", "N")

    def gravity(self, q: float) -> float:
        """Return the torque [N m] or force [N] of gravity along the axis at position q."""
        if not self.hinge:
            return self.pull[0]
        turn = q - self.start
        return self.pull[0] * cos(turn) + self.pull[1] * sin(turn)

    def heaviest(self, low: float, high: float) -> tuple[float, float]:
        """Return the position between `low` and `high` at which gravity's pull is largest, and that pull."""
        candidates = [low, high]
        if self.hinge and any(self.pull):
            top = atan2(self.pull[1], self.pull[0]) + self.start
            first, last = ceil((low - top) / pi), floor((high - top) / pi)
            candidates += [top + k * pi for k in range(first, min(last, first + 2) + 1)]
        return max(((q, self.gravity(q)) for q in candidates), key=lambda pair: abs(pair[1]))


def pull_of(kind: str, axis: Vec, anchor: Vec, inertial: Inertial, gravity: Vec) -> tuple[float, float]:
    """Return gravity's pull on a joint, as in `LoadedJoint.pull`.

    Args:
        kind: Kind of the joint: `hinge` or `slider`.
        axis: Its axis, a unit vector.
        anchor: A point on the axis [m].
        inertial: Mass and centre of mass of its load.
        gravity: Gravity [m/s2].
    """
    weight = tuple(inertial.mass * g for g in gravity)
    if kind == "slider":
        return (vector_dot(axis, weight), 0.0)
    arm = tuple(c - a for c, a in zip(inertial.center, anchor, strict=True))
    along = vector_dot(arm, axis)
    across = tuple(r - along * a for r, a in zip(arm, axis, strict=True))
    turned = vector_cross(axis, across)
    return (vector_dot(axis, vector_cross(across, weight)), vector_dot(axis, vector_cross(turned, weight)))


def far_from(anchor: Vec, ball: tuple[Vec, float]) -> float:
    """Return the largest distance [m] of a ball's points from an anchor."""
    (x, y, z), radius = ball
    return ((x - anchor[0]) ** 2 + (y - anchor[1]) ** 2 + (z - anchor[2]) ** 2) ** 0.5 + radius
