"""Labels of pydantic for the alternatives of a union, in the places of its errors."""

import re
from typing import get_args, get_origin

from text2sim.spec_schema.vocabulary.words import LanguageSlot

_FUNCTION = re.compile(r"^function-\w+\[.*?\(\), ")
_LABELS = (
    (("tagged-union", "dict", "model"), "mapping"),
    (("literal", "str", "constrained-str"), "text"),
    (("float", "int", "constrained-float", "constrained-int"), "number"),
    (("bool",), "boolean"),
    (("tuple", "list"), "list"),
)


def is_label_of(label: str, slot: LanguageSlot) -> bool:
    """Return whether a label denotes a slot.

    Args:
        label: What pydantic calls an alternative in the place of an error, such as `tuple[float,float]`.
        slot: The alternative.
    """
    while found := _FUNCTION.match(label):
        label = label[found.end() :]
    origin = get_origin(slot.base)
    if origin is tuple and _count_items(label) != len(get_args(slot.base)):
        return False
    if origin in (tuple, list):
        return label.startswith(origin.__name__)
    return slot.structure == next((what for starts, what in _LABELS if label.startswith(starts)), "mapping")


def _count_items(label: str) -> int:
    """Return how many items the outer brackets of a label hold: 2 of `tuple[float,union[float,str]]`."""
    depth, commas = 0, 0
    for char in label:
        depth += (char == "[") - (char == "]")
        commas += char == "," and depth == 1
    return commas + 1
