"""Measures of deformable bodies."""

from typing import ClassVar, Literal, NamedTuple

from text2sim.spec_schema.models.base import AxisName, Bool, Model, Multiple, Seconds, Selectors, listed
from text2sim.spec_schema.models.space import Region

SpreadStat = Literal["max", "min", "mean", "p99"]


class Traits(NamedTuple):
    """Properties of a kind of measure that other modules use; every kind defines all of them."""

    at_rest: float | None
    """Its value if nothing moves during the run, if it is the same in every case; otherwise None."""
    never_negative: bool
    """Whether its definition excludes negative values."""
    of_root: bool
    """Whether it refers to the frame of a body's root link instead of all links."""
    from_poses: bool
    """Whether the benchmark can compute it from another engine's poses, velocities and joint positions."""
    instead: str
    """Advice on what to measure of deformable bodies, which have no frame; empty if it needs none."""


class Measured(Model):
    """Fields of every measure."""

    traits: ClassVar[Traits]
    unit: ClassVar[str] = ""
    """SI unit, or deg; empty for counts and fractions, and for measures of joints, whose unit depends on the joint."""
    change_from: Literal["start"] | Seconds | None = None
    """Measure the change of the value since the start, or since this time [s]."""
    so_far: Literal["max", "min", "range"] | None = None
    """Measure the largest value so far, the smallest, or their difference: so a `ratio` or `difference` compares the
    extremes of two bodies that come at different times (of changes, with `change_from`)."""
    repeat: Multiple | None = None
    """Number of such measures, with the names `NAME_0`, `NAME_1` and so on; `k` in `${…}` is the number of each."""

    @property
    def subjects(self) -> list[str]:
        """The selectors in `of`; none if it has no such field, or is about all bodies."""
        return listed(getattr(self, "of", None))

    @property
    def value_unit(self) -> str:
        """Unit of its values; empty for counts and for fractions of the value at the start."""
        plain = getattr(self, "stat", None) == "count" or getattr(self, "relative", False)
        return "" if plain else self.unit

    @property
    def at_rest(self) -> float | None:
        """As `Traits.at_rest`, for the change too if that is measured. For copies, that of each."""
        return 0.0 if self.change_from is not None or self.so_far == "range" else self.traits.at_rest


class Volume(Measured):
    """Total volume [m3] inside the surface of soft bodies."""

    kind: Literal["volume"]
    unit: ClassVar[str] = "m3"
    traits: ClassVar = Traits(at_rest=None, never_negative=False, of_root=False, from_poses=False, instead="")
    of: Selectors
    """A soft body or its copies."""
    relative: Bool = False
    """Measure it as a fraction of the volume at the start."""

    @property
    def at_rest(self) -> float | None:
        """Its value while nothing moves."""
        return 1.0 if self.relative and super().at_rest is None else super().at_rest


class Stretch(Measured):
    """Length of the edges of a body's surface relative to their lengths at the start; 1 is unstretched."""

    kind: Literal["stretch"]
    traits: ClassVar = Traits(at_rest=1.0, never_negative=True, of_root=False, from_poses=False, instead="")
    of: Selectors
    """A cloth or soft body, or its copies."""
    stat: SpreadStat = "max"
    """Statistic over all edges; `p99` is the 99th percentile."""


class Strain(Measured):
    """Equivalent strain (von Mises) inside soft bodies; 0 is undeformed, in any orientation.

    It is derived from the Green-Lagrange strain.
    """

    kind: Literal["strain"]
    traits: ClassVar = Traits(at_rest=0.0, never_negative=True, of_root=False, from_poses=False, instead="")
    of: Selectors
    """A soft body or its copies."""
    stat: SpreadStat = "max"
    """Statistic over all elements or particles."""


class Wrinkling(Measured):
    """Wrinkling of a cloth [1/m]: the mean curvature of its surface, in any direction, without sign.

    It is derived from the angles between neighbouring triangles. A flat cloth has 0, a roll of radius R has 1/R, and
    shallow waves of amplitude a and wavelength l have `8 pi a / l^2`: many small folds count more than a few large
    ones.
    """

    kind: Literal["wrinkling"]
    unit: ClassVar[str] = "1/m"
    traits: ClassVar = Traits(at_rest=None, never_negative=True, of_root=False, from_poses=False, instead="")
    of: Selectors
    """A cloth or its copies."""


class FoldedArea(Measured):
    """Area [m2] of a cloth that other parts of it hide, seen along an axis.

    It is the projected area of all its layers minus the area of their common shadow: a towel folded in half hides half
    of itself, one that hangs or lies flat hides nothing.
    """

    kind: Literal["folded_area"]
    unit: ClassVar[str] = "m2"
    traits: ClassVar = Traits(at_rest=None, never_negative=False, of_root=False, from_poses=False, instead="")
    of: Selectors
    """A cloth or its copies."""
    axis: AxisName = "z"
    """Viewing direction."""


class Folds(Measured):
    """Number of folds side by side in a cloth, or lobes of a buckled strip: n waves are n, to one at the ends.

    The cloth is cut into lines, and their median counts. Along a line, a fold is a bend by at least 30 deg one way, and
    then the other way: a flat sheet, an arch, a roll and a sheet that is folded once have none. A wave needs six cells
    to be seen.
    """

    kind: Literal["folds"]
    traits: ClassVar = Traits(at_rest=None, never_negative=True, of_root=False, from_poses=False, instead="")
    of: Selectors
    """A cloth or its copies; of several, all their lines together."""
    across: AxisName
    """Axis of the cloth's own frame that the lines are at right angles to, at the start: `y` counts along the x of a
    sheet, as of a curtain that hangs down y; `x` along the height of a sleeve, `z` around it."""


class Gap(Measured):
    """Smallest distance [m] between a deformable body and any other; negative values are the depth in a rigid body.

    It is measured from the points of the body: pbd particles rest half their distance above a surface, mpm particles up
    to a cell.
    """

    kind: Literal["gap"]
    unit: ClassVar[str] = "m"
    traits: ClassVar = Traits(at_rest=None, never_negative=False, of_root=False, from_poses=False, instead="")
    of: Selectors
    """A body or its copies; this or the other is deformable."""
    to: Selectors
    """Another body or static, or its copies."""


class SelfPenetration(Measured):
    """Depth [m] by which parts of a cloth that are not neighbours come closer to each other than its thickness."""

    kind: Literal["self_penetration"]
    unit: ClassVar[str] = "m"
    traits: ClassVar = Traits(at_rest=None, never_negative=True, of_root=False, from_poses=False, instead="")
    of: Selectors
    """A cloth or its copies."""


class Pieces(Measured):
    """Number of pieces of soft bodies or snow, each of at least 1 % of its body: 1 for each intact body.

    Particles of mpm that are two cells apart are no longer connected; chunks of snow that touch are one. Bodies of fem
    never tear. Of rigid bodies that a `bond` joins, the number of groups that still hang together: 1 while all
    bonds between them hold.
    """

    kind: Literal["pieces"]
    traits: ClassVar = Traits(at_rest=None, never_negative=True, of_root=False, from_poses=False, instead="")
    of: Selectors
    """A soft body, snow, or copies of one, or bonded rigid bodies."""


class LargestPiece(Measured):
    """Mass of the largest piece of a soft body or snow, as a fraction of it: 1 until it tears; for copies the smallest.

    A `threshold` event on it marks when it tears. Of rigid bodies that a `bond` joins, the mass of the largest group
    that still hangs together, as a fraction of all selected.
    """

    kind: Literal["largest_piece"]
    traits: ClassVar = Traits(at_rest=None, never_negative=True, of_root=False, from_poses=False, instead="")
    of: Selectors
    """A soft body, snow, or copies of one, or bonded rigid bodies."""


class Leaked(Measured):
    """Fraction of the mass of grains, liquids or snow that has entered or passed walls and floors so far.

    Walls are grounds, statics, driven bodies and bodies with a mount. Material counts as leaked for good once it is
    deeper inside one than a load presses it (1.6 cells, or 0.8 of half its thickness).
    """

    kind: Literal["leaked"]
    traits: ClassVar = Traits(at_rest=None, never_negative=True, of_root=False, from_poses=False, instead="")
    of: Selectors
    """A granular body, liquid or snow, or its copies."""


class ShareIn(Measured):
    """Fraction of the mass of bodies inside a region, such as the sand that has run through."""

    kind: Literal["share_in"]
    traits: ClassVar = Traits(at_rest=None, never_negative=True, of_root=False, from_poses=False, instead="")
    of: Selectors
    """A deformable body, or its copies."""
    region: Region
    """The region, given in the world; it stays there unless it `moves_with` a link."""


class SurfaceLevel(Measured):
    """Height [m] of the free surface of a liquid or of grains, as a gauge shows it; no value where there is none.

    It is the median over columns that are two particle distances wide. A column ends half a particle distance above
    its highest particle that has three more close below it, so that drops and spray do not count, nor does what waits
    in the mouth of a stream. It is exact to about half a particle distance (a third of a `cell`).
    """

    kind: Literal["surface_level"]
    unit: ClassVar[str] = "m"
    traits: ClassVar = Traits(at_rest=None, never_negative=False, of_root=False, from_poses=False, instead="")
    of: Selectors
    """A granular body, liquid or snow, or its copies, which have one surface together."""
    region: Region | None = None
    """Where it is measured, such as a narrow cylinder for the height of waves at a point, at least two cells wide; by
    default everywhere, puddles beside a vessel included. What is outside, above or below does not count."""


class Submerged(Measured):
    """Fraction of the volume of rigid bodies below the surface of a liquid or of grains around them, from 0 to 1.

    The solid that has contact is sampled at about four thousand points, so that an inflated or hollow body counts with
    its walls. Its surroundings are level: the median of the columns (see `surface_level`) within eight particle
    distances beside it, and of those that reach above it. A body has 0 if none of them is at its height. A body at rest
    that floats has its density over that of the liquid (Archimedes).
    """

    kind: Literal["submerged"]
    traits: ClassVar = Traits(
        at_rest=None, never_negative=True, of_root=False, from_poses=False, instead="measure its `share_in` a region"
    )
    of: Selectors
    """A rigid body, its copies, or links of it; of several, their common fraction."""
    by: Selectors
    """A granular body, liquid or snow, or its copies."""
