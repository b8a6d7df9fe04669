"""Where everything starts: poses, relations and patterns become one list of copies for each body and static.

A pattern adds its offsets to its body's own position. If the pose differs from copy to copy, each copy's
own pose is what its offset is added to (`step: [0, 0, 0]` adds nothing). A `place` moves the pattern as a
whole, by its bounds; only if its relation, `at`, `direction` or `clearance` differ from copy to copy is
each copy placed by itself.
"""

import graphlib
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from text2sim.compiler.geometry import TreeExtents
from text2sim.compiler.patterns import (
    MAX_COPIES,
    SINGLE,
    Variables,
    copy_count,
    copy_variables,
    pattern_middle,
)
from text2sim.compiler.relations import ORIGIN, Group, PlaceError, settle
from text2sim.compiler.rotation import IDENTITY, Quaternion, Vec, quat_of
from text2sim.compiler.sizes import SizeError, Sizes, Spot
from text2sim.compiler.spread import PatternError, spread
from text2sim.spec_schema.errors import AssetError, Problem, SpecError, nearest
from text2sim.spec_schema.load import LoadedCase
from text2sim.spec_schema.placement import RELATIONS, Line, Packing, Place, Repeat

_SELECTOR = re.compile(r"(\w+)(?:\[(?:(\d+)|\*|(\d+):(\d+))\])?(\.\w+)?\Z")
_OWN = (*RELATIONS, "at", "clearance", "direction")


@dataclass(frozen=True, slots=True)
class Copy:
    """One copy of a body or static, at its start."""

    name: str
    """`ball`, or `brick[3]`."""
    body: str
    """`brick`"""
    index: int | None
    """Number of the copy; None without `repeat`."""
    variables: Variables
    """`i`, `n`, `u`, `row`, `column`, `layer`."""
    model: Any
    """The validated body or static, as this copy has it."""
    pos: Vec
    """[m]"""
    quat: Quaternion
    """Unit length."""
    shape: Any
    """Shape of this copy: half boxes of a running bond differ from the model's. None for trees of links."""
    line: int
    """Line in the case's file."""


@dataclass(slots=True)
class _Entry:
    name: str
    root: tuple[str, ...]
    model: Any
    repeat: Repeat | None
    variables: list[Variables]
    models: list[Any]


def place_all(
    loaded: LoadedCase, tree_extents: TreeExtents | None = None
) -> tuple[dict[str, list[Copy]], list[Problem]]:
    """Return the copies of every static and body by name, and everything that is wrong with their places.

    What cannot be placed stays at the origin, so that the rest can still be checked.

    Args:
        loaded: The case. tree_extents: Bounds of chains, nets, ragdolls and articulated bodies; needed
        where `place` involves one.
    """
    return _Placer(loaded, tree_extents).place_all()


class _UnplacedError(Exception):
    """The target is part of a circle, which is reported already."""


class _Placer:
    def __init__(self, loaded: LoadedCase, tree_extents: TreeExtents | None) -> None:
        self.loaded = loaded
        self.sizes = Sizes(loaded.folder, tree_extents)
        self.problems: list[Problem] = []
        self.copies: dict[str, list[Copy]] = {}
        self.groups: dict[str, Group] = {}

    def place_all(self) -> tuple[dict[str, list[Copy]], list[Problem]]:
        entries: dict[str, _Entry] = {}
        for name, static in self.loaded.case.scene.statics.items():
            entries[name] = self._entry(name, ("scene", "statics", name), static, self.loaded.static_copy)
        for name, body in self.loaded.case.bodies.items():
            if name in entries:
                message = f"`{name}` is the name of a static, too; a name stands for one thing"
                self.problems.append(self.loaded.problem(("bodies", name), message, key=True, rule="duplicate-name"))
            entries[name] = self._entry(name, ("bodies", name), body, self.loaded.body_copy)
        for name in self._order(entries):
            self.copies[name] = self._place(entries[name])
        return {name: self.copies[name] for name in entries}, self.problems

    def _report(
        self, where: tuple[str, ...], error: Exception | str, rule: str = "placement", hint: str | None = None
    ) -> None:
        self.problems.append(self.loaded.problem(where, str(error), rule=rule, hint=hint))

    def _entry(self, name: str, root: tuple[str, ...], model: Any, copy: Callable[..., Any]) -> _Entry:
        if model.pose is not None and model.place is not None:
            self._report(root, "give either pose or place, not both", "inconsistent")
        if model.repeat is None:
            return _Entry(name, root, model, None, [SINGLE], [model])
        count = copy_count(model.repeat)
        if count > MAX_COPIES:
            self._report(
                (*root, "repeat"),
                f"makes {count} copies; at most {MAX_COPIES} are possible",
                "too-many-copies",
            )
            return _Entry(name, root, model, None, [SINGLE], [model])
        variables = copy_variables(model.repeat)
        if not self.loaded.varies(root):
            return _Entry(name, root, model, model.repeat, variables, [model] * count)
        models = []
        for one in variables:
            try:
                models.append(copy(name, one))
            except SpecError as error:
                # One copy is enough to see what is wrong with the expression.
                self.problems += error.problems
                models += [model] * (count - len(models))
                break
        return _Entry(name, root, model, model.repeat, variables, models)

    def _order(self, entries: dict[str, _Entry]) -> Iterator[str]:
        """Names in such an order that everything comes after what it is placed in relation to."""
        needs: dict[str, set[str]] = {}
        for name, entry in entries.items():
            targets = {m.place.target for m in entry.models if m.place is not None} if entry.model.place else set()
            needs[name] = {target for selector in targets if (target := _name_of(selector)) in entries}
        while True:
            try:
                yield from graphlib.TopologicalSorter(needs).static_order()
                return
            except graphlib.CycleError as error:
                cycle: list[str] = error.args[1][::-1]
                name = min(cycle, key=list(entries).index)
                way = " -> ".join(cycle)
                self._report(
                    (*entries[name].root, "place"),
                    f"is placed in relation to itself: {way}",
                    "circular-place",
                )
                for one in cycle:
                    needs[one] -= set(cycle)

    def _place(self, entry: _Entry) -> list[Copy]:
        model, root, name = entry.model, entry.root, entry.name
        start = [Spot(ORIGIN, IDENTITY, getattr(one, "shape", None), one) for one in entry.models]
        spots = start
        try:
            spots = self._spots(entry, start)
        except _UnplacedError:
            pass
        except PlaceError as error:
            self._report((*root, "place", error.key), error, error.rule, error.hint)
        except PatternError as error:
            self._report((*root, *error.where), error)
        except SizeError as error:
            self._report((*root, "place" if model.place else "repeat"), error)
        except AssetError as error:
            key = next((key for key in ("shape", "file") if getattr(model, key, None) is not None), None)
            self._report((*root, key) if key else root, error, "asset")
        line = self.loaded.line(root)
        if entry.repeat is None:
            return [Copy(name, name, None, SINGLE, model, spots[0].pos, spots[0].quat, spots[0].shape, line)]
        return [
            Copy(f"{name}[{i}]", name, i, variables, spot.model, spot.pos, spot.quat, spot.shape, line)
            for i, (variables, spot) in enumerate(zip(entry.variables, spots, strict=True))
        ]

    def _spots(self, entry: _Entry, spots: list[Spot]) -> list[Spot]:
        """The copies where they start; they come upright at the origin."""
        model, repeat, place = entry.model, entry.repeat, entry.model.place
        own = place is not None and any(self.loaded.varies((*entry.root, "place", key)) for key in _OWN)
        if place is not None and isinstance(repeat, Packing):
            raise PatternError("a packing lies in its region, which is in the world; leave out `place`", "place")
        if place is not None and isinstance(repeat, Line) and repeat.start is not None:
            raise PatternError("a line with a `start` has its place; leave out `start` or `place`", "place")
        spots = _turned(spots)
        if own:
            spots = [_moved(spot, self._shift(spot.model.place, [spot], ORIGIN)) for spot in spots]
        elif model.pose is not None:
            spots = [spot._replace(pos=spot.model.pose.pos) for spot in spots]
        if repeat is not None:
            spots = spread(repeat, spots, self.sizes)
        if place is None or own:
            return spots
        middle = ORIGIN if repeat is None else pattern_middle(repeat)
        shift = self._shift(place, spots, middle)
        return [_moved(spot, shift) for spot in spots]

    def _shift(self, place: Place, spots: list[Spot], middle: Vec) -> Vec:
        target = self.groups.get(place.target)
        if target is None:
            target = self.groups[place.target] = Group(self._members(place.target, place.relation), self.sizes)
        return settle(place, Group(spots, self.sizes), target, middle)

    def _members(self, selector: str, key: str) -> list[Spot]:
        """The copies that a selector means."""
        found = _SELECTOR.match(selector)
        if found is None or found[1] not in self.copies:
            known = [*self.loaded.case.scene.statics, *self.loaded.case.bodies]
            name = _name_of(selector)
            if name in known:
                raise _UnplacedError
            raise PlaceError(f"there is no body or static `{name}`", key, "unknown-name", nearest(name, known))
        name, index, first, last, link = found.groups()
        copies = self.copies[name]
        if link:
            raise PlaceError(f"`{selector}` is a link; place in relation to the whole body `{name}`", key)
        if index is not None:
            copies = copies[int(index) : int(index) + 1]
        elif first is not None:
            copies = copies[int(first) : int(last)]
        if not copies:
            raise PlaceError(f"`{selector}` is none of the {len(self.copies[name])} copies of `{name}`", key)
        return [Spot(c.pos, c.quat, c.shape, c.model) for c in copies]


def _turned(spots: list[Spot]) -> list[Spot]:
    """The copies in the orientation of their poses and places."""
    found: list[Spot] = []
    before, quat = None, IDENTITY
    for spot in spots:
        if spot.model is not before:
            before = spot.model
            where = before.pose or before.place
            try:
                quat = IDENTITY if where is None else quat_of(where)
            except ValueError as error:
                raise PlaceError(str(error), "quat") from None
        found.append(spot if quat == IDENTITY else spot._replace(quat=quat))
    return found


def _name_of(selector: str) -> str:
    return re.split(r"[\[.]", selector, maxsplit=1)[0]


def _moved(spot: Spot, shift: Vec) -> Spot:
    (x, y, z), (a, b, c) = spot.pos, shift
    return spot._replace(pos=(x + a, y + b, z + c))
