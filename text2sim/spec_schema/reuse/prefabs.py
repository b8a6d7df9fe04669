"""Expansion of prefabs.

An entry `{use: cup, with: {height: 0.2}, place: …}` becomes the body of the prefab, with arguments in place of
parameters in every `${…}`, and with the other keys of the entry merged into it.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import reduce
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, get_args, get_origin

from text2sim.spec_schema.arithmetic.values import ExpressionError
from text2sim.spec_schema.errors import Problem, nearest
from text2sim.spec_schema.models.base import Selector
from text2sim.spec_schema.reuse.arguments import Argument, locate
from text2sim.spec_schema.reuse.binding import RefusedUse, bind_all
from text2sim.spec_schema.reuse.filling import Filler, settle
from text2sim.spec_schema.reuse.library import Definition, MissingPrefab, PrefabLibrary, named
from text2sim.spec_schema.reuse.substitution import BoundParameter
from text2sim.spec_schema.reuse.trees import LocatedValue, count, mapping, merge, put
from text2sim.spec_schema.text.document import MAX_NODES, Document, Node, Origin, Path, mapping_at, sites_of, value_at
from text2sim.spec_schema.vocabulary.slot_path import mapping_slots
from text2sim.spec_schema.vocabulary.slots import ENTRY
from text2sim.spec_schema.vocabulary.words import LanguageSlot, noun_of, show, slot_of

_NOUN = noun_of(slot_of(Selector))
_FIRST = re.compile(r"[A-Za-z][A-Za-z0-9_]*(?=$|[.\[])")


if TYPE_CHECKING:
    from text2sim.spec_schema.reuse.layers import Layers

MAX_DEPTH = 8
"""Most levels of prefabs that use prefabs."""
MAX_USES = 2000
"""Most uses in a case."""
MAX_VALUES = 100_000
"""Most values from prefabs."""
MAX_TEXT = 200_000
"""Most characters of composed expressions."""
_SEVERAL = "this prefab has several bodies, but a static is one body"
_FREE = ("density", "mass")
"""Fields of a material that statics do not have."""


def expand(layers: "Layers", folder: FilePath) -> None:
    """Expand all uses in the `document` of layers.

    Problems are added to those of the layers; an entry that cannot be expanded is left out.
    """
    work = _Expansion(layers.document, PrefabLibrary(layers.document, folder))
    tree = work.run()
    layers.problems += work.problems
    layers.arguments += work.arguments
    layers.failed = work.failed
    layers.document = replace(layers.document, data=tree.data, root=tree.node, composed=work.composed(tree.data))


@dataclass(frozen=True)
class Site:
    """The entry of the case with a use."""

    path: Path
    node: Node
    """Its position."""

    @property
    def name(self) -> str:
        """Its name."""
        return str(self.path[-1])


@dataclass
class _Expansion:
    document: Document
    library: PrefabLibrary
    problems: list[Problem] = field(default_factory=list)
    arguments: list[Argument] = field(default_factory=list)
    failed: bool = False
    roots: list[Path] = field(default_factory=list)
    uses: int = 0
    reported: set[str] = field(default_factory=set)
    """Invalid prefabs whose problems are already reported."""

    def __post_init__(self) -> None:
        self.filler = Filler(min(MAX_VALUES, MAX_NODES - count(self.document.data)), MAX_TEXT)

    def run(self) -> LocatedValue:
        tree = LocatedValue(self.document.data, self.document.root)
        self.problems += self.library.own_problems()
        for section in (("scene", "statics"), ("bodies",)):
            entries = reduce(mapping_at, section, tree.data)
            if any(isinstance(entry, dict) and "use" in entry for entry in entries.values()):
                tree = put(tree, section, self._section(tree.at(section), section))
        return tree

    def composed(self, data: Any) -> frozenset[Path]:
        """Return the paths of the expressions in expanded entries."""
        found: set[Path] = set()
        for root in self.roots:
            found |= sites_of(value_at(data, root), root).keys()
        return frozenset(found)

    def _section(self, section: LocatedValue, path: Path) -> LocatedValue:
        parts: dict[str, LocatedValue] = {}
        keys: dict[str, tuple[int, int]] = {}
        taken = {name for name, entry in section.data.items() if not (isinstance(entry, dict) and "use" in entry)}
        for name in section.data:
            if name in taken:
                parts[name], keys[name] = section.child(name), section.node.keys[name]
                continue
            line, column = section.node.keys[name]
            site = Site((*path, name), Node(line, column))
            for made_name, body in self._entry(section.child(name), site).items():
                if made_name in taken or made_name in parts:
                    message = f"`{made_name}` already exists"
                    self.problems.append(self._problem(site.node, site.path, message, "duplicate-name"))
                    continue
                parts[made_name], keys[made_name] = body, (line, column)
                self.roots.append((*path, made_name))
        return mapping(section.node, parts, keys)

    def _entry(self, entry: LocatedValue, site: Site) -> dict[str, LocatedValue]:
        """Return the bodies of an entry, by name; none if it has problems."""
        first = len(self.arguments)
        try:
            expanded = self._use(entry, site, (), static=site.path[0] == "scene")
        except RefusedUse as refused:
            self.problems += refused.problems
            self.failed = True
            del self.arguments[first:]
            return {}
        roots = tuple((*site.path[:-1], name) for name in expanded)
        self.arguments[first:] = [replace(argument, roots=roots) for argument in self.arguments[first:]]
        return {name: settle(body) for name, body in expanded.items()}

    def _use(
        self, entry: LocatedValue, site: Site, outer: tuple[str, ...], *, static: bool = False
    ) -> dict[str, LocatedValue]:
        """Expand one use, and those inside it.

        Args:
            entry: The entry, whose own expressions are those of the case.
            site: The entry of the case.
            outer: Names of the enclosing prefabs.
            static: Whether it is a static.
        """
        use = entry.child("use")
        definition = self._definition(use, site, outer)
        inside = (*outer, definition.name)
        bound = bind_all(self.document, entry, definition, site.path, self.filler)
        self.arguments += bound.arguments
        keys = {key: entry.child(key) for key in entry.data if key not in ("use", "with")}
        over = mapping(entry.node, keys, entry.node.keys)
        bodies = {
            part: self._filled(body, definition, bound.values, use, site.path)
            for part, body in definition.bodies.items()
        }
        if None in bodies:
            return self._single(bodies[None], over, site, inside, static=static)
        if static:
            raise self._refused(use, site.path, _SEVERAL)
        return self._several({str(part): body for part, body in bodies.items()}, over, site, inside)

    def _filled(
        self,
        body: LocatedValue,
        definition: Definition,
        values: Mapping[str, BoundParameter],
        use: LocatedValue,
        path: Path,
    ) -> LocatedValue:
        """Return a body of a prefab with arguments in place of parameters, at the position of its use."""
        node = use.node

        def place(found: Node) -> Origin:
            return Origin(f"in prefab `{definition.name}`", definition.place, found.line, node.origin)

        try:
            return self.filler.fill(body, values, (node.line, node.column), place)
        except ExpressionError as error:
            # The message already has the position in the prefab.
            plain = LocatedValue(use.data, Node(node.line, node.column))
            raise self._refused(plain, path, str(error), error.rule, error.hint) from None

    def _single(
        self, body: LocatedValue, over: LocatedValue, site: Site, inside: tuple[str, ...], *, static: bool = False
    ) -> dict[str, LocatedValue]:
        if "use" in body.data:
            expanded = self._use(body, site, inside)
            if set(expanded) != {site.name}:
                if static:
                    raise self._refused(over, site.path, _SEVERAL)
                return self._laid_over_parts(expanded, over, site)
            body = expanded[site.name]
        if static:
            body = self._still(body, site, over)
        return {site.name: merge(body, over, site.path) if over.data else body}

    def _several(
        self, bodies: dict[str, LocatedValue], over: LocatedValue, site: Site, inside: tuple[str, ...]
    ) -> dict[str, LocatedValue]:
        names = {part: f"{site.name}_{part}" for part in bodies}
        expanded: dict[str, LocatedValue] = {}
        for part, body in bodies.items():
            inner = replace(site, path=(*site.path[:-1], names[part]))
            expanded |= self._single(renamed(body, names), mapping(over.node, {}), inner, inside)
        return self._laid_over_parts(expanded, over, site)

    def _laid_over_parts(
        self, made: dict[str, LocatedValue], over: LocatedValue, site: Site
    ) -> dict[str, LocatedValue]:
        """Merge the other keys of a use, which are the names of parts, into its bodies."""
        known = [name.removeprefix(f"{site.name}_") for name in made]
        problems = []
        for key in over.data:
            if key not in known:
                message = f"unknown key `{key}`; the keys beside use and with are its parts: {', '.join(known)}"
                place, hint = Node(*over.node.keys[key]), nearest(key, [*known, "use", "with"])
                problems.append(self._problem(place, (*site.path, key), message, "unknown-key", hint))
                continue
            name = f"{site.name}_{key}"
            if over.data[key] is None:
                del made[name]
            else:
                made[name] = merge(made[name], over.child(key), (*site.path[:-1], name))
        if problems:
            raise RefusedUse(problems)
        return made

    def _still(self, body: LocatedValue, site: Site, over: LocatedValue) -> LocatedValue:
        """Return a body as a static: without the fields of moving bodies."""
        kind = body.data.get("kind")
        if kind != "rigid":
            found = f"`kind: {kind}`" if isinstance(kind, str) else show(kind)
            message = f"a static can only use a prefab with a body of `kind: rigid` (this one is {found})"
            raise RefusedUse([self._problem(over.node, site.path, message, "static")])
        kept = {key: body.child(key) for key in body.data if key not in ("kind", "mount")}
        material = kept.get("material")
        if material is not None and isinstance(material.data, dict):
            rest = {key: material.child(key) for key in material.data if key not in _FREE}
            kept["material"] = mapping(material.node, rest)
        return mapping(body.node, kept)

    def _definition(self, use: LocatedValue, site: Site, outer: tuple[str, ...]) -> Definition:
        self.uses += 1
        if self.uses > MAX_USES:
            raise self._refused(use, site.path, f"the case uses prefabs more than {MAX_USES} times", "too-large")
        if not isinstance(use.data, str):
            raise self._refused(use, (*site.path, "use"), f"needs the name of a prefab (got {show(use.data)})", "type")
        if "${" in use.data:
            raise self._refused(use, (*site.path, "use"), "the name of a prefab cannot be an expression", "type")
        if use.data in outer:
            cycle = " → ".join([*outer[outer.index(use.data) :], use.data])
            raise self._refused(use, (*site.path, "use"), f"prefabs use each other in a cycle: {cycle}", "circular-use")
        if len(outer) >= MAX_DEPTH:
            raise self._refused(use, site.path, f"prefabs use each other more than {MAX_DEPTH} deep", "too-deep")
        try:
            return self.library.find(use.data)
        except MissingPrefab as missing:
            if missing.problems:
                # Problems of a prefab in the case itself are reported whether it is used or not.
                own = missing.problems[0].file == self.document.source.file
                known = own or use.data in self.reported
                self.reported.add(use.data)
                raise RefusedUse([] if known else named(missing.problems, f"`{site.name}`")) from None
            raise self._refused(use, (*site.path, "use"), str(missing), "unknown-prefab", missing.hint) from None

    def _refused(
        self, tree: LocatedValue, path: Path, message: str, rule: str = "prefab", hint: str | None = None
    ) -> RefusedUse:
        return RefusedUse([self._problem(tree.node, path, message, rule, hint)])

    def _problem(self, node: Node, path: Path, message: str, rule: str, hint: str | None = None) -> Problem:
        return locate(self.document, path, node, message, rule=rule, hint=hint)


def renamed(body: LocatedValue, names: Mapping[str, str]) -> LocatedValue:
    """Return a body of a prefab with the names of the case in its selectors.

    Args:
        body: The body.
        names: Name in the case by name in the prefab.
    """
    return _renamed(body, [ENTRY], names)


def _renamed(tree: LocatedValue, slots: list[LanguageSlot], names: Mapping[str, str]) -> LocatedValue:
    data = tree.data
    if isinstance(data, dict):
        found = mapping_slots(slots, [data], ())
        inner = {key: found.inner(key) or [] for key in data}
        if not any(inner.values()):
            return tree
        return mapping(tree.node, {key: _renamed(tree.child(key), inner[key], names) for key in data})
    if isinstance(data, str) and any(_takes_selector(slot) for slot in slots):
        first = _FIRST.match(data)
        if first is not None and first[0] in names:
            return LocatedValue(names[first[0]] + data[first.end() :], tree.node)
    return tree


def _takes_selector(slot: LanguageSlot) -> bool:
    return any(
        noun_of(member) == _NOUN
        or (get_origin(member.base) is list and _takes_selector(slot_of(get_args(member.base)[0])))
        for member in slot.members
    )
