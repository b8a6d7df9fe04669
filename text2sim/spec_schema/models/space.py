"""Regions of space, in the world: where a packing lies, where copies are counted."""

from typing import Annotated, Literal

from pydantic import Field

from text2sim.spec_schema.models.base import Axis, Bounds, Model, Positive, Vec3


class BoxRegion(Bounds):
    """An upright box of space."""

    kind: Literal["box"]


class CylinderRegion(Model):
    """A cylinder of space."""

    kind: Literal["cylinder"]
    center: Vec3
    """Its middle [m]."""
    radius: Positive
    """Radius [m]."""
    height: Positive
    """Length [m] along its axis."""
    axis: Axis = "z"
    """Direction of its axis."""


class SphereRegion(Model):
    """A ball of space."""

    kind: Literal["sphere"]
    center: Vec3
    """Its middle [m]."""
    radius: Positive
    """Radius [m]."""


Region = Annotated[BoxRegion | CylinderRegion | SphereRegion, Field(discriminator="kind")]
