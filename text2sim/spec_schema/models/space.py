"""Regions of space, for packings, measures and events."""

from typing import Annotated, Literal

from text2sim.spec_schema.models.base import Axis, Bounds, ByKind, Model, Positive, Selector, Vec3


class _Space(Model):
    """Fields of every region of space."""

    moves_with: Selector | None = None
    """A body of links, or one link, that the region moves and turns with, in a measure or event. The region is given in
    the world at the start."""


class BoxRegion(_Space, Bounds):
    """An axis-aligned box."""

    kind: Literal["box"]


class CylinderRegion(_Space):
    """A cylinder."""

    kind: Literal["cylinder"]
    center: Vec3
    """Its centre [m]."""
    radius: Positive
    """Radius [m]."""
    height: Positive
    """Length [m] along its axis."""
    axis: Axis = "z"
    """Direction of its axis."""


class SphereRegion(_Space):
    """A sphere."""

    kind: Literal["sphere"]
    center: Vec3
    """Its centre [m]."""
    radius: Positive
    """Radius [m]."""


Region = Annotated[BoxRegion | CylinderRegion | SphereRegion, ByKind()]
