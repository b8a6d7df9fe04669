"""Expectations: requirements on events and measures."""

from typing import Literal

from pydantic import model_validator

from text2sim.spec_schema.models.base import Bool, Integer, Model, Multiple, Name, Positive, Real, Seconds, Window

SPREADS = ("std", "range")
"""Statistics of how far values are apart: 0 of what does not change."""
CHANGE = "change"
"""Statistic of the last value less the first."""
SWINGS = ("reversals", "period", "decrement")
"""Statistics of motion back and forth, with `swing`."""


class Expect(Model):
    """A requirement on an event or a measure.

    An event happens (`within` a span, `count` times, `before` another) or `never`; a measure is `above`,
    `below` or near a value (`equals`, `tolerance`), `at` a time or `during` a span.
    """

    event: Name | None = None
    """Name of the event."""
    within: Window | None = None
    """The first time of the event is in this span [s]."""
    never: Bool = False
    """The event must not happen."""
    count: tuple[Integer, Integer] | Integer | None = None
    """How often the event happens: an exact number, or the smallest and the largest."""
    before: Name | None = None
    """The event's first time is earlier than that of this other event."""
    on: Name | None = None
    """Name of an event: the times of `within`, `at` and `during` are relative to its first time. It must happen."""

    measure: Name | None = None
    """Name of the measure."""
    at: Seconds | Literal["start", "end"] | None = None
    """Time [s] of the value."""
    during: Window | Literal["all"] | None = None
    """Span [s]: every value in it must satisfy the bounds, or the `stat` of them."""
    stat: Literal["max", "min", "mean", "std", "range", "change", "reversals", "period", "decrement"] | None = None
    """With `during`: statistic of the span. `std` is the standard deviation from its mean, `change` the last value less
    the first (with `on`, since that event). Of motion back and forth: `reversals`, how often it turns back, twice in a
    full swing; `period` [s], the mean time of a full swing; `decrement`, the logarithmic decrement, ln of a swing over
    the one a period later: 0 if they stay as large, 0.69 if each is half as large. These need a measure with a sign:
    `tilt` and `speed` turn back twice as often."""
    swing: Positive | None = None
    """With `reversals`, `period` and `decrement`, required: smallest change that counts, in the unit of the measure."""
    above: Real | None = None
    """Lower bound, exclusive."""
    below: Real | None = None
    """Upper bound, exclusive."""
    equals: Real | None = None
    """Expected value, within `tolerance`."""
    tolerance: Positive | None = None
    """With `equals`: largest difference."""

    repeat: Multiple | None = None
    """Number of such expectations, with the names `NAME_0`, `NAME_1` and so on; `k` in `${…}` is the number of each."""

    @model_validator(mode="after")
    def _complete(self) -> "Expect":
        if (self.event is None) == (self.measure is None):
            raise ValueError("give either event or measure")
        of_event = {"within", "never", "count", "before"} & self.model_fields_set
        of_measure = {"at", "during", "stat", "swing", "above", "below", "equals", "tolerance"} & self.model_fields_set
        if self.event is not None:
            if of_measure:
                raise ValueError(f"{_listed(of_measure)} with a measure; an event takes within, never, count or before")
            if self.never and (of_event - {"never", "within"}):
                raise ValueError("never can only be combined with within")
            if self.on is not None and self.within is None:
                raise ValueError("on goes with within, at or during")
            return self
        if of_event:
            raise ValueError(f"{_listed(of_event)} with an event; a measure takes above, below or equals")
        if (self.at is None) == (self.during is None):
            raise ValueError("a measure needs either at or during")
        if self.on is not None and (isinstance(self.at, str) or self.during == "all"):
            raise ValueError("with on, give times in seconds after that event; during may end at end")
        if self.stat is not None and self.during is None:
            raise ValueError("stat goes with during")
        if (self.stat in SWINGS) != (self.swing is not None):
            raise ValueError(f"swing, the smallest change that counts, goes with {', '.join(SWINGS)}, which need it")
        if self.above is None and self.below is None and self.equals is None:
            raise ValueError("a measure needs above, below or equals")
        if (self.equals is None) != (self.tolerance is None):
            raise ValueError("equals and tolerance go together")
        return self


def _listed(fields: set[str]) -> str:
    return f"{', '.join(sorted(fields))} {'goes' if len(fields) == 1 else 'go'}"
