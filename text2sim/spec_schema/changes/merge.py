"""Three-way merge of meaning: what two authors made of one case, put together."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from text2sim.spec_schema.changes.amendment import identical
from text2sim.spec_schema.changes.diff import NOTHING
from text2sim.spec_schema.changes.naming import Rename, follow
from text2sim.spec_schema.changes.patch import same
from text2sim.spec_schema.changes.renames import find_renames
from text2sim.spec_schema.text.document import Path

_CONTAINERS: tuple[Path, ...] = (
    *((name,) for name in ("params", "prefabs", "scene", "bodies", "actions", "render")),
    *((name,) for name in ("variants", "sweeps", "waive")),
    ("scene", "statics"),
    *(("actions", name) for name in ("controls", "measures", "events", "expect")),
    *(("render", name) for name in ("cameras", "lights", "shots")),
)
"""Mappings that both may have begun without meaning the same thing by it."""


@dataclass(frozen=True)
class Conflict:
    """What both changed, and not to the same."""

    path: Path
    """Where, under the names of the merged case."""
    kind: Literal["value", "name"]
    """`name`: both have given an entry another name."""
    ours: Any
    """Our value or name; nothing where we took it away."""
    theirs: Any


@dataclass(frozen=True)
class Merged:
    """What comes out of a merge."""

    data: Any
    """With our values where there are conflicts."""
    conflicts: list[Conflict]
    base: Any
    """The common ancestor under the names of the merged case."""
    ours: Any
    """Our version under the names of the merged case."""
    theirs: Any
    """Theirs."""


def merge(base: Any, ours: Any, theirs: Any, opposed: Iterable[Path] = ()) -> Merged:
    """Merge two versions of a case.

    Entries are merged by name and key: changes of different values do not conflict, however near to each other they
    are written. A list of scalars, such as a point or a colour, is one value. What one side renamed is changed by the
    other under its new name, and mentioned by it.

    Args:
        base: Plain data of the common ancestor.
        ours: What we made of it.
        theirs: What they made of it.
        opposed: Entries of the merged case whose changes do not go together: conflicts, although only one side made
            each of them.
    """
    merger = _Merger(frozenset(opposed))
    we, they = find_renames(base, ours), find_renames(base, theirs)
    they = merger.reconcile(we, they)
    we = [rename for rename in we if not _taken(rename, theirs)]
    they = [rename for rename in they if not _taken(rename, ours)]
    # Each side is brought under the new names of the other; an entry inside a renamed one is found under that.
    theirs = follow(theirs, [_under_new_names(rename, they) for rename in we])[0]
    later = [_under_new_names(rename, we) for rename in they]
    base, ours = follow(follow(base, we)[0], later)[0], follow(ours, later)[0]
    for old, new in merger.names:
        theirs = follow(theirs, [Rename(old.path, old.new, new.new)])[0]
    data = _spelled(merger.merge(base, ours, theirs, ()), ours)
    return Merged(data, merger.conflicts, base, ours, theirs)


@dataclass
class _Merger:
    opposed: frozenset[Path]
    conflicts: list[Conflict] = field(default_factory=list)
    names: list[tuple[Rename, Rename]] = field(default_factory=list)
    """Their rename and ours, of the same entry."""

    def reconcile(self, ours: list[Rename], theirs: list[Rename]) -> list[Rename]:
        """Return their renames without those that we made, too; what both renamed otherwise is a conflict."""
        known = {(rename.path, rename.old): rename for rename in ours}
        rest = []
        for rename in theirs:
            mine = known.get((rename.path, rename.old))
            if mine is None:
                rest.append(rename)
            elif mine.new != rename.new:
                self.conflicts.append(Conflict((*mine.path, mine.new), "name", mine.new, rename.new))
                self.names.append((rename, mine))
        return rest

    def merge(self, base: Any, ours: Any, theirs: Any, path: Path) -> Any:
        if path in self.opposed:
            self.conflicts.append(Conflict(path, "value", ours, theirs))
            return ours
        inside = any(other[: len(path)] == path for other in self.opposed)
        if not inside and (identical(ours, theirs) or identical(base, theirs)):
            return ours
        if not inside and identical(base, ours):
            return theirs
        if base is NOTHING and path in _CONTAINERS:
            base = {}
        if isinstance(base, dict) and isinstance(ours, dict) and isinstance(theirs, dict):
            if not (_other_kind(ours, theirs) and _small(ours) and _small(theirs)):
                return self.mappings(base, ours, theirs, path)
        elif _lists_of_collections(base, ours, theirs):
            rows = enumerate(zip(base, ours, theirs, strict=True))
            return [self.merge(*row, (*path, index)) for index, row in rows]
        # 1 and 1.0 are two spellings of one value.
        if same(ours, theirs) or same(base, theirs):
            return ours
        if same(base, ours):
            return theirs
        self.conflicts.append(Conflict(path, "value", ours, theirs))
        return ours

    def mappings(self, base: dict[str, Any], ours: dict[str, Any], theirs: dict[str, Any], path: Path) -> Any:
        result = {}
        for key in dict.fromkeys([*ours, *theirs]):
            old, mine, others = (data.get(key, NOTHING) for data in (base, ours, theirs))
            value = self.merge(old, mine, others, (*path, key))
            if value is not NOTHING:
                result[key] = value
        return result


def _spelled(data: Any, ours: Any) -> Any:
    """The data, with numbers that are equal to ours as we wrote them: they are no change of our text."""
    if isinstance(data, dict) and isinstance(ours, dict):
        return {key: _spelled(value, ours.get(key, NOTHING)) for key, value in data.items()}
    if isinstance(data, list) and isinstance(ours, list) and len(data) == len(ours):
        return [_spelled(*pair) for pair in zip(data, ours, strict=True)]
    return ours if same(data, ours) else data


def _taken(rename: Rename, other: Any) -> bool:
    """Whether the other side uses the new name for something of its own."""
    for step in rename.path:
        other = other.get(step) if isinstance(other, dict) else None
    return isinstance(other, dict) and rename.new in other and rename.old in other


def _under_new_names(rename: Rename, others: Iterable[Rename]) -> Rename:
    """A rename inside an entry that the other side has renamed."""
    path = rename.path
    for other in others:
        depth = len(other.path)
        if path[:depth] == other.path and path[depth : depth + 1] == (other.old,):
            path = (*path[:depth], other.new, *path[depth + 1 :])
    return replace(rename, path=path)


def _other_kind(a: dict[str, Any], b: dict[str, Any]) -> bool:
    return a.get("kind") != b.get("kind")


def _small(value: dict[str, Any]) -> bool:
    return not any(isinstance(item, dict) for item in value.values())


def _lists_of_collections(*values: Any) -> bool:
    return all(isinstance(value, list) for value in values) and (
        len({len(value) for value in values}) == 1
        and all(isinstance(item, dict | list) for value in values for item in value)
    )
