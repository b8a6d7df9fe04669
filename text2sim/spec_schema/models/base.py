"""Base of all models, with types and units that all sections share.

Units are SI; angles are in radians except in fields whose name ends in `deg`; quaternions are (w, x, y, z); z points
up.
"""

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any, Literal, get_args

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    StrictBool,
    StrictInt,
    StringConstraints,
    model_validator,
)
from pydantic_core import core_schema

from text2sim.spec_schema.arithmetic.values import MAX_NUMBER


@dataclass(frozen=True)
class Noun:
    """Name of a kind of text in messages."""

    singular: str
    """With its article."""
    plural: str
    form: str = ""
    """Its form."""


class Model(BaseModel):
    """A mapping of the language: closed (unknown keys are errors), immutable and finite.

    The validator of a class is built when it is first needed, and that of `Case` has all others in it: a check builds
    no other. So defaults are made by `model_construct`, and `content_of` serves where only equality matters.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, populate_by_name=True, defer_build=True)


class ByKind:
    """Marker of a union that is discriminated by `kind`.

    The validator of a model is built when a case has that kind: building all takes a quarter of a `check`.
    """

    key = "kind"

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        choices: dict[Hashable, core_schema.CoreSchema] = {}
        for model in get_args(source):
            validate = partial(model.model_validate, by_alias=True, by_name=False)
            schema = core_schema.no_info_plain_validator_function(validate)
            choices |= dict.fromkeys(get_args(model.model_fields[self.key].annotation), schema)
        return core_schema.tagged_union_schema(choices, self.key)


def content_of(value: Any) -> Any:
    """Return the content of a model, hashable and comparable."""
    if isinstance(value, BaseModel):
        return (type(value), *(content_of(item) for _, item in value))
    if isinstance(value, dict):
        return tuple((key, content_of(item)) for key, item in value.items())
    return tuple(content_of(item) for item in value) if isinstance(value, list | tuple) else value


@dataclass(frozen=True)
class Supported:
    """Magnitudes that arithmetic and the engine support; the lint reports implausible ones."""

    low: float
    high: float
    unit: str = ""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> Any:
        schema: Any = handler(source)
        # Not with `Field`: pydantic keeps only one of two bounds of a field.
        return schema | {"ge": max(self.low, schema.get("ge", 0)), "le": min(self.high, schema.get("le", self.high))}


Real = Annotated[float, Field(strict=True, allow_inf_nan=False)]
"""A finite number; booleans are not numbers."""
Positive = Annotated[Real, Field(gt=0), Supported(1e-15, MAX_NUMBER)]
NonNegative = Annotated[Real, Field(ge=0)]
Length = Annotated[Real, Field(gt=0), Supported(1e-6, 1e6, "m")]
"""A length [m]: the engine builds nothing smaller than a micrometre, and resolves nothing on more than 1000 km."""
Mass = Annotated[Real, Field(gt=0), Supported(1e-12, 1e12, "kg")]
"""A mass [kg]."""
Density = Annotated[Real, Field(gt=0), Supported(1e-6, 1e9, "kg/m3")]
"""A density [kg/m3]."""
Fraction = Annotated[Real, Field(ge=0, le=1)]
Seconds = NonNegative
Integer = StrictInt
Count = Annotated[StrictInt, Field(ge=1, le=100_000)]
MAX_MULTIPLE = 500
Multiple = Annotated[StrictInt, Field(ge=1, le=MAX_MULTIPLE)]
"""Number of entries from one with `repeat`."""
Bool = StrictBool


def _nonzero(value: tuple[float, ...]) -> tuple[float, ...]:
    if math.hypot(*value) < 1e-9:
        raise ValueError("must not be zero: it has no direction")
    return value


def _ordered(value: tuple[float, float | str]) -> tuple[float, float | str]:
    if not isinstance(value[1], str) and value[1] < value[0]:
        raise ValueError(f"the second number must not be smaller than the first (got {value[0]:g} and {value[1]:g})")
    return value


Vec2 = tuple[Real, Real]
Vec3 = tuple[Real, Real, Real]
Direction = Annotated[Vec3, AfterValidator(_nonzero)]
"""A nonzero vector; normalised when it is resolved."""
Size2 = tuple[Length, Length]
Size3 = tuple[Length, Length, Length]
Quat = Annotated[tuple[Real, Real, Real, Real], AfterValidator(_nonzero)]
"""Orientation (w, x, y, z); normalised when it is resolved."""
Window = Annotated[tuple[Seconds, Seconds | Literal["end"]], AfterValidator(_ordered)]
"""A span of simulated time [s], (from, to); `end` is the end of the run."""
Range = Annotated[tuple[Real, Real], AfterValidator(_ordered)]
"""Lower and upper limit."""


def span_of(window: tuple[float, float | str] | None, end: float) -> tuple[float, float]:
    """Return the start and end [s] of a window; those of the run without a window.

    Args:
        window: Start and end, which may be `end`.
        end: End of the run [s].
    """
    first, last = window or (0.0, end)
    return first, end if isinstance(last, str) else last


Name = Annotated[
    str,
    StringConstraints(pattern=r"^[A-Za-z][A-Za-z0-9_]{0,47}$"),
    Noun("a name", "names", "a letter, then letters, digits or _, at most 48 in all"),
]
"""A letter, then letters, digits or underscores: 48 characters at most."""

Names = Annotated[
    str,
    StringConstraints(pattern=r"^[A-Za-z*][A-Za-z0-9_*]{0,47}$"),
    Noun("a name or pattern", "names or patterns", "letters, digits or _, and * for any of them, at most 48 in all"),
]
"""A name, or a pattern of names with `*` for any letters."""

Selector = Annotated[
    str,
    StringConstraints(
        pattern=r"^[A-Za-z][A-Za-z0-9_]*(\[(\d{1,6}|\*|\d{1,6}:\d{1,6})\])?(\.([A-Za-z]|\*)[A-Za-z0-9_*]{0,47})?$"
    ),
    Noun("a selector", "selectors", "`brick`, `brick[*]`, `brick[3]`, `brick[2:5]`, `arm.hand` or `net.x5_*`"),
]
"""Which bodies: ``brick`` (every copy), ``brick[3]``, ``brick[2:5]`` (2, 3, 4), ``arm.hand`` (a link or
joint), ``net.x5_*`` (all links or joints whose names begin so)."""

Selectors = Selector | Annotated[list[Selector], Field(min_length=1, max_length=50)]
"""A selector, or a list of them: all that they select together, each once."""


def listed(selectors: str | Sequence[str] | None) -> list[str]:
    """Return the different selectors of a field: one, those of a list, or none."""
    if selectors is None:
        return []
    return [selectors] if isinstance(selectors, str) else list(dict.fromkeys(selectors))


AxisName = Literal["x", "y", "z"]
AXES: dict[str, tuple[float, float, float]] = {
    "x": (1.0, 0.0, 0.0),
    "y": (0.0, 1.0, 0.0),
    "z": (0.0, 0.0, 1.0),
}

Axis = Direction | AxisName
"""A direction: ``x``, ``y``, ``z`` or a vector (normalised when it is resolved)."""


def exactly_one_of(*names: str) -> Any:
    """Return a validator of models: exactly one of these fields is given."""

    def check(model: Model) -> Model:
        if sum(getattr(model, name) is not None for name in names) != 1:
            raise ValueError(f"give exactly one of {', '.join(names)}")
        return model

    return model_validator(mode="after")(check)


class Bounds(Model):
    """An axis-aligned box."""

    min: Vec3
    """Lowest corner [m]."""
    max: Vec3
    """Highest corner [m]."""

    @model_validator(mode="after")
    def _not_empty(self) -> "Bounds":
        for axis, low, high in zip("xyz", self.min, self.max, strict=True):
            if high <= low:
                found = f"along {axis}, {high:g} is not larger than {low:g}"
                raise ValueError(f"every coordinate of max must be larger than that of min; {found}")
        return self


class Pose(Model):
    """A position, and at most one form of an orientation."""

    pos: Vec3 = (0.0, 0.0, 0.0)
    """Position [m] of the frame's origin."""
    quat: Quat | None = None
    """Orientation (w, x, y, z)."""
    euler_deg: Vec3 | None = None
    """Orientation [deg]: rotations about the fixed x, then y, then z axis."""

    @model_validator(mode="after")
    def _one_orientation(self) -> "Pose":
        if self.quat is not None and self.euler_deg is not None:
            raise ValueError("give either quat or euler_deg, not both")
        return self
