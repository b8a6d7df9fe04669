"""Changes of a document that know the language: places, prefabs, files, variants, sweeps, overlays and patches."""

import copy
import json
import random
from collections.abc import Callable
from typing import Any

from draft import PIECES, Draft, changed_value, places_of, way_into
from hostile import hostile_files

from text2sim.spec_schema.reuse.overlay import CaseOverlay

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
    numbers = [(c, k) for c, k in places_of(body) if isinstance(c[k], int | float) and not isinstance(c[k], bool)]
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


def _nested(steps: list[Any], value: Any) -> Any:
    for step in reversed(steps):
        value = {str(step): value}
    return value


def _variant(draft: Draft, chance: random.Random) -> None:
    steps, found = way_into(
        {key: value for key, value in draft.data.items() if key not in ("text2sim", "name")}, chance
    )
    if isinstance(steps[-1] if steps else None, int):
        steps = steps[:-1]
    entry = draft.data.setdefault("variants", {})
    if isinstance(entry, dict):
        entry[chance.choice(("soft", "gentle", "a b"))] = _nested(
            steps, chance.choice((None, changed_value(found, chance)))
        )


def _sweep(draft: Draft, chance: random.Random) -> None:
    steps, found = way_into(draft.data, chance)
    dots = ".".join(map(str, steps))
    values = [changed_value(found, chance) for _ in range(chance.choice((1, 3, 3, 200)))]
    twice = copy.deepcopy(values)
    draft.data["sweeps"] = {"s": chance.choice((
        {"grid": {dots: values}}, {"grid": {dots: values, "scene.dt": twice}}, {"points": {"a": _nested(steps, found), "b": {}}},
        {"variants": ["soft", "nope"]}, {"grid": {}, "points": {}}, {"grid": {"params.speed": list(range(3000))}},
    ))}  # fmt: skip


def lay_over(draft: Draft, chance: random.Random) -> None:
    sets = []
    for _ in range(chance.choice((0, 1, 1, 3))):
        steps, found = way_into(draft.data, chance)
        dots = ".".join(map(str, steps))
        text = chance.choice(PIECES) if chance.random() < 0.1 else json.dumps(changed_value(found, chance), default=str)
        sets.append(chance.choice((f"{dots}={text}",) * 6 + (dots, f"={text}", f"{dots}.x={text}", f".{dots}={text}")))
    names = draft.data.get("variants") if isinstance(draft.data, dict) else None
    variants = (chance.choice([*names, "nope"]),) if isinstance(names, dict) and names else ()
    draft.overlay = CaseOverlay(variants=tuple(map(str, variants)), sets=tuple(sets))


def operation(data: Any, chance: random.Random) -> dict[str, Any]:
    steps, found = way_into(data, chance)
    other, _ = way_into(data, chance)
    if chance.random() < 0.2:
        steps = [*steps[:-1], chance.choice(("new", "-", 0, "a/b", "~", ""))]
    path, source = ("".join(f"/{str(s).replace('~', '~0').replace('/', '~1')}" for s in way) for way in (steps, other))
    return chance.choice((
        {"op": "replace", "path": path, "value": changed_value(found, chance)}, {"op": "remove", "path": path}, {"op": "copy", "from": source, "path": path},
        {"op": "add", "path": path, "value": changed_value(found, chance)}, {"op": "move", "from": source, "path": path}, {"op": "test", "path": path, "value": found},
    ))  # fmt: skip


WORDS: tuple[Callable[[Draft, random.Random], None], ...] = (
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
