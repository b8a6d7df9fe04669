"""Regions of space: where a packing lies, where copies are counted."""

from typing import Annotated, Literal

from text2sim.spec_schema.models.base import Axis, Bounds, ByKind, Model, Positive, Selector, Vec3


class _Space(Model):
    """What a region of space has."""

    moves_with: Selector | None = None
    """A body of links, or one link, that carries it in a measure or event: it stands as it is said here at the start,
    in the world, and goes and turns along with that body."""


class BoxRegion(_Space, Bounds):
    """An upright box of space."""

    kind: Literal["box"]


class CylinderRegion(_Space):
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


class SphereRegion(_Space):
    """A ball of space."""

    kind: Literal["sphere"]
    center: Vec3
    """Its middle [m]."""
    radius: Positive
    """Radius [m]."""


Region = Annotated[BoxRegion | CylinderRegion | SphereRegion, ByKind()]
