"""Prefabs as they are written: bodies with parameters."""

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from text2sim.spec_schema.models.base import Model, Name, Real

ParamKind = Literal[
    "number",
    "integer",
    "length",
    "angle_deg",
    "vec2",
    "vec3",
    "text",
    "color",
    "bool",
    "choice",
    "body",
]
NUMERIC = ("number", "integer", "length", "angle_deg", "vec2", "vec3")
"""Kinds that can have bounds."""


class PrefabParam(Model):
    """A parameter of a prefab."""

    kind: ParamKind
    """What it takes: `number`, `integer`, `length` [m], greater than 0, `angle_deg` [deg], `vec2`, `vec3`, `text`,
    `color`, `bool`, `choice`, `body` (a selector)."""
    default: Any = None
    """Its value if none is given, which may be an expression over the other parameters; required if left out."""
    min: Real | None = None
    """Smallest number, or smallest item of a vector."""
    max: Real | None = None
    """Largest number, or largest item of a vector."""
    of: Annotated[list[Annotated[str, Field(max_length=100)]], Field(min_length=1, max_length=100)] | None = None
    """With `choice`: the words to choose from."""
    doc: str = Field(default="", max_length=2000)
    """What it is for."""

    @model_validator(mode="after")
    def _fitting(self) -> "PrefabParam":
        if self.kind not in NUMERIC and (self.min is not None or self.max is not None):
            raise ValueError(f"min and max go with {', '.join(NUMERIC)}, not with {self.kind}")
        if self.min is not None and self.max is not None and self.max < self.min:
            raise ValueError(f"max must not be smaller than min (got {self.max:g} and {self.min:g})")
        if (self.of is not None) != (self.kind == "choice"):
            raise ValueError("`of` is missing: the words to choose from" if self.of is None else "of goes with choice")
        return self


class Prefab(Model):
    """A body with parameters, or several.

    Inside it `${…}` knows its own parameters and what varies from copy to copy (`i`, `n`, `u`, `row`, `column`,
    `layer`), and nothing of the case.
    """

    doc: str = Field(default="", max_length=4000)
    """What it is, and where its origin is."""
    params: dict[Name, PrefabParam] = Field(default_factory=dict, max_length=100)
    """What can be given `with` its use, by name."""
    body: dict[str, Any] | None = None
    """The one body, as in `bodies`."""
    bodies: Annotated[dict[Name, dict[str, Any]], Field(min_length=1, max_length=200)] | None = None
    """Several bodies, by name of the part. In the case they are called `NAME_PART`."""

    @model_validator(mode="after")
    def _one_form(self) -> "Prefab":
        if (self.body is None) == (self.bodies is None):
            raise ValueError("give either body or bodies")
        return self


class PrefabFile(Prefab):
    """A prefab in a file of its own, `prefabs/NAME.yaml`."""

    text2sim: Any
    """Version of the language."""
    prefab: Name
    """Its name, that of the file."""


class Use(Model):
    """A body, or several, from a prefab.

    Whatever else stands here is laid over the prefab's body: `place`, `repeat`, `look`, `material` and so on. Of a
    prefab with several bodies, it goes by the name of the part.
    """

    use: Name
    """Name of the prefab."""
    with_: dict[Name, Any] = Field(default_factory=dict, alias="with")
    """Values of its parameters."""
