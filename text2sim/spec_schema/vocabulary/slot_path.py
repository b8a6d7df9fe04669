"""Paths of keys through the language, for changes to a case."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple, get_args, get_origin

from pydantic import BaseModel

from text2sim.spec_schema.errors import nearest, there_are
from text2sim.spec_schema.models.case import Case
from text2sim.spec_schema.paths import dotted
from text2sim.spec_schema.text.document import Path
from text2sim.spec_schema.vocabulary.slots import ENTRY
from text2sim.spec_schema.vocabulary.words import LanguageSlot, fields_of, is_model, show, slot_of

ROOTS = ("prompt", "params", "prefabs", "scene", "bodies", "actions", "render", "waive")
"""Keys of a case that can be changed."""


class PrefabInterface(NamedTuple):
    """The part of a prefab that can be changed where it is used."""

    kind: str | None = None
    """Kind of its only body, if known."""
    parts: tuple[str, ...] = ()
    """Names of its bodies, if there are several."""


PrefabInterfaces = Callable[[Any], PrefabInterface]
"""Returns the interface of a prefab by name."""


class NoSuchSlot(Exception):
    """A path to something that the language does not have.

    Attributes:
        step: Index of the first invalid step.
        hint: The nearest valid word.
    """

    def __init__(self, step: int, message: str, hint: str | None = None) -> None:
        super().__init__(message)
        self.step = step
        self.hint = hint


@dataclass
class MappingSlots:
    """Slots of the entries that a mapping can have."""

    fields: dict[str, list[LanguageSlot]] = field(default_factory=dict)
    """Slots by key, if the language defines the keys."""
    names: list[LanguageSlot] = field(default_factory=list)
    """Slots under any name."""
    anything: bool = False
    """Whether nothing is known about it."""
    models: list[type[BaseModel]] = field(default_factory=list)
    """Models that the mapping can have."""

    def inner(self, key: str) -> list[LanguageSlot] | None:
        """Return the slots under a key; None if the key is invalid."""
        if key in self.fields:
            return self.fields[key]
        return self.names or ([] if self.anything else None)


def mapping_slots(
    slots: list[LanguageSlot],
    values: list[Any],
    path: Path,
    interfaces: PrefabInterfaces = lambda use: PrefabInterface(),
) -> MappingSlots:
    """Return the slots of a mapping at a path.

    Args:
        slots: Slots of the language at this path.
        values: Values at this path, in the case and in changes to it.
        path: The path.
        interfaces: Interfaces of prefabs.
    """
    found = MappingSlots(anything=not slots)
    uses = [value["use"] for value in values if isinstance(value, dict) and "use" in value] if is_entry(path) else []
    used = [interfaces(use) for use in uses]
    if not any(interface.parts for interface in used):
        kinds = [{"kind": interface.kind} for interface in used]
        for slot in slots:
            _open(slot, [*values, *kinds], found)
    if uses:
        found.fields = {"use": [], "with": [], **found.fields}
    for interface in used:
        found.fields |= {part: [ENTRY] for part in interface.parts}
    return found


def is_entry(path: Path) -> bool:
    """Return whether a path leads to a body or static, which may use a prefab."""
    return (len(path) == 2 and path[0] == "bodies") or (len(path) == 3 and path[:2] == ("scene", "statics"))


def _open(slot: LanguageSlot, values: list[Any], found: MappingSlots) -> None:
    if slot.discriminator is not None:
        kinds = [v.get("kind") for v in values if isinstance(v, dict)]
        models = [slot.models[kind] for kind in kinds if isinstance(kind, str) and kind in slot.models]
        for model in dict.fromkeys(models or slot.models.values()):
            _open_model(model, found)
        if not models:
            found.fields.setdefault("kind", [])
    elif len(slot.members) > 1:
        for member in slot.members:
            if member.structure == "mapping":
                _open(member, values, found)
    elif is_model(slot.base):
        _open_model(slot.base, found)
    elif get_origin(slot.base) is dict:
        found.names.append(slot_of(get_args(slot.base)[1]))
    elif slot.base is Any:
        found.anything = True


def _open_model(model: type[BaseModel], found: MappingSlots) -> None:
    found.models.append(model)
    for key, (_, slot) in fields_of(model).items():
        found.fields.setdefault(key, []).append(slot)


def items_of(slots: list[LanguageSlot]) -> list[LanguageSlot]:
    """Return the slots of the items of a list."""
    members = (member for slot in slots for member in slot.members)
    return [slot_of(get_args(member.base)[0]) for member in members if get_origin(member.base) in (list, tuple)]


def check_path(data: Any, path: Path, interfaces: PrefabInterfaces, *, new: bool) -> None:
    """Check that the value at a path can be set.

    Args:
        data: The case.
        path: The path.
        interfaces: Interfaces of prefabs.
        new: Whether the value to be set is a mapping, which may have a new name.

    Raises:
        NoSuchSlot: If it cannot be set.
    """
    slots, value, missing = [slot_of(Case)], data, False
    for index, step in enumerate(path):
        here = f"`{dotted(path[:index])}`" if index else "a case"
        if isinstance(value, str) and "${" in value:
            raise NoSuchSlot(
                index, f"{here} is the expression `{value[:60]}`: set the whole value, or the parameters in it"
            )
        if isinstance(step, int):
            _check_item(value, step, index, here, missing)
            assert isinstance(value, list)
            slots, value = items_of(slots), value[step]
            continue
        if isinstance(value, list):
            most = f" to {here.strip('`')}[{len(value) - 1}]" if len(value) > 1 else ""
            raise NoSuchSlot(index, f"{here} is a list; its items are {here.strip('`')}[0]{most}")
        if value is not None and not isinstance(value, dict):
            raise NoSuchSlot(index, f"{here} is {show(value)}, which has no keys")
        found = mapping_slots(slots, [value], path[:index], interfaces)
        inner = found.inner(step)
        known: list[str] = list(value or ()) if found.names and not found.fields else list(found.fields)
        if index == 0:
            known = [*ROOTS]
            inner = inner if step in ROOTS else None
        if inner is None or (found.names and step not in (value or {}) and not _may_be_new(path, index, new)):
            named = bool(found.names) and index > 0
            message = _of_prefab(step, value, path[:index], interfaces) or _unknown_step(step, here, known, named)
            raise NoSuchSlot(index, message, nearest(step, known))
        missing = not isinstance(value, dict) or step not in value
        slots, value = inner, value[step] if isinstance(value, dict) and not missing else None


def _may_be_new(path: Path, index: int, new: bool) -> bool:
    return path[0] != "params" and index == len(path) - 1 and (new or path[0] == "waive")


def _of_prefab(step: str, value: Any, path: Path, interfaces: PrefabInterfaces) -> str | None:
    """Return the message about a name that a body only gets when prefabs are expanded; None for other names."""
    for name, entry in value.items() if path == ("bodies",) and isinstance(value, dict) else ():
        if isinstance(entry, dict) and step.startswith(f"{name}_"):
            part = step.removeprefix(f"{name}_")
            if part in interfaces(entry.get("use")).parts:
                return f"`{step}` is created by the prefab of `{name}`: use `bodies.{name}.{part}`"
    return None


def _unknown_step(step: str, here: str, known: list[str], named: bool) -> str:
    if here == "a case":
        return f"`{step}` cannot be changed, only {', '.join(known)}; a parameter is `params.{step}`"
    if named:
        return f"there is no `{step}` in {here}{there_are(known, 40)}"
    return f"unknown key `{step}`; {here} takes {', '.join(known)}"


def _check_item(value: Any, step: int, index: int, here: str, missing: bool) -> None:
    if missing or value is None:
        raise NoSuchSlot(index, f"{here} is not set in the case: set the whole value")
    if not isinstance(value, list):
        raise NoSuchSlot(index, f"{here} is {show(value)}, not a list")
    if step >= len(value):
        last = f"{here.strip('`')}[{len(value) - 1}]"
        raise NoSuchSlot(index, f"{here} has {len(value)} items, the last is {last}" if value else f"{here} is empty")
