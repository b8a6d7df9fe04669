"""Names of bodies in the selectors of a prefab: `rod` there becomes `left_rod` in the case."""

import re
from collections.abc import Mapping
from typing import get_args, get_origin

from text2sim.spec_schema.models.base import Selector
from text2sim.spec_schema.reuse.trees import LocatedValue, mapping
from text2sim.spec_schema.vocabulary.slot_path import mapping_slots
from text2sim.spec_schema.vocabulary.slots import ENTRY
from text2sim.spec_schema.vocabulary.words import LanguageSlot, noun_of, slot_of

_NOUN = noun_of(slot_of(Selector))
_FIRST = re.compile(r"[A-Za-z][A-Za-z0-9_]*(?=$|[.\[])")


def renamed(body: LocatedValue, names: Mapping[str, str]) -> LocatedValue:
    """Return a body of a prefab with the names of the case in its selectors.

    Args:
        body: The body.
        names: Name in the case by name in the prefab.
    """
    return _renamed(body, [ENTRY], names)


def _renamed(tree: LocatedValue, slots: list[LanguageSlot], names: Mapping[str, str]) -> LocatedValue:
    data = tree.data
    if isinstance(data, dict):
        found = mapping_slots(slots, [data], ())
        inner = {key: found.inner(key) or [] for key in data}
        if not any(inner.values()):
            return tree
        return mapping(tree.node, {key: _renamed(tree.child(key), inner[key], names) for key in data})
    if isinstance(data, str) and any(_takes_selector(slot) for slot in slots):
        first = _FIRST.match(data)
        if first is not None and first[0] in names:
            return LocatedValue(names[first[0]] + data[first.end() :], tree.node)
    return tree


def _takes_selector(slot: LanguageSlot) -> bool:
    return any(
        noun_of(member) == _NOUN
        or (get_origin(member.base) is list and _takes_selector(slot_of(get_args(member.base)[0])))
        for member in slot.members
    )
