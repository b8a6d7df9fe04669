"""The case: the root of the language."""

from typing import Annotated, Any, Literal

from pydantic import Field

from text2sim.spec_schema.actions import Actions
from text2sim.spec_schema.base import Model, Name
from text2sim.spec_schema.bodies import Body
from text2sim.spec_schema.render import Render
from text2sim.spec_schema.scene import Scene

LANGUAGE_VERSION = 1


class Case(Model):
    """One scene: its stage, its actors, its script and its film."""

    text2sim: Literal[1]
    """Version of the language."""
    name: Name
    """Name of the case; the folder's name, by custom."""
    prompt: str = Field(default="", max_length=10_000)
    """What was asked for, in words."""
    params: dict[Name, Any] = Field(default_factory=dict)
    """Numbers, strings, and lists of them, for use in `${…}`."""
    scene: Scene
    """The stage."""
    bodies: Annotated[dict[Name, Body], Field(min_length=1)]
    """The actors: everything that moves, by name."""
    actions: Actions = Actions()
    """The script."""
    render: Render = Render()
    """The cinematography."""
