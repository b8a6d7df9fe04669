"""Where a case names something that it defines elsewhere, and how such names follow when it is called otherwise."""

import re
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, get_args, get_origin

from text2sim.spec_schema.models.base import Name, Selector
from text2sim.spec_schema.models.case import Case
from text2sim.spec_schema.models.placement import RELATIONS
from text2sim.spec_schema.paths import dotted, parse_dotted
from text2sim.spec_schema.text.document import Path
from text2sim.spec_schema.vocabulary.words import Slot, fields_of, is_model, noun_of, slot_of, structure_of

CAST = "bodies and statics"
"""Bodies and statics share their names."""
SPACES: dict[Path, str] = {
    ("params",): "params",
    ("prefabs",): "prefabs",
    ("scene", "statics"): CAST,
    ("bodies",): CAST,
    ("actions", "controls"): "controls",
    ("actions", "measures"): "measures",
    ("actions", "events"): "events",
    ("render", "cameras"): "cameras",
    ("variants",): "variants",
}
"""What kind of name the keys of a mapping are, for those that are named elsewhere."""
_FIELDS = {
    "measure": "measures",
    "event": "events",
    "after": "events",
    "before": "events",
    "on": "events",
    "attach": "controls",
    "camera": "cameras",
    "values": "measures",
}
_SELECTED = ("of", "by", "body", "joint", "to", "between", "look_at", "facing", *RELATIONS)
"""Fields for selectors, in an overlay that does not say of which kind a thing is."""
_SELECTOR = re.compile(r"(\w+)((?:\[.*\])?)(?:\.(\w+))?", re.ASCII)
_EXPRESSION = re.compile(r"\$\{[^}]*\}")
_WORD = re.compile(r"(?<![\w.'\"])[A-Za-z_]\w*", re.ASCII)
_SELECTOR_NOUN, _NAME_NOUN = noun_of(slot_of(Selector)), noun_of(slot_of(Name))


@dataclass(frozen=True)
class Rename:
    """An entry of a mapping that is called otherwise."""

    path: Path
    """The mapping."""
    old: str
    new: str


def follow(data: Any, renames: Iterable[Rename]) -> tuple[Any, Counter[Rename]]:
    """Return data in which entries are called otherwise, here and wherever they are named, and how often each is.

    A rename may lie inside an entry that one before it has renamed.
    """
    counts: Counter[Rename] = Counter()
    for batch in _batches(renames):
        follower = _Follower(batch)
        data = follower.case(data)
        counts += follower.counts
    return data, counts


def follow_expanded(data: Any, renames: Iterable[Rename], written: Any) -> Any:
    """Return a case whose prefabs are expanded with the names of another version of it.

    Args:
        data: The case.
        renames: Entries that are called otherwise, in the order in which `follow` takes them.
        written: The same case with its prefabs as they are used, before the renames.
    """
    cast, bodies = _cast(written), data.get("bodies") if isinstance(data, dict) else None
    made = [name for name in bodies if name not in cast] if isinstance(bodies, dict) else []
    follower = _Follower([])
    follower.cast = cast
    parts = []
    for rename in renames:
        parts.append(rename)
        if rename.path == ("bodies",):
            names = [name for name in made if follower.owner(name) == rename.old]
            parts += [Rename(rename.path, name, rename.new + name[len(rename.old) :]) for name in names]
    return follow(data, parts)[0]


def _batches(renames: Iterable[Rename]) -> list[list[Rename]]:
    """Renames that can be done at once: none lies inside what another of the same batch renames."""
    batches: list[list[Rename]] = [[]]
    inside: set[Path] = set()
    for rename in renames:
        if any(rename.path[:depth] in inside for depth in range(len(rename.path) + 1)):
            batches.append([])
            inside = set()
        batches[-1].append(rename)
        inside.add((*rename.path, rename.new))
    return batches


class _Follower:
    def __init__(self, renames: list[Rename]) -> None:
        self.counts: Counter[Rename] = Counter()
        self.renames: dict[Path, Rename] = {(*rename.path, rename.old): rename for rename in renames}
        self.by_name: dict[tuple[str, str], Rename] = {}
        self.keys: dict[Path, str] = {(*rename.path, rename.old): rename.new for rename in renames}
        self.names: dict[str, dict[str, str]] = {}
        for rename in renames:
            space = SPACES.get(rename.path)
            if space is None and rename.path[:1] == ("bodies",) and rename.path[2:] in (("links",), ("joints",)):
                space = f"parts of {rename.path[1]}"
            if space is not None:
                self.names.setdefault(space, {})[rename.old] = rename.new
                self.by_name[space, rename.old] = rename
        self.laid = False
        """Whether this is inside an overlay."""
        self.cast: dict[str, bool] = {}
        """Bodies and statics, and whether each comes from a prefab."""

    def case(self, data: Any, root: Path = ()) -> Any:
        if not self.laid:
            self.cast = _cast(data)
        return self.value(data, slot_of(Case), root, "")

    def value(self, value: Any, slot: Slot | None, path: Path, body: str) -> Any:
        """Args: body: the body inside which the value stands."""
        if isinstance(value, str):
            return self.text(value, slot, path, body)
        slot = narrowed(slot, value)
        if isinstance(value, list):
            return [self.value(item, inside(slot, i), (*path, i), body) for i, item in enumerate(value)]
        if not isinstance(value, dict):
            return value
        if not self.laid and (path[:-1] == ("variants",) or (path[:1] == ("sweeps",) and path[2:-1] == ("points",))):
            return self.overlay(value)
        if path[:1] == ("prefabs",) and len(path) == 2:  # a prefab knows nothing of the case
            return value
        rows = {}
        for name, item in value.items():
            within = name if path == ("bodies",) else body
            rows[self.key(name, path, body)] = self.value(item, inside(slot, name), (*path, name), within)
        return rows

    def overlay(self, value: dict[str, Any]) -> Any:
        """A variant, or a point of a sweep: a part of a case, in which names mean what they mean in the case."""
        self.laid = True
        self.counts.update(rename for path, rename in self.renames.items() if _reaches(value, path))
        result = self.case(value)
        self.laid = False
        return result

    def key(self, name: str, path: Path, body: str) -> str:
        if (*path, name) in self.keys:
            return self.keys[(*path, name)]
        if len(path) == 3 and path[0] == "bodies" and path[2] in ("initial", "joints"):
            return self.name(f"parts of {body}", name)
        if path[:1] == ("sweeps",) and path[2:] == ("grid",):
            return self.dotted(name)
        return name

    def dotted(self, text: str) -> str:
        """A dotted path, as the grid of a sweep has them."""
        try:
            path = parse_dotted(text)
        except ValueError:
            return text
        fresh = tuple(self.keys.get(path[: depth + 1], step) for depth, step in enumerate(path))
        met = (self.renames.get(path[: depth + 1]) for depth in range(len(path)))
        self.counts.update(rename for rename in met if rename is not None)
        return dotted(fresh)

    def name(self, space: str, name: str) -> str:
        """A name of some kind as it is called now."""
        rename = self.by_name.get((space, name))
        if rename is None:
            return name
        self.counts[rename] += 1
        return rename.new

    def text(self, text: str, slot: Slot | None, path: Path, body: str) -> str:
        if "${" in text and "params" in self.names:
            text = _EXPRESSION.sub(lambda e: _WORD.sub(lambda word: self.name("params", word[0]), e[0]), text)
        field = next((step for step in reversed(path) if isinstance(step, str)), "")
        nouns = [noun_of(member) for member in slot.members] if slot is not None else []
        if _SELECTOR_NOUN in nouns or (slot is None and self.laid and field in _SELECTED):
            return self.selector(text)
        if _NAME_NOUN in nouns:
            return self.name(f"parts of {body}" if field in ("parent", "between") else _FIELDS.get(field, ""), text)
        if field == "use":
            return self.name("prefabs", text)
        return self.name("variants", text) if path[2:3] == ("variants",) else text

    def selector(self, text: str) -> str:
        found = _SELECTOR.fullmatch(text)
        if found is None:
            return text
        name, index, part = found.groups()
        dot = f".{self.name(f'parts of {name}', part)}" if part else ""
        owner = self.owner(name)
        return self.name(CAST, owner) + name[len(owner) :] + index + dot

    def owner(self, name: str) -> str:
        """The entry that a body comes from: those of a prefab with several bodies are called `NAME_PART`."""
        if name in self.cast:
            return name
        users = [user for user, uses in self.cast.items() if uses and name.startswith(f"{user}_")]
        return max(users, key=len, default=name)


def _cast(data: Any) -> dict[str, bool]:
    scene = data.get("scene") if isinstance(data, dict) else None
    statics = scene.get("statics") if isinstance(scene, dict) else None
    bodies = data.get("bodies") if isinstance(data, dict) else None
    entries = [entry for part in (statics, bodies) if isinstance(part, dict) for entry in part.items()]
    return {name: isinstance(entry, dict) and "use" in entry for name, entry in entries}


def _reaches(data: Any, path: Path) -> bool:
    for step in path:
        if not isinstance(data, dict) or step not in data:
            return False
        data = data[step]
    return True


def narrowed(slot: Slot | None, value: Any) -> Slot | None:
    """The alternative of a union that a collection is written for, None if that cannot be told."""
    if slot is None:
        return None
    if slot.discriminator is not None:
        kind = value.get("kind") if isinstance(value, Mapping) else None
        model = slot.models.get(kind) if isinstance(kind, str) else None
        return slot_of(model) if model is not None else None
    if len(slot.members) > 1:
        fitting = [member for member in slot.members if member.structure == structure_of(value)]
        return narrowed(fitting[0], value) if len(fitting) == 1 else None
    return slot


def inside(slot: Slot | None, step: str | int) -> Slot | None:
    """What the language takes for an entry of a collection."""
    if slot is None:
        return None
    if is_model(slot.base):
        field = fields_of(slot.base).get(str(step))
        return field[1] if field is not None else None
    arguments = get_args(slot.base)
    if get_origin(slot.base) is dict:
        return slot_of(arguments[1])
    if get_origin(slot.base) is list:
        return slot_of(arguments[0])
    if get_origin(slot.base) is tuple and isinstance(step, int) and step < len(arguments):
        return slot_of(arguments[step])
    return None
