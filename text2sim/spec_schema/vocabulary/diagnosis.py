"""Diagnosis of the validator's findings, in the words of the language and at the place in the file."""

import re
from dataclasses import dataclass
from typing import Any, get_args, get_origin
from unicodedata import name

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from text2sim.spec_schema.errors import Problem, nearest
from text2sim.spec_schema.models.base import Name
from text2sim.spec_schema.text.document import Document, Path, Step
from text2sim.spec_schema.text.syntax import LOOK_ALIKE, taken_for_text
from text2sim.spec_schema.vocabulary.words import (
    LanguageSlot,
    bounds_of,
    carried_by,
    describe,
    fields_of,
    fits,
    is_model,
    kinds_of,
    magnitudes,
    noun_of,
    range_of,
    show,
    slot_of,
    structure_of,
)

MOST = 10_000
"""Errors of one validation that are put into words: nobody reads more, and 100,000 take ten seconds."""


def diagnose(
    document: Document, error: ValidationError, model: type[BaseModel], data: Any, root: Path = ()
) -> list[Problem]:
    """Turn the errors of one validation into located problems.

    Args:
        document: Where positions come from.
        error: What pydantic raised.
        model: The model that was validated.
        data: The value that was validated, with its expressions evaluated.
        root: Path of that value in the document.

    Returns:
        Each problem once; a value that fits no alternative of a union is one problem.
    """
    found: dict[Problem, None] = {}
    errors = error.errors(include_url=False)
    for details in errors[:MOST]:
        place = _follow(slot_of(model), data, list(details["loc"]), details["type"])
        if place is not None:
            finding = _say(place, details)
            path = (*root, *finding.path)
            found[document.problem(path, finding.message, key=finding.key, rule=finding.rule, hint=finding.hint)] = None
    if len(errors) > MOST:
        text = f"{len(errors) - MOST:,} more values are wrong"
        found[document.problem(root, text, rule="value")] = None
    # Whatever the above cannot follow is still said, if not as well.
    return list(found) or [document.problem(root, _plainly(error), rule="value")]


def _plainly(error: ValidationError) -> str:
    details = error.errors(include_url=False)[0]
    return f"{'.'.join(map(str, details['loc']))}: {details['msg']}"


@dataclass
class _Place:
    """Where an error leads: the value that it is about, and what the language takes there."""

    path: Path
    slot: LanguageSlot
    data: Any
    rest: list[Step]
    """Steps that lead to something that is not there: a missing or unknown key, a missing item."""
    alternatives: bool = False
    """The value fits no alternative of a union, and which one was meant cannot be told."""


def _follow(slot: LanguageSlot, data: Any, loc: list[Step], kind: str) -> _Place | None:
    """Walk along an error's location; None if it is about an alternative that was not meant."""
    path: Path = ()
    while True:
        if loc[:1] == ["[key]"]:
            return _Place(path, slot, data, loc)
        if slot.discriminator is not None and loc:
            slot = slot_of(slot.models[str(loc.pop(0))])
        elif slot.discriminator is None and len(slot.members) > 1:
            fitting = [member for member in slot.members if fits(member, data)]
            # Of several lists, the one that is as long was meant.
            fitting = [member for member in fitting if _is_as_long(member, data)] or fitting
            if len(fitting) != 1:
                return _Place(path, slot, data, [], alternatives=True)
            if not loc or not _is_label_of(str(loc.pop(0)), fitting[0]):
                return None
            if not loc and kind in ("literal_error", "string_pattern_mismatch"):
                return _Place(path, slot, data, [], alternatives=True)
            slot = fitting[0]
            continue
        if not loc:
            return _Place(path, slot, data, loc)
        inner = _inside(slot, loc[0])
        if inner is None or not _has(data, loc[0]):
            return _Place(path, slot, data, loc)
        step = loc.pop(0)
        slot, data, path = inner, data[step], (*path, step)


def _is_as_long(slot: LanguageSlot, data: Any) -> bool:
    return get_origin(slot.base) is tuple and isinstance(data, list) and len(get_args(slot.base)) == len(data)


def _inside(slot: LanguageSlot, step: Step) -> LanguageSlot | None:
    base = slot.base
    if is_model(base):
        field = fields_of(base).get(str(step))
        return field[1] if field is not None else None
    arguments = get_args(base)
    if get_origin(base) is dict:
        return slot_of(arguments[1])
    if get_origin(base) is list:
        return slot_of(arguments[0])
    if get_origin(base) is tuple and isinstance(step, int) and step < len(arguments):
        return slot_of(arguments[step])
    return None


def _has(data: Any, step: Step) -> bool:
    return (
        step in data
        if isinstance(data, dict)
        else isinstance(data, list) and isinstance(step, int) and step < len(data)
    )


_FUNCTION = re.compile(r"^function-\w+\[.*?\(\), ")
_LABELS = (
    (("tagged-union", "dict", "model"), "mapping"),
    (("literal", "str", "constrained-str"), "text"),
    (("float", "int", "constrained-float", "constrained-int"), "number"),
    (("bool",), "boolean"),
    (("tuple", "list"), "list"),
)


def _is_label_of(label: str, slot: LanguageSlot) -> bool:
    """Whether pydantic's name for an alternative of a union is that of a slot."""
    while found := _FUNCTION.match(label):
        label = label[found.end() :]
    origin = get_origin(slot.base)
    if origin is tuple and "(" not in label and label.count(",") + 1 != len(get_args(slot.base)):
        return False
    if origin in (tuple, list):
        return label.startswith(origin.__name__)
    return slot.structure == next((what for starts, what in _LABELS if label.startswith(starts)), "mapping")


# --- words
# ----------------------------------------------------------------------------------------------------


@dataclass
class _Finding:
    path: Path
    message: str
    rule: str
    hint: str | None = None
    key: bool = False


def _say(place: _Place, details: ErrorDetails) -> _Finding:
    kind, slot, data = details["type"], place.slot, place.data
    if place.rest == ["[key]"]:
        return _bad_name(place)
    if place.alternatives:
        return _no_alternative(place)
    if kind == "extra_forbidden":
        return _unknown_key(place)
    if kind in ("union_tag_not_found", "union_tag_invalid"):
        return _bad_kind(place)
    if kind in ("missing", "too_long", "too_short") and get_origin(slot.base) is tuple:
        message = f"needs {describe(slot)} (got {len(data)})"
        return _Finding(place.path, message, "length")
    if kind == "missing":
        return _missing_key(place)
    if kind == "value_error":
        context = details.get("ctx", {})
        error = context.get("error", details["msg"])
        rule, hint = getattr(error, "rule", "inconsistent"), getattr(error, "hint", None)
        return _Finding(place.path, str(error), rule, hint, key=is_model(slot.base))
    if kind == "literal_error":
        return _unknown_word(place)
    if kind == "string_pattern_mismatch":
        return _bad_text(place)
    if kind in ("too_short", "too_long"):
        return _bad_length(place, details)
    if kind == "string_too_long":
        most = bounds_of(slot).get("max_length", "")
        return _Finding(place.path, f"the text is longer than {most} characters", "length")
    if kind == "string_too_short":
        least = bounds_of(slot).get("min_length", "")
        return _Finding(place.path, f"the text must have at least {least} characters (got {len(data)})", "length")
    if kind in ("greater_than", "greater_than_equal", "less_than", "less_than_equal"):
        return _Finding(place.path, f"must be{_range(slot, data).removeprefix(' of')} (got {show(data)})", "range")
    if isinstance(data, bool) and slot.structure == "number":
        return _Finding(place.path, f"needs {describe(slot)}; {show(data)} is not a number", "type")
    message = f"needs {describe(slot)} (got {_given(data, slot)}){_meant(data, slot)}"
    return _Finding(place.path, message, "type", key=data is None)


def _range(slot: LanguageSlot, data: Any) -> str:
    """The bounds that a number breaks: those of the field, or those of what can be carried at all."""
    carried = carried_by(slot)
    if carried is None or data <= 0 or carried.low <= data <= carried.high:
        return range_of(slot)
    return f" {magnitudes(carried)}"


def _unknown_key(place: _Place) -> _Finding:
    key, model = str(place.rest[0]), place.slot.base
    known = [word for word in fields_of(model) if word != "kind" or kinds_of(model)]
    free = [word for word in known if word not in place.data]
    message = f"unknown key `{key}`; {_name_of(place)} takes {', '.join(known)}{_strange(key)}"
    if _NUMBER.fullmatch(key):
        message += "; decimals have a point, and numbers that belong together stand in brackets: [0, 0.5, 1]"
    elif ":" in key and key.split(":")[0] in known:
        message += "; a space is missing behind the colon"
    elif key in _WITHIN and _WITHIN[key] in known:
        message += f"; `{key}` stands in `{_WITHIN[key]}`"
    elif key in _ELSEWHERE and {"look", "place"} <= set(known) and nearest(key, free) is None:
        return _Finding((*place.path, key), f"{message}; {_ELSEWHERE[key]}", "unknown-key", key=True)
    elif OTHER_KEYS.get(key) in free:
        return _Finding((*place.path, key), message, "unknown-key", OTHER_KEYS[key], key=True)
    return _Finding((*place.path, key), message, "unknown-key", nearest(key, free) or nearest(key, known), key=True)


_WITHIN = {
    **dict.fromkeys(("mass", "density", "friction", "restitution"), "material"),
    **dict.fromkeys(("pos", "position", "quat", "euler_deg", "rotation", "orientation"), "pose"),
    **dict.fromkeys(("color", "colour", "finish", "opacity"), "look"),
    **dict.fromkeys(("radius", "size"), "shape"),
}
"""Keys of a body as they are often written one level too high."""
_ELSEWHERE = {
    **dict.fromkeys(
        ("pin", "pins", "pinned", "fixed_points", "fixed_vertices", "anchor", "anchors", "attach", "attached"),
        "`kind: attach` in `actions.controls` holds a body, or a region of it",
    ),
    **dict.fromkeys(
        ("velocity", "speed", "initial_velocity", "linear_velocity", "angular_velocity"),
        "`kind: initial_velocity` in `actions.controls` lets it start with a speed",
    ),
    **dict.fromkeys(
        ("force", "forces", "impulse", "push", "torque"), "what pushes a body stands in `actions.controls`"
    ),
    **dict.fromkeys(("fixed", "static"), "what never moves stands in `scene.statics`"),
}
"""Keys that others give to bodies, and where that stands here."""
OTHER_KEYS = {
    **dict.fromkeys(("width", "widths", "dimensions", "dims", "extents", "scale"), "size"),
    **dict.fromkeys(("position", "location", "translation", "xyz", "origin"), "pos"),
    **dict.fromkeys(("rotation", "orientation", "rpy", "euler"), "euler_deg"),
    **dict.fromkeys(("quaternion", "rot"), "quat"),
    **dict.fromkeys(("colour", "rgb", "rgba"), "color"),
    **dict.fromkeys(("type", "class"), "kind"),
    **dict.fromkeys(("timestep", "time_step", "delta_t"), "dt"),
    **dict.fromkeys(("weight",), "mass"),
    **dict.fromkeys(("bounce", "elasticity"), "restitution"),
}
"""Keys as others call them."""


def _missing_key(place: _Place) -> _Finding:
    key, model = str(place.rest[0]), place.slot.base
    message = f"`{key}` is missing: {_name_of(place)} needs it ({describe(fields_of(model)[key][1])})"
    return _Finding(place.path, message, "missing", key=True)


def _name_of(place: _Place) -> str:
    kinds = kinds_of(place.slot.base)
    if kinds and isinstance(place.data, dict):
        return f"`kind: {place.data.get('kind', kinds[0])}`"
    named = next((str(step) for step in reversed(place.path) if isinstance(step, str)), "")
    return f"`{named}`" if named else _ROOTS.get(place.slot.base.__name__, "a case")


_ROOTS = {"PrefabFile": "a prefab", "Prefab": "a prefab", "Sweep": "a sweep"}


OTHER_WORDS = {
    **dict.fromkeys(("sand", "grain", "grains", "gravel", "powder", "particles"), "granular"),
    **dict.fromkeys(("fluid", "water", "oil", "honey"), "liquid"),
    **dict.fromkeys(("fabric", "textile", "towel", "curtain"), "cloth"),
    **dict.fromkeys(("deformable", "jelly", "rubber", "foam", "elastic", "softbody", "soft_body"), "soft"),
    **dict.fromkeys(("cable", "cord", "string", "thread"), "rope"),
    **dict.fromkeys(("kinematic", "scripted", "animated"), "driven"),
    **dict.fromkeys(("robot", "mechanism", "urdf", "mjcf"), "articulated"),
    **dict.fromkeys(("dynamic", "free_body", "rigidbody", "rigid_body"), "rigid"),
    **dict.fromkeys(("cube", "cuboid", "block"), "box"),
    **dict.fromkeys(("rod", "disc", "disk"), "cylinder"),
    **dict.fromkeys(("ball",), "sphere"),
    **dict.fromkeys(("revolute", "rotary"), "hinge"),
    **dict.fromkeys(("prismatic", "linear"), "slider"),
    **dict.fromkeys(("pin", "weld", "constraint", "grasp"), "attach"),
}
"""Kinds as others call them; where there is no such kind, the nearest word is the hint."""


def _bad_kind(place: _Place) -> _Finding:
    kinds = list(place.slot.models)
    if "kind" not in place.data:
        return _Finding(place.path, f"`kind` is missing: one of {', '.join(kinds)}", "missing-kind", key=True)
    kind = place.data["kind"]
    message = f"unknown kind {_quoted(kind)}; there are {', '.join(kinds)}"
    if kind == "plane":
        message += "; only a static can be a plane"
    if kind == "sheet":
        message += "; only a cloth can be a sheet"
    meant = OTHER_WORDS.get(kind.lower()) if isinstance(kind, str) else None
    hint = meant if meant in kinds else None if kind in ("plane", "sheet") else nearest(kind, kinds)
    return _Finding((*place.path, "kind"), message, "unknown-kind", hint)


def _unknown_word(place: _Place) -> _Finding:
    words = [str(word) for word in get_args(place.slot.base)]
    message = f"must be {describe(place.slot)} (got {_quoted(place.data)})"
    return _Finding(place.path, message, "unknown-word", nearest(place.data, words))


def _no_alternative(place: _Place) -> _Finding:
    words = [
        str(w)
        for m in place.slot.members
        if get_origin(m.base) is not None
        for w in get_args(m.base)
        if isinstance(w, str)
    ]
    message = f"needs {describe(place.slot)} (got {_given(place.data, place.slot)})"
    return _Finding(place.path, message, "type", nearest(place.data, words))


def _given(data: Any, slot: LanguageSlot) -> str:
    """What was given instead: `needs 3 numbers (got 3)` would puzzle."""
    number = structure_of(data) == "number" and slot.structure != "number"
    return f"the number {show(data)}" if number else show(data)


_WITH_UNIT = re.compile(r"[-+]?[\d.]+(e[-+]?\d+)?\s*[a-zA-Z°%/]+[23]?")
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?")


def _meant(data: Any, slot: LanguageSlot) -> str:
    """How a number or a mapping is written, to someone who wrote text instead."""
    if not isinstance(data, str):
        return ""
    if slot.structure == "mapping" and (alike := LOOK_ALIKE.search(data)):
        return f"; {taken_for_text(alike[0])}"
    if slot.structure != "number":
        return ""
    text = data.strip()
    if _NUMBER.fullmatch(text):
        return "; leave out the quotes"
    if _WITH_UNIT.fullmatch(text):
        return "; leave out the unit: all numbers are in SI units, m, kg, s, N and rad, but for `…_deg`"
    if text.startswith("$"):
        return "; an expression is written ${…}"
    words = text.split()
    return "; put commas between numbers" if len(words) > 1 and all(map(_NUMBER.fullmatch, words)) else ""


def _bad_text(place: _Place) -> _Finding:
    noun = noun_of(place.slot)
    return _Finding(place.path, f"{_quoted(place.data)} is not {noun.one}: {noun.form}", "form")


def _bad_name(place: _Place) -> _Finding:
    word = str(place.path[-1])
    message = f"{_quoted(word)} is not a name: {noun_of(slot_of(Name)).form}"
    return _Finding(place.path, message + _strange(word), "form", key=True)


def _strange(word: str) -> str:
    """Call the first letter that only looks like one of ours by its name."""
    found = next((c for c in word if not c.isascii()), None)
    return "" if found is None else f"; `{found}` is {name(found, 'no letter')}"


def _bad_length(place: _Place, details: ErrorDetails) -> _Finding:
    context = details.get("ctx", {})
    least, most = context.get("min_length"), context.get("max_length")
    wanted = f"at least {least}" if details["type"] == "too_short" else f"at most {most}"
    return _Finding(place.path, f"needs {wanted} of them (got {len(place.data)})", "length", key=True)


def _quoted(value: object) -> str:
    return f"`{show(value).removeprefix('the text ').strip(chr(39))}`" if isinstance(value, str) else show(value)
