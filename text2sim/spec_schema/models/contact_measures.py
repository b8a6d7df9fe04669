"""Measures of contacts."""

from typing import ClassVar, Literal

from text2sim.spec_schema.models.base import AxisName, Selectors
from text2sim.spec_schema.models.soft_measures import Measured, Traits


class ContactForce(Measured):
    """Magnitude [N] of the sum of contact forces on a rigid body by rigid ones.

    If `by` is given, of those from another. Forces of what deforms are not reported: measure its `gap`, or what it
    moves.
    """

    kind: Literal["contact_force"]
    unit: ClassVar[str] = "N"
    traits: ClassVar = Traits(at_rest=None, never_negative=False, of_root=False, from_poses=False, instead="")
    of: Selectors
    """The body that the forces act on."""
    by: Selectors | None = None
    """The other body; any by default."""
    axis: AxisName | None = None
    """Instead of the magnitude, the signed component along an axis of the world: on what stands on a floor, that along
    z is the normal force, and positive."""


class ContactCount(Measured):
    """Number of pairs of rigid bodies in contact: those of `of` with any body, or with `by`.

    What touches two bodies counts twice.
    """

    kind: Literal["contact_count"]
    traits: ClassVar = Traits(at_rest=None, never_negative=True, of_root=False, from_poses=False, instead="")
    of: Selectors
    """A body or its copies; links, each of which counts by itself (`rover.wheel_*`); or parts, which all count as
    their body."""
    by: Selectors | None = None
    """The other body; any by default. Contacts within a body count with links on both sides (`cord.link_*`)."""


class Penetration(Measured):
    """Deepest overlap [m] of rigid bodies in contact, or of what deforms in a rigid body.

    It is that of `of` with any body, or with `by`.
    """

    kind: Literal["penetration"]
    unit: ClassVar[str] = "m"
    traits: ClassVar = Traits(at_rest=None, never_negative=True, of_root=False, from_poses=False, instead="")
    of: Selectors
    """A body or its copies."""
    by: Selectors | None = None
    """The other body; any by default."""
