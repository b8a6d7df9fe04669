"""Three-way merge of the data of a case."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from text2sim.spec_schema.changes.amendment import identical
from text2sim.spec_schema.changes.diff import NOTHING, is_another_kind
from text2sim.spec_schema.changes.patch import same
from text2sim.spec_schema.text.document import Path

_CONTAINERS: tuple[Path, ...] = (
    *((name,) for name in ("params", "prefabs", "scene", "bodies", "actions", "render")),
    *((name,) for name in ("variants", "sweeps", "waive")),
    ("scene", "statics"),
    *(("actions", name) for name in ("controls", "measures", "events", "expect")),
    *(("render", name) for name in ("cameras", "lights", "shots")),
)
"""Mappings that both sides may have added independently."""


@dataclass(frozen=True)
class Conflict:
    """A value that both sides changed differently."""

    path: Path
    ours: Any
    """Our value; `NOTHING` if we removed it."""
    theirs: Any


@dataclass(frozen=True)
class Merged:
    """The result of a merge."""

    data: Any
    """The merged data, with our values for conflicts."""
    conflicts: list[Conflict]


def merge(base: Any, ours: Any, theirs: Any, opposed: Iterable[Path] = ()) -> Merged:
    """Merge two versions of a case.

    Entries are merged by name and key: changes of different values do not conflict, even on adjacent lines. A list of
    scalars, such as a point or a colour, is one value.

    Args:
        base: Plain data of the common ancestor.
        ours: Our version.
        theirs: Their version.
        opposed: Entries of the merged case whose changes are incompatible: conflicts, although only one side changed
            each of them.
    """
    merger = _Merger(frozenset(opposed))
    data = _as_we_wrote(merger.merge(base, ours, theirs, ()), ours)
    return Merged(data, merger.conflicts)


@dataclass
class _Merger:
    opposed: frozenset[Path]
    conflicts: list[Conflict] = field(default_factory=list)

    def merge(self, base: Any, ours: Any, theirs: Any, path: Path) -> Any:
        if path in self.opposed:
            self.conflicts.append(Conflict(path, ours, theirs))
            return ours
        inside = any(other[: len(path)] == path for other in self.opposed)
        if not inside and (identical(ours, theirs) or identical(base, theirs)):
            return ours
        if not inside and identical(base, ours):
            return theirs
        if base is NOTHING and path in _CONTAINERS:
            base = {}
        if isinstance(base, dict) and isinstance(ours, dict) and isinstance(theirs, dict):
            if not is_another_kind(ours, theirs):
                return self.mappings(base, ours, theirs, path)
        elif _lists_of_collections(base, ours, theirs):
            rows = enumerate(zip(base, ours, theirs, strict=True))
            return [self.merge(*row, (*path, index)) for index, row in rows]
        # 1 and 1.0 are the same value.
        if same(ours, theirs) or same(base, theirs):
            return ours
        if same(base, ours):
            return theirs
        self.conflicts.append(Conflict(path, ours, theirs))
        return ours

    def mappings(self, base: dict[str, Any], ours: dict[str, Any], theirs: dict[str, Any], path: Path) -> Any:
        result = {}
        for key in dict.fromkeys([*ours, *theirs]):
            old, mine, others = (data.get(key, NOTHING) for data in (base, ours, theirs))
            value = self.merge(old, mine, others, (*path, key))
            if value is not NOTHING:
                result[key] = value
        return result


def _as_we_wrote(data: Any, ours: Any) -> Any:
    """Return the data with equal numbers as we wrote them, so that our text does not change."""
    if isinstance(data, dict) and isinstance(ours, dict):
        return {key: _as_we_wrote(value, ours.get(key, NOTHING)) for key, value in data.items()}
    if isinstance(data, list) and isinstance(ours, list) and len(data) == len(ours):
        return [_as_we_wrote(*pair) for pair in zip(data, ours, strict=True)]
    return ours if same(data, ours) else data


def _lists_of_collections(*values: Any) -> bool:
    return all(isinstance(value, list) for value in values) and (
        len({len(value) for value in values}) == 1
        and all(isinstance(item, dict | list) for value in values for item in value)
    )
