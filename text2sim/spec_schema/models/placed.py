"""Fields that every body has."""

from pydantic import model_validator

from text2sim.spec_schema.models.base import Model, Pose
from text2sim.spec_schema.models.materials import Look
from text2sim.spec_schema.models.placement import Place
from text2sim.spec_schema.models.repeat import Repeat


class Placed(Model):
    """What every body has: where it starts, how many there are, and its look."""

    pose: Pose | None = None
    """Where it starts; the origin if left out."""
    place: Place | None = None
    """Where it starts, said in relation to something else."""
    repeat: Repeat | None = None
    """Make several copies."""
    look: Look = Look.model_construct()
    """Colour and surface."""

    @model_validator(mode="after")
    def _one_position(self) -> "Placed":
        if self.pose is not None and self.place is not None:
            raise ValueError("give either pose or place, not both")
        return self

    @property
    def startable(self) -> bool:
        """Whether it can be given a velocity at the start: nothing holds it."""
        return False

    @property
    def passive(self) -> bool:
        """Whether it can only lose energy by itself: it has no motor, spring, loop or net of constraints."""
        return False


class Linked(Placed):
    """A body of links on joints that follow from a few numbers: the case names them, and does not list them.

    Every such kind has a `material`. What its links and joints are called is found by `known_parts` of the compiler.
    """


class Deformable(Placed):
    """A body of points, not links."""

    @property
    def startable(self) -> bool:
        """Whether it can be given a velocity at the start."""
        return True
