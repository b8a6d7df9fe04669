"""Measures of two other measures."""

from typing import ClassVar, Literal

from text2sim.spec_schema.models.base import Name
from text2sim.spec_schema.models.soft_measures import Measured, Traits


class Difference(Measured):
    """The first of two other measures minus the second.

    Both have the same unit.
    """

    kind: Literal["difference"]
    traits: ClassVar = Traits(at_rest=None, never_negative=False, of_root=False, from_poses=False, instead="")
    measures: tuple[Name, Name]
    """Names of two measures, which may be differences or ratios themselves."""


class Ratio(Measured):
    """The first divided by the second.

    It has no value while the second is 0.
    """

    kind: Literal["ratio"]
    traits: ClassVar = Traits(at_rest=None, never_negative=False, of_root=False, from_poses=False, instead="")
    measures: tuple[Name, Name]
    """Names of two measures, which may be differences or ratios themselves."""
