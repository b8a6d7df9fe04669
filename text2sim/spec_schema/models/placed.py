"""Fields that every body has."""

from pydantic import model_validator

from text2sim.spec_schema.models.base import Model, Pose
from text2sim.spec_schema.models.materials import Look
from text2sim.spec_schema.models.placement import Place
from text2sim.spec_schema.models.repeat import Repeat


class Placed(Model):
    """Fields of every body: start, copies and look."""

    pose: Pose | None = None
    """Its pose at the start; by default the origin."""
    place: Place | None = None
    """Instead of `pose`: its position at the start, relative to another body or static."""
    repeat: Repeat | None = None
    """A pattern of copies."""
    look: Look = Look.model_construct()
    """Colour and surface."""

    @model_validator(mode="after")
    def _one_position(self) -> "Placed":
        if self.pose is not None and self.place is not None:
            raise ValueError("give either pose or place, not both")
        return self

    @property
    def startable(self) -> bool:
        """Whether it can be given a velocity at the start, because nothing holds it."""
        return False

    @property
    def passive(self) -> bool:
        """Whether it can only lose energy by itself, because it has no motor, spring, loop or net of constraints."""
        return False


class Linked(Placed):
    """A body whose links and joints are derived from a few parameters instead of listed in the case.

    Every such kind has a `material`. `known_parts` of the compiler returns the names of links and joints.
    """


class Deformable(Placed):
    """A body that consists of points instead of links."""

    @property
    def startable(self) -> bool:
        """Whether it can be given a velocity at the start."""
        return True
