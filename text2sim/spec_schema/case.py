"""The case: the root of the language."""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from text2sim.spec_schema.actions import Actions
from text2sim.spec_schema.base import Model, Name
from text2sim.spec_schema.bodies import Body
from text2sim.spec_schema.render import Render
from text2sim.spec_schema.scene import Scene

LANGUAGE_VERSION = 1


def _no_boolean(value: object) -> object:
    """What is to be compared with 1: in Python, True equals it."""
    return None if isinstance(value, bool) else value


class Case(Model):
    """One scene: its stage, its actors, its script and its film."""

    text2sim: Annotated[Literal[1], BeforeValidator(_no_boolean)]
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
