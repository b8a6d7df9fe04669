"""Prefabs as written in a case or file: bodies with parameters."""

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
    """Kind of its values: `number`, `integer`, `length` [m] (greater than 0), `angle_deg` [deg], `vec2`, `vec3`,
    `text`, `color`, `bool`, `choice`, `body` (a selector)."""
    default: Any = None
    """Default value, which may be an expression of the other parameters; without one the parameter is required."""
    min: Real | None = None
    """Smallest number, or smallest item of a vector."""
    max: Real | None = None
    """Largest number, or largest item of a vector."""
    of: Annotated[list[Annotated[str, Field(max_length=100)]], Field(min_length=1, max_length=100)] | None = None
    """With `choice`: the words to choose from."""
    doc: str = Field(default="", max_length=2000)
    """Its purpose."""

    @model_validator(mode="after")
    def _fitting(self) -> "PrefabParam":
        if self.kind not in NUMERIC and (self.min is not None or self.max is not None):
            raise ValueError(f"min and max need one of the kinds {', '.join(NUMERIC)} (got {self.kind})")
        if self.min is not None and self.max is not None and self.max < self.min:
            raise ValueError(f"max must not be smaller than min (got {self.max:g} and {self.min:g})")
        if (self.of is not None) != (self.kind == "choice"):
            raise ValueError("choice needs `of`, the words to choose from" if self.of is None else "of needs choice")
        return self


class Prefab(Model):
    """A body with parameters, or several.

    Inside it, `${…}` can use its own parameters and the variables of copies (`i`, `n`, `u`, `row`, `column`, `layer`),
    but nothing of the case.
    """

    doc: str = Field(default="", max_length=4000)
    """What it is, and where its origin is."""
    params: dict[Name, PrefabParam] = Field(default_factory=dict, max_length=100)
    """Parameters by name, which `with` sets where it is used."""
    body: dict[str, Any] | None = None
    """The one body, as in `bodies`."""
    bodies: Annotated[dict[Name, dict[str, Any]], Field(min_length=1, max_length=200)] | None = None
    """Several bodies, by name of the part. Their names in the case are `NAME_PART`."""

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
    """Its name, equal to that of the file."""


class Use(Model):
    """A body, or several, from a prefab.

    All other keys override those of the prefab's body: `place`, `repeat`, `look`, `material` and so on. For a prefab
    with several bodies they are given under the name of the part.
    """

    use: Name
    """Name of the prefab."""
    with_: dict[Name, Any] = Field(default_factory=dict, alias="with")
    """Values of its parameters."""
