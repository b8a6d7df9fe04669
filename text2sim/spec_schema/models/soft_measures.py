"""Measures of bodies that deform."""

from typing import ClassVar, Literal, NamedTuple

from text2sim.spec_schema.models.base import AxisName, Bool, Model, Multiple, Seconds, Selector
from text2sim.spec_schema.models.space import Region

SpreadStat = Literal["max", "min", "mean", "p99"]


class Traits(NamedTuple):
    """What the rest of the program asks of a kind of measure; every kind answers all of it."""

    at_rest: float | None
    """Its value while nothing moves, the same in every case; None if there is none."""
    never_negative: bool
    """Whether its definition rules negative values out."""
    of_root: bool
    """Whether it is of the frame of a body's root link, and not of all links."""
    from_poses: bool
    """Whether the benchmark can work it out of another engine's poses, velocities and joint positions."""
    instead: str
    """What to measure of bodies that deform, if it needs a frame, which they do not have."""


class Measured(Model):
    """What every measure has."""

    traits: ClassVar[Traits]
    unit: ClassVar[str] = ""
    """SI, or deg; empty for numbers of things and shares. Those of joints go with the joint."""
    change_from: Literal["start"] | Seconds | None = None
    """The value less that at the start, or at this time [s]: by how much it has changed."""
    repeat: Multiple | None = None
    """So many of these measures, called `NAME_0`, `NAME_1` and so on; `k` in `${…}` is the number of each."""

    @property
    def value_unit(self) -> str:
        """Unit of its values: none where they count, or tell a part of the start."""
        plain = getattr(self, "stat", None) == "count" or getattr(self, "relative", False)
        return "" if plain else self.unit

    @property
    def at_rest(self) -> float | None:
        """Its value while nothing moves, the same in every case; None if there is none. Of copies, that of each."""
        return 0.0 if self.change_from is not None else self.traits.at_rest


class Volume(Measured):
    """Volume [m3] inside the surface of soft bodies, together."""

    kind: Literal["volume"]
    unit: ClassVar[str] = "m3"
    traits: ClassVar = Traits(at_rest=None, never_negative=False, of_root=False, from_poses=False, instead="")
    of: Selector
    """A soft body or its copies."""
    relative: Bool = False
    """As a part of the volume at the start."""

    @property
    def at_rest(self) -> float | None:
        """Its value while nothing moves."""
        return 1.0 if self.relative and self.change_from is None else super().at_rest


class Stretch(Measured):
    """Length of the edges of a body's surface over their lengths at the start; 1 is unstretched."""

    kind: Literal["stretch"]
    traits: ClassVar = Traits(at_rest=1.0, never_negative=True, of_root=False, from_poses=False, instead="")
    of: Selector
    """A cloth or soft body, or its copies."""
    stat: SpreadStat = "max"
    """Of all edges; `p99` is what 99 of 100 stay below."""


class Strain(Measured):
    """Equivalent strain (von Mises) of the inside of soft bodies; 0 is undeformed, whatever the body's turn.

    It is that of the Green-Lagrange strain.
    """

    kind: Literal["strain"]
    traits: ClassVar = Traits(at_rest=0.0, never_negative=True, of_root=False, from_poses=False, instead="")
    of: Selector
    """A soft body or its copies."""
    stat: SpreadStat = "max"
    """Of all elements or particles."""


class Wrinkling(Measured):
    """How much a cloth is wrinkled [1/m]: the mean curvature of its surface, in any direction, without sign.

    It comes from the angles between neighbouring triangles. A flat cloth has 0, one that is rolled to a radius R has
    1/R, and flat waves of height +-a and length l have `8 pi a / l^2`: many small folds count more than a few large
    ones.
    """

    kind: Literal["wrinkling"]
    unit: ClassVar[str] = "1/m"
    traits: ClassVar = Traits(at_rest=None, never_negative=True, of_root=False, from_poses=False, instead="")
    of: Selector
    """A cloth or its copies."""


class FoldedArea(Measured):
    """Area [m2] of a cloth that other parts of it hide, seen along an axis.

    That is the area of all its layers as they are seen, less that of their shadow: a towel folded in half hides half of
    itself, and what hangs or lies flat nothing.
    """

    kind: Literal["folded_area"]
    unit: ClassVar[str] = "m2"
    traits: ClassVar = Traits(at_rest=None, never_negative=False, of_root=False, from_poses=False, instead="")
    of: Selector
    """A cloth or its copies."""
    axis: AxisName = "z"
    """Direction from which it is seen."""


class Gap(Measured):
    """Smallest distance [m] between a body that deforms and another; negative: how deep it is in something rigid.

    It counts from the points of the body: particles of pbd rest half their distance above what carries them, particles
    of mpm up to a cell.
    """

    kind: Literal["gap"]
    unit: ClassVar[str] = "m"
    traits: ClassVar = Traits(at_rest=None, never_negative=False, of_root=False, from_poses=False, instead="")
    of: Selector
    """A body or its copies; this or the other deforms."""
    to: Selector
    """Another body or static, or its copies."""


class SelfPenetration(Measured):
    """How far [m] parts of one cloth that are no neighbours come nearer to each other than its thickness."""

    kind: Literal["self_penetration"]
    unit: ClassVar[str] = "m"
    traits: ClassVar = Traits(at_rest=None, never_negative=True, of_root=False, from_poses=False, instead="")
    of: Selector
    """A cloth or its copies."""


class Pieces(Measured):
    """In how many pieces soft bodies are, each of a hundredth of the body or more: 1 for each body that is whole.

    Particles of mpm that are two cells apart are no longer tied together. Bodies of fem never tear.
    """

    kind: Literal["pieces"]
    traits: ClassVar = Traits(at_rest=None, never_negative=True, of_root=False, from_poses=False, instead="")
    of: Selector
    """A soft body or its copies."""


class LargestPiece(Measured):
    """Mass of the largest piece of a soft body, as a part of the whole: 1 until it tears; of copies, the least.

    A `threshold` event on it says when it tears.
    """

    kind: Literal["largest_piece"]
    traits: ClassVar = Traits(at_rest=None, never_negative=True, of_root=False, from_poses=False, instead="")
    of: Selector
    """A soft body or its copies."""


class Leaked(Measured):
    """Part (0 to 1) of the mass of grains, liquids or snow that has got into or through walls and floors by then.

    Walls are grounds, statics, driven bodies and those with a mount; what has come deeper into one than what they carry
    presses it (1.6 cells, or 0.8 of half its thickness) has leaked, and stays so.
    """

    kind: Literal["leaked"]
    traits: ClassVar = Traits(at_rest=None, never_negative=True, of_root=False, from_poses=False, instead="")
    of: Selector
    """A granular body, liquid or snow, or its copies."""


class ShareIn(Measured):
    """Part (0 to 1) of the mass of bodies that lies in a region: how much sand has run through."""

    kind: Literal["share_in"]
    traits: ClassVar = Traits(at_rest=None, never_negative=True, of_root=False, from_poses=False, instead="")
    of: Selector
    """A body that deforms, or its copies."""
    region: Region
    """Where it is counted."""
