"""Placement: poses, relations and patterns become one list of copies for each body and static.

A pattern adds its offsets to its body's own position. If the pose differs from copy to copy, each offset is
added to the pose of its copy (`step: [0, 0, 0]` adds nothing). A `place` moves the pattern as a whole, by its
bounds, unless what it says about the position differs from copy to copy: then it places each copy by itself. If
its target has brackets, `plate[*]`, copies are paired one by one, and only the turns of the pattern count.
"""

import graphlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from text2sim.compiler.default_colors import STATIC_COLOR, default_colors
from text2sim.compiler.placing.arrangement import COPYWISE_KEYS, PlacementEntry, PlacementTargets, arrange
from text2sim.compiler.placing.divisions import part_rows
from text2sim.compiler.placing.patterns import MAX_COPIES, SINGLE, Variables, copy_count, copy_variables
from text2sim.compiler.placing.place_error import PatternError, PlaceError
from text2sim.compiler.shapes.extents import TreeExtents
from text2sim.compiler.shapes.rotation import IDENTITY, ORIGIN, Quaternion, Vec, frame_apply, quat_multiply
from text2sim.compiler.shapes.sizes import MAX_PIECES, CopySpot, SizeError, Sizes, TreePieces
from text2sim.spec_schema.errors import AssetError, Problem, SpecError, nearest
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.models.placement import RELATIONS
from text2sim.spec_schema.models.soft_bodies import Round
from text2sim.spec_schema.names.selectors import parse_selector

LinkFrames = Callable[[Any, Path], dict[str, tuple[Vec, Quaternion]]]
"""Frames [m] of the links of a body that is a tree of them, by name, at the start and in the body's frame."""


@dataclass(frozen=True, slots=True, eq=False)
class Copy:
    """One copy of a body or static, at its start. There is one object for each, so that `functools.cache` takes it."""

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
    color: str = STATIC_COLOR
    """Its colour, if the case gives none."""


def place_all(
    loaded: LoadedCase,
    tree_extents: TreeExtents | None = None,
    tree_pieces: TreePieces | None = None,
    link_frames: LinkFrames | None = None,
) -> tuple[dict[str, list[Copy]], list[Problem]]:
    """Return the copies of every static and body by name, and what is wrong with their places.

    What cannot be placed stays at the origin, so that the rest can still be checked.

    Args:
        loaded: The case.
        tree_extents: Bounds of chains, nets, ragdolls and articulated bodies; needed where `place` involves one.
        tree_pieces: Their pieces; without them, their bounds are used.
        link_frames: Where their links start; needed where `place` names a link.
    """
    return _Placer(loaded, Sizes(loaded.folder, tree_extents, tree_pieces), link_frames).place_all()


def file_path(model: Any) -> tuple[str, ...]:
    """Return the path in a body or static to what names its files."""
    if getattr(getattr(model, "shape", None), "file", None) is not None:
        return "shape", "file"
    return next(((key,) for key in ("shape", "file") if getattr(model, key, None) is not None), ())


class _UnplacedError(Exception):
    """The target itself has no place, which has already been reported."""


class _Placer:
    def __init__(self, loaded: LoadedCase, sizes: Sizes, link_frames: LinkFrames | None) -> None:
        self.loaded, self.link_frames = loaded, link_frames
        self.targets = PlacementTargets(self._find, sizes)
        self.problems: list[Problem] = []
        self.copies: dict[str, list[Copy]] = {}
        self.failed: set[str] = set()
        """Names without a place; what is placed in relation to them is not reported too."""
        self.colors = default_colors(loaded.case)
        self.total = 0
        """Copies that are to be placed."""

    def place_all(self) -> tuple[dict[str, list[Copy]], list[Problem]]:
        entries: dict[str, PlacementEntry] = {}
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

    def _entry(self, name: str, root: tuple[str, ...], model: Any, copy: Callable[..., Any]) -> PlacementEntry:
        if model.pose is not None and model.place is not None:
            self._report(root, "give either pose or place, not both", "inconsistent")
        single = PlacementEntry(name, root, model, None, [SINGLE], [model])
        if model.repeat is None:
            return single
        try:
            parts = part_rows(model, self.loaded.folder)
        except (PatternError, AssetError) as error:
            where = error.where if isinstance(error, PatternError) else ("shape",)
            self._report((*root, *where), error, "asset" if isinstance(error, AssetError) else "placement")
            return single
        count = copy_count(model.repeat, parts)
        if count > MAX_COPIES:
            message = f"makes {count} copies; at most {MAX_COPIES} are possible"
            self._report((*root, "repeat"), message, "too-many-copies")
            return single
        self.total += count
        if self.total > MAX_PIECES:
            # Each copy is at least one piece, so this is known before they are placed.
            if self.total - count <= MAX_PIECES:
                message = f"with this, the scene has more than {MAX_PIECES:,} convex pieces, too many for the engine"
                self.problems.append(self.loaded.problem(root, message, key=True, rule="too-many"))
            return single
        variables = copy_variables(model.repeat, parts)
        if not self.loaded.varies(root):
            return PlacementEntry(name, root, model, model.repeat, variables, [model] * count)
        models = []
        for one in variables:
            try:
                models.append(copy(name, one))
            except SpecError as error:
                # One copy is enough to see what is wrong with the expression.
                self.problems += error.problems
                models += [model] * (count - len(models))
                break
        alone = any(self.loaded.varies((*root, "place", key)) for key in (*RELATIONS, *COPYWISE_KEYS))
        return PlacementEntry(name, root, model, model.repeat, variables, models, alone)

    def _order(self, entries: dict[str, PlacementEntry]) -> Iterator[str]:
        """Yield the names, each after those that it is placed in relation to, or faces."""
        needs: dict[str, set[str]] = {}
        for name, entry in entries.items():
            places = [model.place for model in entry.models if model.place is not None] if entry.model.place else []
            words = {word for place in places for word in (place.target, place.facing) if isinstance(word, str)}
            words |= {item.round for model in entry.models for item in getattr(model, "along", None) or ()
                      if isinstance(item, Round)}  # fmt: skip
            needs[name] = {target for word in words if (target := parse_selector(word).body) in entries}
        while True:
            try:
                yield from graphlib.TopologicalSorter(needs).static_order()
                return
            except graphlib.CycleError as error:
                cycle: list[str] = error.args[1][::-1]
                first = min(range(len(cycle) - 1), key=lambda k: list(entries).index(cycle[k]))
                cycle = cycle[first:-1] + cycle[:first]
                name = cycle[0]
                shown = " -> ".join([*cycle, name])
                message = f"is placed in relation to itself: {shown}; give one of them a pose, or place it by another"
                self._report((*entries[name].root, "place"), message, "circular-place")
                for member in cycle:
                    needs[member] -= set(cycle)

    def _place(self, entry: PlacementEntry) -> list[Copy]:
        model, root, name = entry.model, entry.root, entry.name
        spots = [CopySpot(ORIGIN, IDENTITY, getattr(one, "shape", None), one) for one in entry.models]
        self.failed.add(name)
        try:
            spots = [self._laid(spot) for spot in arrange(entry, self.targets)]
            self.failed.discard(name)
        except _UnplacedError:
            pass
        except PlaceError as error:
            self._report((*root, "place", error.key), error, error.rule, error.hint)
        except PatternError as error:
            self._report((*root, *error.where), error)
        except SizeError as error:
            self._report((*root, "place" if model.place else "repeat"), error)
        except AssetError as error:
            self._report((*root, *file_path(model)), error, "asset")
        rest = self.loaded.line(root), self.colors[name]
        if entry.repeat is None:
            return [Copy(name, name, None, SINGLE, spots[0].model, spots[0].pos, spots[0].quat, spots[0].shape, *rest)]
        return [
            Copy(f"{name}[{i}]", name, i, variables, spot.model, spot.pos, spot.quat, spot.shape, *rest)
            for i, (variables, spot) in enumerate(zip(entry.variables, spots, strict=True))
        ]

    def _laid(self, spot: CopySpot) -> CopySpot:
        if getattr(spot.model, "along", None) is None:
            return spot
        from text2sim.compiler.placing.rope_path import lay_rope  # needs arrays, which most cases do without

        model = lay_rope(spot.model, spot.pos, spot.quat, lambda selector: self._find(selector, "along"))
        return spot._replace(model=model)

    def _find(self, selector: str, key: str) -> list[CopySpot]:
        """Return the copies that a selector means."""
        chosen = parse_selector(selector)
        name = chosen.body
        if name in self.failed:
            raise _UnplacedError
        if name not in self.copies:
            known = [*self.loaded.case.scene.statics, *self.loaded.case.bodies]
            if name in known:
                raise _UnplacedError
            raise PlaceError(f"there is no body or static `{name}`", key, "unknown-name", nearest(name, known))
        copies = self.copies[name]
        if chosen.first is not None:
            copies = copies[chosen.first : chosen.last]
        if not copies:
            raise PlaceError(f"`{selector}` is none of the {len(self.copies[name])} copies of `{name}`", key)
        spots = [CopySpot(c.pos, c.quat, c.shape, c.model) for c in copies]
        if chosen.part is None:
            return spots
        links = getattr(spots[0].model, "links", None)  # of a chain, their number
        if self.link_frames is None or not isinstance(links, dict) or chosen.part not in links:
            text = f"`{selector}` has no shape in the case, as links of an articulated body have"
            raise PlaceError(f"{text}; place in relation to the whole body `{name}`", key)
        return [self._link_spot(spot, chosen.part, self.link_frames) for spot in spots]

    def _link_spot(self, spot: CopySpot, part: str, link_frames: LinkFrames) -> CopySpot:
        """Return a link of an articulated body as if it were a body of its own, where it starts."""
        pos, quat = link_frames(spot.model, self.loaded.folder)[part]
        link = spot.model.links[part]
        return CopySpot(frame_apply(spot.pos, spot.quat, pos), quat_multiply(spot.quat, quat), link.shape, link)
