"""Rows of the program's actions: what controls, drives and prescribed motions become."""

from dataclasses import dataclass
from typing import NamedTuple

from text2sim.compiler.literal import Code
from text2sim.compiler.shapes.rotation import Quaternion, Vec


class Origin(NamedTuple):
    """Where a row comes from: its last two fields."""

    line: int
    """Of the case, which stands in the program."""
    control: str
    """Name of the control."""


@dataclass(frozen=True)
class StartVelocity:
    """Initial velocity of a free body."""

    entity: str
    linear: Vec
    angular: Vec
    line: int
    control: str


@dataclass(frozen=True)
class DriveSegment:
    """What a joint follows from a time on; its mode is position, velocity or force."""

    start: float
    mode: str
    target: Code
    """Constructor of a function of time."""
    line: int
    control: str


@dataclass(frozen=True)
class JointDrive:
    """A joint, with targets that take over from each other."""

    entity: str
    joint: str
    segments: tuple[DriveSegment, ...]
    later: tuple["LaterDrive", ...] = ()


@dataclass(frozen=True)
class LaterDrive:
    """What a joint follows `when` an event happens, or from a time [s] on where events may come between."""

    when: str | float
    mode: str
    target: Code
    """Function of the target before it, which returns a function of time, or of the time since the event."""
    line: int
    control: str


@dataclass(frozen=True)
class Wrench:
    """A force and torque on a link over a span of time [s]."""

    entity: str
    link: str | None
    start: float
    end: float
    force: Vec
    torque: Vec
    scale: Code | None
    local: bool
    point: Vec | None
    line: int
    control: str


@dataclass(frozen=True)
class Weld:
    """A weld between two links that is made or undone at a time."""

    at: float
    on: bool
    a: str
    a_link: str | None
    b: str
    b_link: str | None
    line: int
    control: str
    event: str | None = None
    """The event whose first time undoes it, instead of `at`; None if there is none."""
    pivot: Vec | None = None
    """Point [m] in the frame of the first link about which the links turn freely; None for a rigid weld."""
    stiff: bool = False
    """Whether it gives even less than the engine's welds do."""
    strength: float | None = None
    """Force [N] at which it breaks; None if it holds any."""


@dataclass(frozen=True)
class Spring:
    """A spring between points of two links over a span of time [s]."""

    a: str
    a_link: str | None
    a_point: Vec
    """In the frame of the link [m]."""
    b: str
    b_link: str | None
    b_point: Vec
    stiffness: float
    """[N/m]"""
    damping: float
    """[N s/m]"""
    length: float | None
    """Without load [m]; None for the distance of its ends as it begins."""
    pulls_only: bool
    start: float
    end: float
    line: int
    control: str


@dataclass(frozen=True)
class FaceBond:
    """Two bodies or links that hold together until the load is too high: the stress [Pa] at the face that they share.

    One without a face breaks at a force [N].
    """

    a: str
    b: str
    center: Vec | None
    """Centre [m] of the face in the world, at the start."""
    normal: Vec | None
    """Unit vector from the first body to the second, likewise."""
    area: float | None
    """[m2]"""
    strength: float
    shear_strength: float
    line: int
    control: str


@dataclass(frozen=True)
class Friction:
    """Coefficient of friction between two sets of copies, or a link of each."""

    first: tuple[str, ...]
    first_link: str | None
    second: tuple[str, ...]
    second_link: str | None
    friction: float
    line: int


@dataclass(frozen=True)
class Removal:
    """A body that leaves the scene at a time [s], or at the first time of an event."""

    entity: str
    at: float | None
    event: str | None
    line: int
    control: str


@dataclass(frozen=True)
class Hold:
    """Points of a deformable body that are held from a time on [s]."""

    entity: str
    pose: tuple[Vec, Quaternion]
    """Of the copy, at the start."""
    region: Code
    """Constructor of a function that finds the points."""
    count: int | None
    """How many points; None for all."""
    to: tuple[str, ...]
    """Copies that hold them; none for the world."""
    link: str | None
    stiffness: float | None
    """[N/m] in all; None holds firmly."""
    both_ways: bool
    """Whether what holds them feels them."""
    strength: float | None
    """Force [N] at which it breaks; None if it holds any."""
    seam: tuple[tuple[Vec, Quaternion], Code] | None
    """Pose at the start and region of the cloth `to` which they are sewn; None if something rigid holds them."""
    start: float
    until: tuple[float | str, ...]
    """Times [s] and events, whichever comes first."""
    line: int
    control: str


@dataclass(frozen=True)
class Push:
    """A force on points of a deformable body over a span of time [s]; an impulse if start and end are equal."""

    entity: str
    pose: tuple[Vec, Quaternion]
    region: Code
    force: Vec
    """[N]; of an impulse [N s]."""
    scale: Code | None
    drag: float
    start: float
    end: float
    line: int
    control: str


@dataclass(frozen=True)
class Airflow:
    """Air that flows past a cloth over a span of time [s]."""

    entity: str
    velocity: Vec
    """[m/s]"""
    scale: Code | None
    strongest: float
    """Largest absolute value of the scale during the run."""
    gusts: float
    size: float
    seed: int
    start: float
    end: float
    line: int
    control: str


@dataclass(frozen=True)
class Field:
    """An acceleration that fills space, over a span of time [s]."""

    make: Code
    """Constructor."""
    start: float
    end: float
    line: int
    control: str
    scale: Code | None = None
    """Factor over time; None if it stays as it is."""
    drift: tuple[float, float, float] | None = None
    """Velocity [m/s] of the pattern; None if it stands still."""

    @property
    def changes(self) -> bool:
        """Whether it changes while it lasts."""
        return self.scale is not None or self.drift is not None


@dataclass(frozen=True)
class Watch:
    """An event that the program itself has to see, because something is released on it."""

    name: str
    make: Code
    """Constructor of what watches for it."""
    after: str | None
    """An event that has to come first, and is watched for too."""
    line: int


@dataclass(frozen=True)
class Prescribed:
    """A driven body: the joints that carry it, and where it is as functions of time."""

    entity: str
    joints: tuple[str, ...]
    position: tuple[Code, ...]
    """One function for each joint [m]; empty for a spin."""
    velocity: tuple[Code, ...]
    """For a spin: the function [rad/s]."""
    line: int
