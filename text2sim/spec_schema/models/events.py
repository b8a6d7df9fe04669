"""Events: moments."""

from typing import Annotated, Literal

from pydantic import Field

from text2sim.spec_schema.models.base import (
    ByKind,
    Model,
    Multiple,
    Name,
    NonNegative,
    Positive,
    Real,
    Seconds,
    Selector,
    Selectors,
    exactly_one_of,
    listed,
)
from text2sim.spec_schema.models.space import Region


class _Event(Model):
    after: Name | None = None
    """Only count times after the first time of this other event."""
    repeat: Multiple | None = None
    """Number of such events, with the names `NAME_0`, `NAME_1` and so on; `k` in `${…}` is the number of each."""

    @property
    def subjects(self) -> list[str]:
        """The selectors in `of`; none if it has no such field."""
        return listed(getattr(self, "of", None))


class ContactEvent(_Event):
    """Two bodies of any kinds begin to touch: rigid, soft, cloth, grains, liquid.

    The touches of bodies that deform are found at recorded frames, by the distance of their points, which is at most
    0.6 particle distances for pbd, a cell for mpm, and 2 mm for fem and ipc; for two such bodies, both together.
    """

    kind: Literal["contact"]
    between: tuple[Selector, Selector]
    """Two bodies, links, or sets of copies; physics has to move one of them."""
    min_impulse: NonNegative = 0.0
    """Between rigid bodies: ignore contacts with a smaller impulse [N s]."""


class SeparationEvent(_Event):
    """Two bodies of any kinds separate for at least `for`."""

    kind: Literal["separation"]
    between: tuple[Selector, Selector]
    """Two bodies, links, or sets of copies; physics has to move one of them."""
    for_: Seconds = Field(default=0.05, alias="for")
    """Time [s] without contact."""


class ThresholdEvent(_Event):
    """A measure crosses a value; each crossing counts."""

    kind: Literal["threshold"]
    measure: Name
    """Name of a measure."""
    above: Real | None = None
    """It rises to this value."""
    below: Real | None = None
    """It falls to this value."""

    _one_bound = exactly_one_of("above", "below")


class RestEvent(_Event):
    """Bodies come to rest."""

    kind: Literal["rest"]
    of: Selectors
    """A body or its copies, or a list of bodies that are at rest at the same time."""
    speed: Positive = 0.02
    """Largest speed [m/s] of bodies at rest."""
    for_: Positive = Field(default=0.2, alias="for")
    """Shortest time [s] at rest."""


class LeftDomainEvent(_Event):
    """A body leaves `scene.domain`."""

    kind: Literal["left_domain"]
    of: Selectors
    """A body or its copies."""


class RegionEvent(_Event):
    """A body's origin enters or leaves a region; each copy counts."""

    kind: Literal["enters", "leaves"]
    of: Selectors
    """A body or its copies."""
    region: Region
    """The region."""


class JointLimitEvent(_Event):
    """A joint reaches a limit of its range."""

    kind: Literal["joint_limit"]
    of: Selectors
    """A mounted body, its copies, or a joint."""


class ReleasedEvent(_Event):
    """An attachment is released."""

    kind: Literal["released"]
    attach: Name
    """Name of the control that attached it."""


class RemovedEvent(_Event):
    """A body is removed from the scene; each copy counts."""

    kind: Literal["removed"]
    remove: Name
    """Name of the control that removes it."""


class BrokenEvent(_Event):
    """A bond or attachment breaks; each counts."""

    kind: Literal["broken"]
    bond: Name
    """Name of the `bond`, or of an `attach` with a `strength`."""


Event = Annotated[
    ContactEvent
    | SeparationEvent
    | ThresholdEvent
    | RestEvent
    | LeftDomainEvent
    | RegionEvent
    | JointLimitEvent
    | ReleasedEvent
    | RemovedEvent
    | BrokenEvent,
    ByKind(),
]
