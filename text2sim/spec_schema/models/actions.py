"""Section `actions`: what is driven, what is measured, and what must come true."""

from pydantic import Field

from text2sim.spec_schema.models.base import Model, Name
from text2sim.spec_schema.models.controls import Control
from text2sim.spec_schema.models.events import Event
from text2sim.spec_schema.models.expectations import Expect
from text2sim.spec_schema.models.measures import Measure


class Actions(Model):
    """The script: what is driven, what is measured, what must come true."""

    controls: dict[Name, Control] = Field(default_factory=dict)
    """What acts on the bodies, by name."""
    measures: dict[Name, Measure] = Field(default_factory=dict)
    """Numbers over time, by name."""
    events: dict[Name, Event] = Field(default_factory=dict)
    """Moments, by name."""
    expect: dict[Name, Expect] = Field(default_factory=dict)
    """What must come true, by name."""
