"""Slots of the language by key, in canonical order, also for overlays."""

from functools import cache

from pydantic import BaseModel

from text2sim.spec_schema.models.base import Name
from text2sim.spec_schema.models.bodies import Body
from text2sim.spec_schema.models.case import Case
from text2sim.spec_schema.models.prefab_models import Prefab, PrefabFile, Use
from text2sim.spec_schema.models.scene import Static
from text2sim.spec_schema.models.sweep_models import Sweep
from text2sim.spec_schema.vocabulary.words import LanguageSlot, fields_of, is_model, slot_of

ENTRY = slot_of(Body)
"""The slot of an entry of `bodies`."""

_CONTENT: dict[tuple[type[BaseModel], str], LanguageSlot] = {
    (Case, "prefabs"): slot_of(dict[Name, Prefab]),
    (Case, "variants"): slot_of(dict[Name, Case]),
    (Case, "sweeps"): slot_of(dict[Name, Sweep]),
    (Prefab, "body"): ENTRY,
    (Prefab, "bodies"): slot_of(dict[Name, Body]),
    (PrefabFile, "body"): ENTRY,
    (PrefabFile, "bodies"): slot_of(dict[Name, Body]),
    (Sweep, "points"): slot_of(dict[Name, Case]),
}
"""Content of fields whose values are typed `Any` in their model, because they are checked elsewhere."""


def content_slot(model: type[BaseModel], key: str, slot: LanguageSlot) -> LanguageSlot:
    """Return the slot of a field's actual content, which may be narrower than its type.

    Args:
        model: The model.
        key: Name of the field in YAML.
        slot: The slot of its type.
    """
    return _CONTENT.get((model, key), slot)


def slots_by_key(slot: LanguageSlot | None) -> dict[str, LanguageSlot]:
    """Return the slot under each key of a mapping, in canonical order; empty if the keys are names.

    Args:
        slot: A model, or a union of models, all of which are considered.
    """
    if slot is None:
        return {}
    if slot.discriminator is not None:
        models = tuple(dict.fromkeys(slot.models.values()))
        return _merged((Use, *models) if slot == ENTRY else models)
    if slot.base is Static:
        return _merged((Use, Static))
    return _merged((slot.base,)) if is_model(slot.base) else {}


@cache
def _merged(models: tuple[type[BaseModel], ...]) -> dict[str, LanguageSlot]:
    found: dict[str, LanguageSlot] = {}
    for model in models:
        for key, (_, slot) in fields_of(model).items():
            found.setdefault(key, content_slot(model, key, slot))
    return found
