"""Descriptions of the models' types, in words for authors of cases."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache, cached_property
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from text2sim.spec_schema.models.base import ByKind, Noun, Supported


@dataclass(frozen=True)
class LanguageSlot:
    """A place in the language: the type that it accepts, with its bounds."""

    base: Any
    """The type without `Annotated` and without None."""
    metadata: tuple[Any, ...] = ()
    discriminator: str | None = None

    @cached_property
    def members(self) -> list["LanguageSlot"]:
        """The alternatives of a union; otherwise the slot itself."""
        if get_origin(self.base) in (Union, UnionType):
            return [slot_of(member) for member in get_args(self.base) if member is not NoneType]
        return [self]

    @cached_property
    def list_of_other(self) -> "LanguageSlot | None":
        """The list in a union of a type and a list of it, where the structure of a value shows which is meant."""
        lists = [member for member in self.members if get_origin(member.base) is list]
        found = (member for member in lists if slot_of(get_args(member.base)[0]) in self.members)
        return next(found, None) if len(self.members) == 2 else None

    @cached_property
    def models(self) -> dict[str, type[BaseModel]]:
        """The models of a union on `kind`, by kind."""
        if self.discriminator is None:
            return {}
        return {kind: member.base for member in self.members for kind in kinds_of(member.base)}

    @cached_property
    def structure(self) -> str:
        """The YAML structure of its values: number, text, boolean, list or mapping."""
        if self.discriminator is not None or is_model(self.base):
            return "mapping"
        origin = get_origin(self.base)
        return "text" if origin is Literal else _STRUCTURES.get(origin or self.base, "anything")


def is_model(base: Any) -> bool:
    """Return whether a type is a model of the language."""
    return isinstance(base, type) and issubclass(base, BaseModel)


_STRUCTURES: dict[Any, str] = {
    bool: "boolean",
    int: "number",
    float: "number",
    str: "text",
    list: "list",
    tuple: "list",
    dict: "mapping",
}


def fits(slot: LanguageSlot, value: object) -> bool:
    """Return whether a value has the YAML structure that a slot accepts, such as a list of numbers for a vector."""
    if slot.structure != structure_of(value):
        return False
    if isinstance(value, list) and value:
        return slot_of(get_args(slot.base)[0]).structure == structure_of(value[0])
    return True


def structure_of(value: object) -> str:
    """Return the YAML structure of a value: number, text, boolean, list, mapping or nothing."""
    return "nothing" if value is None else _STRUCTURES.get(type(value), "anything")


def slot_of(annotation: Any, metadata: Iterable[Any] = ()) -> LanguageSlot:
    """Return the slot of a type hint.

    Args:
        annotation: The type hint.
        metadata: Metadata that pydantic has already extracted from it.
    """
    notes = list(metadata)
    while True:
        discriminator = next((note.key for note in notes if isinstance(note, ByKind)), None)
        if get_origin(annotation) is Annotated:
            annotation, *inner = get_args(annotation)
            for note in inner:
                notes.extend(note.metadata if isinstance(note, FieldInfo) else [note])
        elif get_origin(annotation) in (Union, UnionType) and discriminator is None:
            rest = [member for member in get_args(annotation) if member is not NoneType]
            if len(rest) > 1:
                break
            annotation = rest[0]
        else:
            break
    return LanguageSlot(annotation, tuple(notes), discriminator)


@cache
def fields_of(model: type[BaseModel]) -> dict[str, tuple[str, LanguageSlot]]:
    """Return attribute and slot of a model's fields by their YAML key, in canonical order."""
    fields = {}
    for attribute in _ordered(model):
        field = model.model_fields[attribute]
        key = field.alias or attribute
        fields[key] = (attribute, slot_of(field.annotation, field.metadata))
    return fields


def _ordered(model: type[BaseModel]) -> list[str]:
    """Return the attributes in canonical order: first those that identify it, then its own, then inherited ones."""
    own = [name for layer in model.__mro__ for name in layer.__dict__.get("__annotations__", {})]
    names = dict.fromkeys([*_FIRST, *own])
    return [name for name in names if name in model.model_fields]


_FIRST = ("kind", "of", "event", "measure")


@cache
def kinds_of(model: type[BaseModel]) -> tuple[str, ...]:
    """Return the values of `kind` that denote a model."""
    field = model.model_fields.get("kind")
    return get_args(field.annotation) if field is not None and get_origin(field.annotation) is Literal else ()


def bounds_of(slot: LanguageSlot) -> dict[str, Any]:
    """Return the bounds of a slot: gt, ge, lt, le, multiple_of, pattern, min_length, max_length."""
    bounds: dict[str, Any] = {}
    for note in slot.metadata:
        for name in ("gt", "ge", "lt", "le", "multiple_of", "pattern", "min_length", "max_length"):
            value = getattr(note, name, None)
            if value is not None:
                bounds[name] = value
    return bounds


def supported_range(slot: LanguageSlot) -> Supported | None:
    """Return the range of magnitudes that a slot supports; None if it has none."""
    return next((note for note in slot.metadata if isinstance(note, Supported)), None)


def magnitudes(supported: Supported) -> str:
    """Return a range of magnitudes in words: `from 1e-06 to 1e+06 m`."""
    return f"from {supported.low:g} to {supported.high:g} {supported.unit}".rstrip()


def describe(slot: LanguageSlot) -> str:
    """Return what a slot accepts, in words: `a number greater than 0`, `3 numbers, or one of x, y, z`."""
    if slot.discriminator is not None:
        return f"a mapping with a kind ({', '.join(slot.models)})"
    members = slot.members
    if len(members) > 1:
        parts = list(dict.fromkeys(describe(member) for member in members))
        return ", or ".join([", ".join(parts[:-1]), parts[-1]] if len(parts) > 1 else parts)
    origin, arguments = get_origin(slot.base), get_args(slot.base)
    if origin is Literal:
        words = [str(argument) for argument in arguments]
        return words[0] if len(words) == 1 else f"one of {', '.join(words)}"
    if origin is tuple:
        most = max((slot_of(argument) for argument in arguments), key=lambda item: len(item.members))
        other = [word for member in most.members[1:] for word in get_args(member.base)]
        return f"{len(arguments)} {_plural(slot_of(arguments[0]))}" + (
            f", or `{other[0]}` as the last" if other else ""
        )
    if origin is list:
        return f"a list of {_plural(slot_of(arguments[0]))}"
    if slot.base is bool:
        return "true or false"
    if slot.base in (int, float):
        even = bounds_of(slot).get("multiple_of") == 2
        return ("a number" if slot.base is float else "an even number" if even else "a whole number") + range_of(slot)
    if slot.base is str:
        return noun_of(slot).singular
    return "a mapping"


def range_of(slot: LanguageSlot) -> str:
    """Return the bounds of a number in words, ` greater than 0` or ` from 0 to 1`; empty if there are none."""
    bounds = bounds_of(slot)
    low, high, end = bounds.get("ge"), bounds.get("le"), bounds.get("lt")
    most = f", and less than {end:g}" if end is not None else f", and at most {high:g}" if high is not None else ""
    if "gt" in bounds and (low is None or bounds["gt"] >= low):
        return f" greater than {bounds['gt']:g}{most}"
    if low is not None and end is not None:
        return f" of at least {low:g}{most}"
    if low is not None and high is not None:
        return f" from {low:g} to {high:.12g}"
    if low is not None:
        return f" of at least {low:g}"
    return f" of at most {high:.12g}" if high is not None else ""


def _plural(slot: LanguageSlot) -> str:
    if len(slot.members) > 1 or slot.discriminator is not None:
        return "values"
    if slot.base in (int, float):
        even = bounds_of(slot).get("multiple_of") == 2
        return ("numbers" if slot.base is float else "even numbers" if even else "whole numbers") + range_of(slot)
    if slot.base is str:
        return noun_of(slot).plural
    if get_origin(slot.base) in (tuple, list):
        inner = describe(slot).removeprefix("a list of ")
        return f"lists of {inner}"
    if get_origin(slot.base) is Literal:
        return f"words from {', '.join(str(word) for word in get_args(slot.base))}"
    return "values"


def noun_of(slot: LanguageSlot) -> Noun:
    """Return the noun for the texts of a slot."""
    return next((note for note in slot.metadata if isinstance(note, Noun)), Noun("text", "texts"))


def show(value: object) -> str:
    """Return a value in words, for messages about what was given."""
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        short = value if len(value) <= 40 else value[:37] + "…"
        printable = "".join(c if c.isprintable() else " " for c in short)
        return f"the text '{printable}'"
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, list | tuple):
        return f"a list of {len(value)} items" if len(value) > 1 else "a list of 1 item" if value else "an empty list"
    if isinstance(value, int) and abs(value) >= 10**21:
        return "a whole number of many digits"
    return f"{value:.12g}" if isinstance(value, float) else str(value)
