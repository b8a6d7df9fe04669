"""Targets of selectors in the resolved case: copies and links, with their start positions."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import product

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.selection import select
from text2sim.compiler.shapes.rotation import Vec
from text2sim.compiler.trees.tree import StandingLink, tree_links
from text2sim.lint.facts import Facts
from text2sim.spec_schema.models.base import listed
from text2sim.spec_schema.names.name_table import touching_parts
from text2sim.spec_schema.names.selectors import named_by

MAX_PAIRS = 2_000
"""Most pairs of bodies that a rule tests."""


@dataclass(frozen=True)
class StartTarget:
    """A copy, or a link of one."""

    copy: Copy
    link: str | None
    standing: StandingLink | None
    """The link whose frame represents it; None for a primitive of the engine."""
    known: bool
    """Whether its frame at the start is known: a model file may contain more than is read."""
    frame_moves: bool
    """Whether that link can move."""
    moves: bool
    """Whether any part of it can move."""
    driven: bool
    """Whether its motion is prescribed."""
    part: str | None = None
    """Part of a compound, of which only the contacts are known."""

    @property
    def origin(self) -> Vec:
        """Origin of its frame at the start [m]."""
        return self.copy.pos if self.standing is None else self.standing.pos

    @property
    def label(self) -> str:
        """Its selector."""
        part = self.part if self.link is None else self.link
        return self.copy.name if part is None else f"{self.copy.name}.{part}"


class Targets:
    """Targets of selectors, each looked up once, from `facts.once`."""

    def __init__(self, facts: Facts) -> None:
        self.facts = facts
        self._select = cache(self._look_up)

    def select(self, selectors: str | Sequence[str]) -> list[StartTarget]:
        """Return the targets of selectors, each once; none of one that has none, which is reported elsewhere."""
        found = [target for selector in listed(selectors) for target in self._select(selector)]
        return list({target.label: target for target in found}.values())

    def _look_up(self, selector: str) -> list[StartTarget]:
        try:
            copies, part = select(selector, self.facts.placed)
        except LookupError:
            return []
        return [self._target(copy, name) for copy in copies for name in self._names(copy, part)]

    def pairs(self, between: tuple[str, str], limit: int = MAX_PAIRS) -> list[tuple[StartTarget, StartTarget]] | None:
        """Return the pairs of different targets of two selectors; None if there may be more than `limit`."""
        first, second = (self.select(selector) for selector in between)
        if len(first) * len(second) > limit:
            return None
        return [(a, b) for a, b in product(first, second) if a.label != b.label]

    def _names(self, copy: Copy, part: str | None) -> list[str | None]:
        """Return the links or parts that a pattern matches; without one, the link itself, or None for the copy."""
        if part is not None and (parts := touching_parts(copy.model)):
            return [*named_by(part, parts)]
        tree = self.facts.tree(copy) if part is not None and "*" in part else None
        return [part] if tree is None or part is None else [*named_by(part, [link.name for link in tree.links()])]

    def _target(self, copy: Copy, part: str | None) -> StartTarget:
        if part is not None and touching_parts(copy.model):
            return replace(self._target(copy, None), part=part)
        tree, driven = self.facts.tree(copy), self.facts.mount(copy) == "driven"
        if self.facts.mount(copy) == "soft":  # its solver determines its centre of mass
            return StartTarget(copy, None, None, False, True, True, False)
        if tree is None or (part is None and getattr(copy.model, "kind", "") == "rigid"):  # of one link
            moves = self.facts.moves(copy)
            return StartTarget(copy, None, None, True, moves, moves, driven)
        links = tree_links(tree, copy.pos, copy.quat)
        chosen = [standing for standing in links if part is None or standing.link.name == part]
        # The engine numbers links in the order of the file, parents first: a body's frame is that of its first link.
        first = next((row for row in chosen if row.link.name == (part or tree.roots[0].name)), None)
        known = first is not None and getattr(copy.model, "file", None) is None
        moves = any(standing.moves for standing in chosen)
        return StartTarget(copy, part, first, known, first is None or first.moves, moves, driven)
