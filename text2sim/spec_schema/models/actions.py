"""Section `actions`: controls, measures, events and expectations."""

from pydantic import Field

from text2sim.spec_schema.models.base import Model, Name
from text2sim.spec_schema.models.controls import Control
from text2sim.spec_schema.models.events import Event
from text2sim.spec_schema.models.expectations import Expect
from text2sim.spec_schema.models.measures import Measure


class Actions(Model):
    """The script: controls, measures, events and expectations."""

    controls: dict[Name, Control] = Field(default_factory=dict)
    """Actions on the bodies."""
    measures: dict[Name, Measure] = Field(default_factory=dict)
    """Numbers over time."""
    events: dict[Name, Event] = Field(default_factory=dict)
    """Moments."""
    expect: dict[Name, Expect] = Field(default_factory=dict)
    """Requirements on them."""
