"""Documents that nobody should have written: cases with something changed in them, as text or as data."""

import copy
import json
import random
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from hostile import Content, hostile_files

from text2sim.spec_schema.reuse.overlay import CaseOverlay
from text2sim.spec_schema.text.canonical import dump_case
from text2sim.spec_schema.text.document import parse_document
from text2sim.spec_schema.text.source import Source

VALUES: tuple[Any, ...] = (
    None, True, False, 0, -1, 1, 2, 0.5, -0.0, 1e-9, 1e-30, 1e9, 1e300, -1e300, 10**25, 2**31, 99_999, 100_001,
    "", " ", "x", "on", "null", "nan", "inf", "-inf", "1e999", "0x10", "é" * 40, "a" * 5000, "\t", "'", '"', "{{ 7*7 }}",
    "../../../etc/passwd", "/etc/passwd", "assets/../../x.obj", "genesis:../../x", "file:///etc/passwd", "~/.ssh/id_rsa",
    "__import__('os').system('touch pwned')", "${__import__('os')}", "${().__class__}", "${1/0}", "${9**9**9}",
    "${i}", "${i * 0.1}", "${nowhere}", "${", "${}", "${[1,2,3]}", "${'a'}", "${rows}", "${rows * 1e300}", "brick[*]",
    "brick[999999]", "ball[3:1]", "ball.x", "floor", "world", "!!python/object/apply:os.system [ls]",
    [], [0], [0, 0], [0, 0, 0], [0, 0, 0, 0], [1e9, 0, 0], [0, 0, -1e3], [[0]], ["a", "b"], [None], [0] * 500,
    {}, {"kind": "box"}, {"kind": "sphere", "radius": 0.1}, {"kind": "nope"}, {"a": {"b": {"c": {}}}}, {"on": "floor"},
    {"inside": "ball"}, {"kind": "constant", "value": 1e12}, {"kind": "mesh", "file": "x.obj"}, {"use": "cup"},
    {"use": "nope", "with": {"x": 1}}, {"use": "table", "with": {"height": -1}}, {"kind": "net", "cells": [20, 20]},
    {"min": [0, 0, 0], "max": [1, 1, 1]}, {"kind": "ring", "count": 3, "radius": 1}, {"corner": ["left", "top"]},
)  # fmt: skip
"""What is put in the place of a value."""
ROOTS: tuple[tuple[str, Any], ...] = (
    ("variants", {"soft": {"bodies": {"ball": None}}}),
    ("variants", {"soft": {"bodies": {"nope": {"material": {"density": "x"}}}}}),
    ("sweeps", {"all": {"grid": {"params.speed": [1, 2, 3], "nowhere.at.all": []}}}),
    ("prefabs", {"p": {"params": {"a": {"kind": "length"}}, "body": {"kind": "rigid", "shape": "${a}"}}}),
    ("prefabs", {"p": {"body": {"use": "p"}}}),
    ("waive", {"overlap": "it is meant to be so"}),
    ("waive", {"nope": ""}),
    ("params", {"a": "${b}", "b": "${a}"}),
    ("params", {"a": "${[0] * 9999}", "b": "${a + a}", "c": "${b + b}"}),
)
"""Sections that are put in, or in the place of what is there."""
PIECES = ("\n", "  ", "- ", ": ", "{", "}", "[", "]", "&a ", "*a ", "<<: ", "!!int ", "|\n", ">\n", "# ", "---\n", "...\n",
          "${", "}", '"', "'", "\t", "\u202e", "\ufeff", "\x00", "\ue000", "%YAML 1.1\n", "? ", "@", "`", "💥", "=")  # fmt: skip


SOFT = Path(__file__).with_name("soft")


@dataclass
class Draft:
    """A document, with what comes with it."""

    case: str
    """The case as which it began."""
    text: bytes = b""
    data: Any = None
    files: dict[str, Content] = field(default_factory=dict)
    """Other files of its folder."""
    overlay: CaseOverlay = field(default_factory=CaseOverlay)
    operations: list[dict[str, Any]] = field(default_factory=list)
    """A patch."""


def originals_of(cases: Path) -> list[Path]:
    """Return the cases that are changed: the good ones, and some with deformable bodies of every kind."""
    return [*sorted(cases.glob("*/case.yaml")), *sorted(SOFT.glob("*/case.yaml"))]


def mutations(cases: Path, count: int, seed: int) -> list[Draft]:
    """Make documents, always the same for one seed.

    Args:
        cases: The folder of good cases.
        count: How many.
        seed: Of the choice.
    """
    chance = random.Random(seed)
    originals = [(path.parent.name, path.read_text("utf-8")) for path in originals_of(cases)]
    data = {name: parse_document(Source(text)).data for name, text in originals}
    made: list[Draft] = []
    while len(made) < count:
        name, text = chance.choice(originals)
        if chance.random() < 0.25:
            draft = Draft(name, _spoil_text(text, chance), data[name])
        else:
            draft = _changed(Draft(name, data=copy.deepcopy(data[name])), chance)
        if chance.random() < 0.2:
            _lay_over(draft, chance)
        if chance.random() < 0.3:
            # A copy each: a patch that comes as JSON has no value in two places.
            draft.operations = [
                copy.deepcopy(_operation(draft.data, chance)) for _ in range(chance.choice((1, 1, 2, 5)))
            ]
        try:
            draft.text = draft.text or dump_case(draft.data).encode("utf-8", "surrogatepass")
        except (ValueError, RecursionError):
            continue  # not a document at all
        made.append(draft)
    return made


def _changed(draft: Draft, chance: random.Random) -> Draft:
    # Half of them stay near to what a case is: only those get past the first checks.
    gentle = chance.random() < 0.6
    if chance.random() < 0.5:
        for _ in range(chance.choice((1, 1, 2))):
            chance.choice(_WORDS)(draft, chance)
    for _ in range(chance.choice((0, 1, 1, 1, 2, 3, 8))):
        chance.choice(_GENTLE if gentle else _DATA)(draft.data, chance)
    return draft


def _spoil_text(text: str, chance: random.Random) -> bytes:
    data = text
    for _ in range(chance.choice((1, 1, 2, 5))):
        at, other = sorted(chance.randrange(len(data) + 1) for _ in range(2))
        kind = chance.randrange(6)
        if kind == 0:
            data = data[:at] + chance.choice(PIECES) + data[at:]
        elif kind == 1:
            data = data[:at] + data[min(other, at + 40) :]
        elif kind == 2:
            data = data[:at] + data[at : min(other, at + 200)] * 2 + data[at:]
        elif kind == 3:
            lines = data.split("\n")
            i, j = (chance.randrange(len(lines)) for _ in range(2))
            lines[i], lines[j] = lines[j], lines[i]
            data = "\n".join(lines)
        elif kind == 4:
            lines = data.split("\n")
            i = chance.randrange(len(lines))
            lines[i] = " " * chance.randrange(9) + lines[i].lstrip()
            data = "\n".join(lines)
        else:
            data = data[:at] + chance.choice("0123456789.e-") + data[at + 1 :]
        data = data or " "
    spoiled = data.encode("utf-8")
    if chance.random() < 0.1:
        at = chance.randrange(len(spoiled))
        spoiled = spoiled[:at] + bytes([chance.randrange(256)]) + spoiled[at + 1 :]
    return spoiled


# --- changes of data -------------------------------------------------------------------------------------


def _places(value: Any) -> list[tuple[Any, Any]]:
    """Every (container, key) of a document."""
    found, stack = [], [value]
    while stack:
        container = stack.pop()
        rows = container.items() if isinstance(container, dict) else enumerate(container)
        for key, item in rows:
            found.append((container, key))
            if isinstance(item, dict | list):
                stack.append(item)
    return found


def _pick(document: Any, chance: random.Random) -> tuple[Any, Any] | None:
    places = _places(document)
    return chance.choice(places) if places else None


def _replace(document: Any, chance: random.Random) -> None:
    if found := _pick(document, chance):
        found[0][found[1]] = copy.deepcopy(chance.choice(VALUES))


def _delete(document: Any, chance: random.Random) -> None:
    if found := _pick(document, chance):
        del found[0][found[1]]


def _scale(document: Any, chance: random.Random) -> None:
    numbers = [(c, k) for c, k in _places(document) if isinstance(c[k], int | float) and not isinstance(c[k], bool)]
    if numbers:
        container, key = chance.choice(numbers)
        if isinstance(container[key], int) and chance.random() < 0.5:
            container[key] += chance.choice((-1, 1, 10))
            return
        container[key] *= chance.choice((-1, 0, 1e-6, 0.01, 0.5, 2, 10, 100, 1e4, 1e8))


def _rename(document: Any, chance: random.Random) -> None:
    keys = [(c, k) for c, k in _places(document) if isinstance(c, dict)]
    if keys:
        container, key = chance.choice(keys)
        value = container.pop(key)
        container[chance.choice((key[:-1], key + "s", key.upper(), "x", "kind", "use", "ball", "a b", "é", ""))] = value


def _transplant(document: Any, chance: random.Random) -> None:
    """Put a copy of one part in the place of another."""
    if (a := _pick(document, chance)) and (b := _pick(document, chance)):
        a[0][a[1]] = copy.deepcopy(b[0][b[1]])


def _sibling(document: Any, chance: random.Random) -> None:
    """Put a value in the place of another one of the same key: the right form, somewhere else."""
    places = [(c, k) for c, k in _places(document) if isinstance(c, dict)]
    container, key = chance.choice(places)
    container[key] = copy.deepcopy(chance.choice([c[k] for c, k in places if k == key]))


def _section(document: Any, chance: random.Random) -> None:
    key, value = chance.choice(ROOTS)
    document[key] = copy.deepcopy(value)


def _word(document: Any, chance: random.Random) -> None:
    """Put one word of the document in the place of another: the right type, the wrong meaning."""
    words = [(c, k) for c, k in _places(document) if isinstance(c[k], str)]
    if words:
        (a, i), (b, j) = chance.choice(words), chance.choice(words)
        a[i] = b[j]


# --- words of the language -------------------------------------------------------------------------------

SIDES = ("left", "right", "front", "back", "bottom", "top", "inside", 3)
RELATIONS = ("on", "above", "below", "inside", "left_of", "behind", "beside", "beside", "around", "around", "touching")
PREFABS = ("bottle", "clamp", "cup", "curtain_rod", "drum", "fork", "funnel", "net", "plate", "ragdoll", "ring_chain", "table",
           "tube", "wheel", "wine_glass", "robot_arm", "nope", "../cup", "local", "file")  # fmt: skip
ARGUMENTS = ("height", "diameter", "color", "fill", "rings", "radius", "length", "size", "posture", "nope")
PATTERNS = (
    {"kind": "line", "count": 3, "step": [0.5, 0, 0]}, {"kind": "ring", "count": 7, "radius": 0.6}, {"kind": "stack", "count": 4},
    {"kind": "grid", "counts": [3, 2], "spacing": 0.4}, {"kind": "spiral", "count": 5, "radius": [0.2, 0.6], "turns": 2},
    {"kind": "packing", "count": 9, "region": {"kind": "box", "min": [0, 0, 0], "max": [1, 1, 1]}, "seed": 1},
    {"kind": "line", "count": 100000, "step": [0, 0, 0]}, {"kind": "running_bond", "rows": 3, "columns": 4},
)  # fmt: skip


def _things(draft: Draft) -> list[tuple[dict[str, Any], str]]:
    """Every (section, name) of a body or static."""
    data = draft.data if isinstance(draft.data, dict) else {}
    scene = data.get("scene")
    sections = [data.get("bodies"), scene.get("statics") if isinstance(scene, dict) else None]
    return [(s, name) for s in sections if isinstance(s, dict) for name in s if isinstance(s[name], dict)]


def _region(chance: random.Random) -> Any:
    sides = [chance.choice(SIDES) for _ in range(chance.choice((1, 2, 2, 3)))]
    point = [chance.choice((0, 0.1, -0.5, 1e6)) for _ in range(3)]
    return chance.choice((
        {"face": sides[0]}, {"edge": sides}, {"edge": sides[0]}, {"corner": sides}, {"nearest": point}, point[:2],
        {"sphere": {"center": point, "radius": 0.1}}, {"box": {"min": [-1, -1, -1], "max": point}}, {"face": "top", "edge": "left"},
    ))  # fmt: skip


def _place(draft: Draft, chance: random.Random) -> None:
    if not (things := _things(draft)):
        return
    section, name = chance.choice(things)
    others = [other for _, other in things]
    place: dict[str, Any] = {chance.choice(RELATIONS): chance.choice((*others, f"{others[0]}[0]", f"{others[-1]}[*]"))}
    more = {
        "at": _region(chance), "direction": chance.choice(("x", "-x", "z", [1, 1, 0])), "clearance": chance.choice((0, 0.01, 5)),
        "align": chance.choice(("top", "center", "bottom", {"x": "min"}, {"x": "max", "y": "center", "z": "min"}, {"w": 1})),
        "offset": [0, 0, chance.choice((0, 0.1, -3))], "facing": chance.choice((*others, [0, 0, 0], [1, 2, 3])),
        "euler_deg": [0, chance.choice((0, 30, 90)), 45], "inset": chance.choice((0, 0.02, 9)),
    }  # fmt: skip
    place |= {key: more[key] for key in chance.sample(list(more), chance.choice((0, 1, 1, 2, 3)))}
    section[name].pop("pose", None)
    section[name]["place"] = place
    if chance.random() < 0.3:
        section[name]["repeat"] = copy.deepcopy(chance.choice(PATTERNS))


def _use(draft: Draft, chance: random.Random) -> None:
    if not (things := _things(draft)):
        return
    section, name = chance.choice(things)
    kept = {
        key: section[name][key] for key in ("place", "pose", "repeat") if key in section[name] and chance.random() < 0.8
    }
    section[name] = {"use": chance.choice(PREFABS), **kept}
    if chance.random() < 0.5:
        values = (
            0.1,
            0.05,
            3,
            "${0.05 + i * 0.01}",
            "${u}",
            "red",
            "${'a' * 3}",
            0,
            -1,
            None,
            "${nowhere}",
            [1],
            "up",
            1e9,
        )
        section[name]["with"] = {chance.choice(ARGUMENTS): chance.choice(values) for _ in range(chance.choice((1, 2)))}
    if chance.random() < 0.3:
        section[name] |= copy.deepcopy(
            chance.choice(({"look": {"color": "red"}}, {"shape": {"radius": 1}}, {"material": {"density": "${i}"}}))
        )


def _prefab(draft: Draft, chance: random.Random) -> None:
    """Make a prefab of a body, in the case or in a file."""
    if not (things := _things(draft)):
        return
    section, name = chance.choice(things)
    body = copy.deepcopy(section[name])
    for key in ("place", "pose", "repeat"):
        body.pop(key, None)
    params = {
        "a": {
            "kind": chance.choice(("length", "number", "count", "color", "choice", "text")),
            "default": chance.choice((0.1, 2, "red", None)),
        }
    }
    numbers = [(c, k) for c, k in _places(body) if isinstance(c[k], int | float) and not isinstance(c[k], bool)]
    if numbers:
        container, key = chance.choice(numbers)
        container[key] = chance.choice(("${a}", "${a * 2}", "${a + speed}", "${a + i}", "x${a}"))
    definition: dict[str, Any] = {"params": params, "body": body}
    if chance.random() < 0.2:
        definition = {"bodies": {"one": body, "two": {"use": chance.choice(("local", "file", "cup"))}}}
    if chance.random() < 0.5:
        draft.data.setdefault("prefabs", {})["local"] = definition
    else:
        draft.files["prefabs/file.yaml"] = json.dumps({"text2sim": 2, "prefab": "file", **definition}).encode()
    kept = {key: section[name][key] for key in ("place", "pose", "repeat") if key in section[name]}
    section[name] = {
        "use": chance.choice(("local", "file")),
        "with": {"a": chance.choice((0.1, "${0.1 + 0.01 * i}", 7))},
        **kept,
    }


def _file(draft: Draft, chance: random.Random) -> None:
    files, body = hostile_files(chance)
    draft.files |= files
    if isinstance(draft.data.get("bodies"), dict):
        draft.data["bodies"]["stranger"] = body


def _path(data: Any, chance: random.Random) -> tuple[list[Any], Any]:
    """Return a way into data, and what is there."""
    steps: list[Any] = []
    while isinstance(data, dict | list) and data and (not steps or chance.random() < 0.85):
        key = chance.choice(list(data)) if isinstance(data, dict) else chance.randrange(len(data))
        steps.append(key)
        data = data[key]
    return steps, data


def _value(found: Any, chance: random.Random) -> Any:
    if isinstance(found, int | float) and chance.random() < 0.7:
        return found * chance.choice((2, 0.5, 1.1))
    return copy.deepcopy(chance.choice(VALUES) if chance.random() < 0.7 else found)


def _nested(steps: list[Any], value: Any) -> Any:
    for step in reversed(steps):
        value = {str(step): value}
    return value


def _variant(draft: Draft, chance: random.Random) -> None:
    steps, found = _path({key: value for key, value in draft.data.items() if key not in ("text2sim", "name")}, chance)
    if isinstance(steps[-1] if steps else None, int):
        steps = steps[:-1]
    entry = draft.data.setdefault("variants", {})
    if isinstance(entry, dict):
        entry[chance.choice(("soft", "gentle", "a b"))] = _nested(steps, chance.choice((None, _value(found, chance))))


def _sweep(draft: Draft, chance: random.Random) -> None:
    steps, found = _path(draft.data, chance)
    dots = ".".join(map(str, steps))
    values = [_value(found, chance) for _ in range(chance.choice((1, 3, 3, 200)))]
    twice = copy.deepcopy(values)
    draft.data["sweeps"] = {"s": chance.choice((
        {"grid": {dots: values}}, {"grid": {dots: values, "scene.dt": twice}}, {"points": {"a": _nested(steps, found), "b": {}}},
        {"variants": ["soft", "nope"]}, {"grid": {}, "points": {}}, {"grid": {"params.speed": list(range(3000))}},
    ))}  # fmt: skip


def _lay_over(draft: Draft, chance: random.Random) -> None:
    sets = []
    for _ in range(chance.choice((0, 1, 1, 3))):
        steps, found = _path(draft.data, chance)
        dots = ".".join(map(str, steps))
        text = chance.choice(PIECES) if chance.random() < 0.1 else json.dumps(_value(found, chance), default=str)
        sets.append(chance.choice((f"{dots}={text}",) * 6 + (dots, f"={text}", f"{dots}.x={text}", f".{dots}={text}")))
    names = draft.data.get("variants") if isinstance(draft.data, dict) else None
    variants = (chance.choice([*names, "nope"]),) if isinstance(names, dict) and names else ()
    draft.overlay = CaseOverlay(variants=tuple(map(str, variants)), sets=tuple(sets))


def _operation(data: Any, chance: random.Random) -> dict[str, Any]:
    steps, found = _path(data, chance)
    other, _ = _path(data, chance)
    if chance.random() < 0.2:
        steps = [*steps[:-1], chance.choice(("new", "-", 0, "a/b", "~", ""))]
    path, source = ("".join(f"/{str(s).replace('~', '~0').replace('/', '~1')}" for s in way) for way in (steps, other))
    return chance.choice((
        {"op": "replace", "path": path, "value": _value(found, chance)}, {"op": "remove", "path": path}, {"op": "copy", "from": source, "path": path},
        {"op": "add", "path": path, "value": _value(found, chance)}, {"op": "move", "from": source, "path": path}, {"op": "test", "path": path, "value": found},
    ))  # fmt: skip


_WORDS: tuple[Callable[[Draft, random.Random], None], ...] = (
    _place,
    _place,
    _place,
    _use,
    _use,
    _prefab,
    _prefab,
    _file,
    _variant,
    _sweep,
)
_GENTLE = (_scale, _scale, _scale, _sibling)
_DATA: tuple[Callable[[Any, random.Random], None], ...] = (
    _replace, _replace, _replace, _delete, _scale, _scale, _rename, _transplant, _word, _word, _section,
)  # fmt: skip
