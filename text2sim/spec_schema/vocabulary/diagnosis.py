"""Diagnosis of validation errors: located messages in the terms of the language."""

import re
from dataclasses import dataclass
from typing import Any, Literal, get_args, get_origin
from unicodedata import name

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from text2sim.spec_schema.errors import Problem, nearest
from text2sim.spec_schema.models.base import Name, Selector
from text2sim.spec_schema.text.document import Document, Path, Step
from text2sim.spec_schema.text.syntax import LOOK_ALIKE, taken_for_text
from text2sim.spec_schema.vocabulary.labels import is_label_of
from text2sim.spec_schema.vocabulary.words import (
    LanguageSlot,
    bounds_of,
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
    supported_range,
)

MAX_ERRORS = 10_000
"""Largest number of reported errors of one validation: nobody reads more, and 100,000 take ten seconds."""


def diagnose(
    document: Document, error: ValidationError, model: type[BaseModel], data: Any, root: Path = ()
) -> list[Problem]:
    """Convert the errors of one validation to located problems.

    Args:
        document: The document, which knows the positions.
        error: The error of pydantic.
        model: The model that was validated.
        data: The value that was validated, with its expressions evaluated.
        root: Path of that value in the document.

    Returns:
        The problems without duplicates; a value that fits no alternative of a union is one problem.
    """
    found: dict[Problem, None] = {}
    errors = error.errors(include_url=False)
    for details in errors[:MAX_ERRORS]:
        place = _follow(slot_of(model), data, list(details["loc"]), details["type"])
        if place is not None:
            finding = _finding(place, details)
            path = (*root, *finding.path)
            found[document.problem(path, finding.message, key=finding.key, rule=finding.rule, hint=finding.hint)] = None
    if len(errors) > MAX_ERRORS:
        text = f"{len(errors) - MAX_ERRORS:,} more values are wrong"
        found[document.problem(root, text, rule="value")] = None
    # Errors that cannot be located more exactly are still reported.
    return list(found) or [document.problem(root, _raw_message(error), rule="value")]


def _raw_message(error: ValidationError) -> str:
    details = error.errors(include_url=False)[0]
    return f"{'.'.join(map(str, details['loc']))}: {details['msg']}"


@dataclass
class _Place:
    """The value that an error is about, and its slot in the language."""

    path: Path
    slot: LanguageSlot
    data: Any
    rest: list[Step]
    """Steps to something that does not exist: a missing or unknown key, a missing item."""
    alternatives: bool = False
    """Whether the value fits no alternative of a union, and the intended one is unknown."""


def _follow(slot: LanguageSlot, data: Any, loc: list[Step], kind: str) -> _Place | None:
    """Return the place of an error; None if the error is about an alternative that was not intended."""
    path: Path = ()
    while True:
        if loc[1:] == ["[key]"]:
            return _Place(path, slot, data, loc)
        if slot.discriminator is not None and loc:
            slot = slot_of(slot.models[str(loc.pop(0))])
        elif slot.discriminator is None and len(slot.members) > 1:
            fitting = [member for member in slot.members if fits(member, data)]
            if slot.list_of_other is not None and structure_of(data) == "list":
                fitting = [slot.list_of_other]
            if not fitting:  # such as `[1s, 2]`, whose first item is wrong
                fitting = [member for member in slot.members if member.structure == structure_of(data)]
            # Of several lists, the one of the same length was intended.
            fitting = [member for member in fitting if _is_as_long(member, data)] or fitting
            if len(fitting) != 1:
                return _Place(path, slot, data, [], alternatives=True)
            if not loc or not is_label_of(str(loc.pop(0)), fitting[0]):
                return None
            if not loc and kind in ("literal_error", "string_pattern_mismatch") and slot.list_of_other is None:
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


# --- messages -------------------------------------------------------------------------------------------------


@dataclass
class _Finding:
    path: Path
    message: str
    rule: str
    hint: str | None = None
    key: bool = False


def _finding(place: _Place, details: ErrorDetails) -> _Finding:
    kind, slot, data = details["type"], place.slot, place.data
    if place.rest[1:] == ["[key]"]:
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
    message = f"needs {describe(slot)} (got {_given(data, slot)}){_advice(data, slot)}"
    return _Finding(place.path, message, "type", key=data is None)


def _range(slot: LanguageSlot, data: Any) -> str:
    """Return the bounds that a number violates: those of the field, or those of supported magnitudes."""
    supported = supported_range(slot)
    if supported is None or data <= 0 or supported.low <= data <= supported.high:
        return range_of(slot)
    return f" {magnitudes(supported)}"


def _unknown_key(place: _Place) -> _Finding:
    key, model = str(place.rest[0]), place.slot.base
    known = [word for word in fields_of(model) if word != "kind" or kinds_of(model)]
    free = [word for word in known if word not in place.data]
    message = f"unknown key `{key}`; {_name_of(place)} takes {', '.join(known)}{_non_ascii(key)}"
    if _NUMBER.fullmatch(key):
        message += "; write decimals with a point, and vectors in brackets: [0, 0.5, 1]"
    elif ":" in key and key.split(":")[0] in known:
        message += "; a space is missing after the colon"
    elif key in _WITHIN and _WITHIN[key] in known:
        message += f"; `{key}` belongs in `{_WITHIN[key]}`"
    elif key in _ELSEWHERE and {"look", "place"} <= set(known) and nearest(key, free) is None:
        return _Finding((*place.path, key), f"{message}; {_ELSEWHERE[key]}", "unknown-key", key=True)
    elif place.path[-1:] == ("motion",) and nearest(key, free) is None:
        message += "; a body that both slides and turns is `articulated`: see Motions in docs/language.md"
    elif OTHER_KEYS.get(key) in free:
        return _Finding((*place.path, key), message, "unknown-key", OTHER_KEYS[key], key=True)
    return _Finding((*place.path, key), message, "unknown-key", nearest(key, free) or nearest(key, known), key=True)


_WITHIN = {
    **dict.fromkeys(("mass", "density", "friction", "restitution"), "material"),
    **dict.fromkeys(("pos", "position", "quat", "euler_deg", "rotation", "orientation"), "pose"),
    **dict.fromkeys(("color", "colour", "finish", "opacity"), "look"),
    **dict.fromkeys(("radius", "size"), "shape"),
}
"""Keys that are often written one level too high, in a body, by the key that they belong in."""
_ELSEWHERE = {
    **dict.fromkeys(
        ("pin", "pins", "pinned", "fixed_points", "fixed_vertices", "anchor", "anchors", "attach", "attached"),
        "use `kind: attach` in `actions.controls` to hold a body, or a region of it",
    ),
    **dict.fromkeys(
        ("velocity", "speed", "initial_velocity", "linear_velocity", "angular_velocity"),
        "use `kind: initial_velocity` in `actions.controls` for a velocity at the start",
    ),
    **dict.fromkeys(("force", "forces", "impulse", "push", "torque"), "forces on a body belong in `actions.controls`"),
    **dict.fromkeys(("fixed", "static"), "objects that never move belong in `scene.statics`"),
}
"""Keys of bodies in other languages, with advice on where they belong in this one."""
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
"""Keys by their names in other languages."""


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
    **dict.fromkeys(("slat", "springboard", "ruler", "leaf_spring", "reed", "cantilever", "plank"), "beam"),
    **dict.fromkeys(("kinematic", "scripted", "animated"), "driven"),
    **dict.fromkeys(("robot", "mechanism", "urdf", "mjcf"), "articulated"),
    **dict.fromkeys(("dynamic", "free_body", "rigidbody", "rigid_body"), "rigid"),
    **dict.fromkeys(("cube", "cuboid", "block"), "box"),
    **dict.fromkeys(("rod", "disc", "disk"), "cylinder"),
    **dict.fromkeys(("ball",), "sphere"),
    **dict.fromkeys(("prism", "profile", "polygon", "extrude", "extruded", "cam", "ratchet"), "extrusion"),
    **dict.fromkeys(("strip", "band", "tape", "bow"), "ribbon"),
    **dict.fromkeys(("tube", "cone", "sock", "skirt"), "sleeve"),
    **dict.fromkeys(("dome", "cap", "hat", "lathe", "revolved"), "revolve"),
    **dict.fromkeys(("jet", "source", "emitter", "inlet", "tap", "faucet", "nozzle", "hose", "spout"), "stream"),
    **dict.fromkeys(("revolute", "rotary"), "hinge"),
    **dict.fromkeys(("prismatic", "linear"), "slider"),
    **dict.fromkeys(("pin", "weld", "constraint", "grasp"), "attach"),
    **dict.fromkeys(("tendon", "bungee", "elastic", "tether", "coil"), "spring"),
}
"""Kinds by their names in other languages, for hints."""


def _bad_kind(place: _Place) -> _Finding:
    kinds = list(place.slot.models)
    if "kind" not in place.data:
        return _Finding(place.path, f"`kind` is missing: one of {', '.join(kinds)}", "missing-kind", key=True)
    kind = place.data["kind"]
    if not isinstance(kind, str):
        message = f"must be one of {', '.join(kinds)} (got {show(kind)})"
        return _Finding((*place.path, "kind"), message, "unknown-kind")
    message = f"unknown kind {_quoted(kind)}; there are {', '.join(kinds)}"
    if kind == "plane":
        message += "; only a static can be a plane"
    if kind == "sheet":
        message += "; only a cloth can be a sheet"
    meant = OTHER_WORDS.get(kind.lower())
    hint = meant if meant in kinds else None if kind in ("plane", "sheet") else nearest(kind, kinds)
    return _Finding((*place.path, "kind"), message, "unknown-kind", hint)


def _unknown_word(place: _Place) -> _Finding:
    words = [str(word) for word in get_args(place.slot.base)]
    message = f"must be {describe(place.slot)} (got {_quoted(place.data)})"
    return _Finding(place.path, message, "unknown-word", nearest(place.data, words))


def _no_alternative(place: _Place) -> _Finding:
    words = [w for member in place.slot.members for w in get_args(member.base) if isinstance(w, str)]
    numbers = [member for member in place.slot.members if member.structure == "number"]
    advice = _advice(place.data, numbers[0]) if numbers else ""
    message = f"needs {describe(place.slot)} (got {_given(place.data, place.slot)}){advice}"
    if "z" in words and place.data in ("-x", "-y", "-z"):  # the nearest word is the opposite
        back = [-1 if word == place.data[1] else 0 for word in "xyz"]
        return _Finding(place.path, f"{message}; write {back}", "type")
    return _Finding(place.path, message, "type", nearest(place.data, words))


def _given(data: Any, slot: LanguageSlot) -> str:
    """Return what was given instead, without ambiguity as in `needs 3 numbers (got 3)`."""
    number = structure_of(data) == "number" and slot.structure != "number"
    return f"the number {show(data)}" if number else show(data)


_WITH_UNIT = re.compile(r"[-+]?[\d.]+(e[-+]?\d+)?\s*[a-zA-Z°%/]+[23]?")
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?")


def _advice(data: Any, slot: LanguageSlot) -> str:
    """Return how to write a number or a mapping, if text was given instead, and where selectors may be a list."""
    if isinstance(data, list) and noun_of(slot) == noun_of(slot_of(Selector)):
        return "; it takes one: lists are for `of` of measures and events, and `by` and `to` of measures"
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
        return "; leave out the unit: all numbers are in SI units (m, kg, s, N, rad), except `…_deg`"
    if text.startswith("$"):
        return "; write an expression as ${…}"
    words = text.split()
    several = len(words) > 1 and all(map(_NUMBER.fullmatch, words))
    return "; put commas between numbers" if several else _non_ascii(text)


def _bad_text(place: _Place) -> _Finding:
    noun = noun_of(place.slot)
    message = f"{_quoted(place.data)} is not {noun.singular}: {noun.form}"
    return _Finding(place.path, message + _non_ascii(place.data), "form")


def _bad_name(place: _Place) -> _Finding:
    word, keys = str(place.rest[0]), slot_of(get_args(place.slot.base)[0])
    if get_origin(keys.base) is Literal:
        words = get_args(keys.base)
        message = f"unknown key `{word}`; `{place.path[-1]}` takes {', '.join(words)}{_non_ascii(word)}"
        return _Finding((*place.path, word), message, "unknown-key", nearest(word, words), key=True)
    message = f"{_quoted(word)} is not a name: {noun_of(slot_of(Name)).form}"
    return _Finding((*place.path, word), message + _non_ascii(word), "form", key=True)


def _non_ascii(word: str) -> str:
    """Return the name of the first non-ASCII character, which may look like an ASCII letter; empty if there is none."""
    found = next((c for c in word if not c.isascii()), None)
    return "" if found is None else f"; `{found}` is {name(found, 'no letter')}"


def _bad_length(place: _Place, details: ErrorDetails) -> _Finding:
    side, bound = ("least", "min_length") if details["type"] == "too_short" else ("most", "max_length")
    count = details.get("ctx", {}).get(bound)
    wanted = f"at {side} {count} {'entry' if count == 1 else 'entries'}"
    return _Finding(place.path, f"needs {wanted} (got {len(place.data)})", "length", key=True)


def _quoted(value: object) -> str:
    return f"`{show(value).removeprefix('the text ').strip(chr(39))}`" if isinstance(value, str) else show(value)
