"""Prefabs expanded: after this, a case is an ordinary one.

An entry `{use: cup, with: {height: 0.2}, place: …}` becomes the body of the prefab, with arguments in the place of
parameters in every `${…}`, and with whatever else the entry says laid over it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

from text2sim.spec_schema.arithmetic.values import ExpressionError
from text2sim.spec_schema.errors import Problem, nearest
from text2sim.spec_schema.reuse.arguments import Argument
from text2sim.spec_schema.reuse.binding import RefusedUse, bind_all
from text2sim.spec_schema.reuse.filling import Filler, settle
from text2sim.spec_schema.reuse.library import Definition, MissingPrefab, PrefabLibrary, named
from text2sim.spec_schema.reuse.selector_names import renamed
from text2sim.spec_schema.reuse.substitution import BoundParameter
from text2sim.spec_schema.reuse.trees import LocatedValue, count, mapping, merge, put
from text2sim.spec_schema.text.document import MAX_NODES, Document, Node, Origin, Path, pointer, sites_of
from text2sim.spec_schema.vocabulary.words import show

if TYPE_CHECKING:
    from text2sim.spec_schema.reuse.layers import Layers

MAX_DEPTH = 8
"""As deep may prefabs use prefabs."""
MAX_USES = 2000
"""As many uses may a case come to."""
MAX_VALUES = 100_000
"""As many values may come from prefabs."""
MAX_TEXT = 200_000
"""As many characters may the expressions have that were put together."""
_SEVERAL = "this prefab has several bodies, and a static is one"
_FREE = ("density", "mass")
"""Fields of a material that mean nothing for what never moves."""


def expand(layers: "Layers", folder: FilePath) -> None:
    """Replace the `document` of layers by one in which nothing is used any more.

    What is wrong is added to their problems; an entry that cannot be expanded is left out.
    """
    work = _Expansion(layers.document, PrefabLibrary(layers.document, folder))
    tree = work.run()
    layers.problems += work.problems
    layers.arguments += work.arguments
    layers.failed = work.failed
    layers.document = replace(layers.document, data=tree.data, root=tree.node, roomy=work.roomy(tree.data))


@dataclass(frozen=True)
class Site:
    """The entry of the case that brings something in."""

    path: Path
    node: Node
    """Its place."""

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
    told: set[str] = field(default_factory=set)
    """Broken prefabs that are reported already."""

    def __post_init__(self) -> None:
        self.filler = Filler(min(MAX_VALUES, MAX_NODES - count(self.document.data)), MAX_TEXT)

    def run(self) -> LocatedValue:
        tree = LocatedValue(self.document.data, self.document.root)
        self.problems += self.library.own()
        for section in (("scene", "statics"), ("bodies",)):
            inner = tree
            for step in section:
                inner = (
                    inner.child(step)
                    if isinstance(inner.data, dict) and step in inner.data
                    else LocatedValue(None, inner.node)
                )
            if isinstance(inner.data, dict) and any(isinstance(e, dict) and "use" in e for e in inner.data.values()):
                tree = put(tree, section, self._section(inner, section))
        return tree

    def roomy(self, data: Any) -> frozenset[Path]:
        """Paths of the expressions that came in."""
        found: set[Path] = set()
        for root in self.roots:
            value = data
            for step in root:
                value = value[step]
            found |= sites_of(value, root).keys()
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
            made = self._entry(section.child(name), Site((*path, name), Node(line, column)))
            for made_name, body in made.items():
                if made_name in taken or made_name in parts:
                    self.report(
                        Site((*path, name), Node(line, column)), f"`{made_name}` is there already", "duplicate-name"
                    )
                    continue
                parts[made_name], keys[made_name] = body, (line, column)
                self.roots.append((*path, made_name))
        return mapping(section.node, parts, keys)

    def report(self, site: Site, message: str, rule: str, hint: str | None = None) -> None:
        file = self.document.source.file
        self.problems.append(Problem(pointer(site.path), message, site.node.line, site.node.column, file, hint, rule))

    def _entry(self, entry: LocatedValue, site: Site) -> dict[str, LocatedValue]:
        """Bodies that an entry becomes, by name; none if something is wrong with it."""
        first = len(self.arguments)
        try:
            made = self._use(entry, site, (), static=site.path[0] == "scene")
        except RefusedUse as refused:
            self.problems += refused.problems
            self.failed = True
            del self.arguments[first:]
            return {}
        roots = tuple((*site.path[:-1], name) for name in made)
        self.arguments[first:] = [replace(argument, roots=roots) for argument in self.arguments[first:]]
        return {name: settle(body) for name, body in made.items()}

    def _use(
        self, entry: LocatedValue, site: Site, outer: tuple[str, ...], *, static: bool = False
    ) -> dict[str, LocatedValue]:
        """Expand one use, and those inside it.

        Args:
            entry: The entry, whose own expressions are those of the case.
            site: Where it is, or what brought it in.
            outer: Names of the prefabs that it is in.
            static: Whether it shall be a static.
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
        """A body of a prefab with arguments in the place of parameters, at the place of its use."""
        node = use.node

        def place(found: Node) -> Origin:
            return Origin(f"in prefab `{definition.name}`", definition.place, found.line, node.origin)

        try:
            return self.filler.fill(body, values, (node.line, node.column), place)
        except ExpressionError as error:
            # The message says already where in the prefab it is.
            plain = LocatedValue(use.data, Node(node.line, node.column))
            raise self._refused(plain, path, str(error), error.rule, error.hint) from None

    def _single(
        self, body: LocatedValue, over: LocatedValue, site: Site, inside: tuple[str, ...], *, static: bool = False
    ) -> dict[str, LocatedValue]:
        if "use" in body.data:
            made = self._use(body, site, inside)
            if set(made) != {site.name}:
                if static:
                    raise self._refused(over, site.path, _SEVERAL)
                return self._laid_over_parts(made, over, site)
            body = made[site.name]
        if static:
            body = self._still(body, site, over)
        return {site.name: merge(body, over, site.path) if over.data else body}

    def _several(
        self, bodies: dict[str, LocatedValue], over: LocatedValue, site: Site, inside: tuple[str, ...]
    ) -> dict[str, LocatedValue]:
        names = {part: f"{site.name}_{part}" for part in bodies}
        made: dict[str, LocatedValue] = {}
        for part, body in bodies.items():
            inner = replace(site, path=(*site.path[:-1], names[part]))
            made |= self._single(renamed(body, names), mapping(over.node, {}), inner, inside)
        return self._laid_over_parts(made, over, site)

    def _laid_over_parts(
        self, made: dict[str, LocatedValue], over: LocatedValue, site: Site
    ) -> dict[str, LocatedValue]:
        """Lay what stands beside a use over the bodies that it became: each key is the name of a part."""
        known = [name.removeprefix(f"{site.name}_") for name in made]
        problems = []
        for key in over.data:
            if key not in known:
                line, column = over.node.keys[key]
                message = f"unknown key `{key}`; beside use and with stand the names of its parts: {', '.join(known)}"
                file, path = self.document.source.file, pointer((*site.path, key))
                hint = nearest(key, [*known, "use", "with"])
                problems.append(Problem(path, message, line, column, file, hint, "unknown-key"))
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
        """A body as a static: without what is only said of what moves."""
        kind = body.data.get("kind")
        if kind != "rigid":
            found = f"`kind: {kind}`" if isinstance(kind, str) else show(kind)
            message = f"a static can use a prefab whose body is `kind: rigid` (this one is {found})"
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
            raise self._refused(use, site.path, f"with this, prefabs are used more than {MAX_USES} times", "too-large")
        if not isinstance(use.data, str):
            raise self._refused(use, (*site.path, "use"), f"needs the name of a prefab (got {show(use.data)})", "type")
        if "${" in use.data:
            raise self._refused(use, (*site.path, "use"), "the name of a prefab cannot be an expression", "type")
        if use.data in outer:
            way = " → ".join([*outer[outer.index(use.data) :], use.data])
            raise self._refused(use, (*site.path, "use"), f"prefabs use each other in a circle: {way}", "circular-use")
        if len(outer) >= MAX_DEPTH:
            raise self._refused(use, site.path, f"prefabs use each other more than {MAX_DEPTH} deep", "too-deep")
        try:
            return self.library.find(use.data)
        except MissingPrefab as missing:
            if missing.problems:
                own = missing.problems[0].file == self.document.source.file
                user = f"`{site.name}`"
                # What is wrong with a prefab of the case itself is reported whether it is used or not.
                told = own or use.data in self.told
                self.told.add(use.data)
                raise RefusedUse([] if told else named(missing.problems, user)) from None
            raise self._refused(use, (*site.path, "use"), str(missing), "unknown-prefab", missing.hint) from None

    def _refused(
        self, tree: LocatedValue, path: Path, message: str, rule: str = "prefab", hint: str | None = None
    ) -> RefusedUse:
        return RefusedUse([self._problem(tree.node, path, message, rule, hint)])

    def _problem(self, node: Node, path: Path, message: str, rule: str, hint: str | None = None) -> Problem:
        if node.origin is not None:
            message += f" ({node.origin})"
        return Problem(pointer(path), message, node.line, node.column, self.document.source.file, hint, rule)
