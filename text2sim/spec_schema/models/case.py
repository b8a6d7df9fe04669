"""Case: the root of the language."""

from typing import Annotated, Any, Literal

from pydantic import Field

from text2sim.spec_schema.models.actions import Actions
from text2sim.spec_schema.models.base import Model, Name
from text2sim.spec_schema.models.bodies import Body
from text2sim.spec_schema.models.placed import Deformable
from text2sim.spec_schema.models.render import Render
from text2sim.spec_schema.models.scene import Scene


class Case(Model):
    """One scene: its stage, its actors, its script and its film."""

    text2sim: Literal[2]
    """Version of the language. Older ones stay valid; `text2sim migrate` rewrites them."""
    name: Name
    """Name of the case; usually that of the folder."""
    prompt: str = Field(default="", max_length=10_000)
    """The request, in words."""
    params: dict[Name, Any] = Field(default_factory=dict)
    """Numbers, strings, and lists of them, for use in `${…}`."""
    prefabs: dict[Name, Any] = Field(default_factory=dict)
    """Bodies with parameters, by name, for `use` in this case."""
    scene: Scene
    """The stage."""
    bodies: Annotated[dict[Name, Body], Field(min_length=1)]
    """The actors: everything that moves, by name."""
    actions: Actions = Actions.model_construct()
    """The script."""
    render: Render = Render.model_construct()
    """The cinematography."""
    variants: dict[Name, Any] = Field(default_factory=dict)
    """Changes to this case, by name: `--variant NAME` applies one."""
    sweeps: dict[Name, Any] = Field(default_factory=dict)
    """Lists and grids of changes, by name: `text2sim run CASE --sweep NAME` runs them all."""
    waive: dict[str, Annotated[str, Field(min_length=10, max_length=500)]] = Field(default_factory=dict)
    """Rules of the lint that do not apply, by id, with the reason (10 characters or more): `overlap` everywhere, or
    `overlap@bodies.pin` for what is found there alone."""

    @property
    def record_rate(self) -> float:
        """Recorded frames per simulated second; those of deformable bodies are large."""
        if self.scene.record.rate is not None:
            return self.scene.record.rate
        return 50.0 if any(isinstance(body, Deformable) for body in self.bodies.values()) else 100.0
