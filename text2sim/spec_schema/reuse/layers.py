"""Case with overlays applied (variants, a point of a sweep, single values), then prefabs expanded."""

from dataclasses import dataclass, field, replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

from text2sim.spec_schema.arithmetic.resolution import Resolver
from text2sim.spec_schema.errors import Problem, SpecError
from text2sim.spec_schema.paths import parse_dotted
from text2sim.spec_schema.reuse.multiples import multiply
from text2sim.spec_schema.reuse.overlay import SECTIONS, CaseOverlay, uses_prefabs
from text2sim.spec_schema.reuse.overlay_check import check_names, check_overlay, unknown_overlay
from text2sim.spec_schema.reuse.sections import multiplies
from text2sim.spec_schema.reuse.trees import LocatedValue, mapping, merge, moved, put
from text2sim.spec_schema.text.document import Document, Node, Origin, Path, parse_document, parse_pointer, sites_of
from text2sim.spec_schema.text.nodes import Derived
from text2sim.spec_schema.text.source import Source, check_source
from text2sim.spec_schema.vocabulary.slot_path import ROOTS, NoSuchSlot, PrefabInterface, PrefabInterfaces, check_path

if TYPE_CHECKING:
    from text2sim.spec_schema.reuse.arguments import Argument
    from text2sim.spec_schema.reuse.library import PrefabLibrary


@dataclass
class Layers:
    """The document after overlays and prefabs, with its problems."""

    document: Document
    problems: list[Problem] = field(default_factory=list)
    arguments: "list[Argument]" = field(default_factory=list)
    """Arguments of prefabs with unknown values."""
    multiplied: bool = False
    """Whether entries with `repeat` were multiplied."""
    failed: bool = False
    """Whether bodies are missing because their prefabs could not be expanded."""

    def judge(self, resolver: Resolver, problems: list[Problem]) -> tuple[list[Problem], list[Problem]]:
        """Check the arguments when their values are known.

        Args:
            resolver: Parameters of the case.
            problems: Problems of the expanded case.

        Returns:
            Problems of arguments, and the given problems that do not follow from them.
        """
        if self.failed:
            problems = [p for p in problems if not (p.path == "/bodies" and p.rule == "length")]
        if not self.arguments:
            return [], problems
        from text2sim.spec_schema.reuse.arguments import check_arguments

        found, blamed = check_arguments(self.document, resolver, self.arguments)
        return found, [p for p in problems if not self._follows(p, blamed)]

    def _follows(self, problem: Problem, blamed: set[Path]) -> bool:
        path = parse_pointer(problem.path)
        return any(path[: len(root)] == root for root in blamed) and self.document.origin(path) is not None


def build(document: Document, folder: FilePath, overlay: CaseOverlay) -> Layers:
    """Apply an overlay to a case, and expand its prefabs.

    Args:
        document: The case, in the latest version of the language.
        folder: Its folder, with its prefabs.
        overlay: The overlay.

    Raises:
        SpecError: If the overlay cannot be applied.
    """
    interfaces = _PrefabInterfaces(document, folder)
    problems = _check_sections(document, interfaces)
    if overlay:
        try:
            document = _lay_over(document, overlay, interfaces)
        except SpecError as error:
            raise SpecError([*problems, *error.problems]) from None
    layers = Layers(document, problems)
    if "prefabs" in document.data or uses_prefabs(document.data):
        from text2sim.spec_schema.reuse.prefabs import expand

        expand(layers, folder)
    if multiplies(layers.document.data):
        layers.document, found = multiply(layers.document)
        layers.multiplied = True
        layers.problems += found
    data = {key: value for key, value in layers.document.data.items() if key not in SECTIONS}
    root = layers.document.root.copy()
    assert isinstance(root.children, dict)
    root.children = {key: child for key, child in root.children.items() if key in data}
    root.keys = {key: place for key, place in root.keys.items() if key in data}
    layers.document = replace(layers.document, data=data, root=root, sites=sites_of(data))
    return layers


class _PrefabInterfaces:
    """Interfaces of prefabs, from a library that is loaded on demand."""

    def __init__(self, document: Document, folder: FilePath) -> None:
        self.document, self.folder = document, folder
        self.library: PrefabLibrary | None = None

    def __call__(self, use: Any) -> PrefabInterface:
        if self.library is None:
            from text2sim.spec_schema.reuse.library import PrefabLibrary

            self.library = PrefabLibrary(self.document, self.folder)
        return self.library.interface(use)


# --- checks of the case ---------------------------------------------------------------------------------------


def _check_sections(document: Document, interfaces: PrefabInterfaces) -> list[Problem]:
    """Return the problems of all variants and sweeps."""
    problems: list[Problem] = []
    variants = check_names(document, "variants", problems)
    for name in variants:
        problems += check_overlay(document, ("variants", name), list(variants.values()), interfaces)
    if "sweeps" in document.data:
        from text2sim.spec_schema.reuse.sweeps import check_sweeps

        problems += check_sweeps(document, interfaces)
    return problems


# --- overlays -------------------------------------------------------------------------------------------------


def overlaid(document: Document, folder: FilePath, overlay: CaseOverlay) -> Document:
    """Return a case with an overlay applied, without expanding its prefabs.

    Args:
        document: The document.
        folder: Folder of the case, with its prefabs.
        overlay: The overlay.

    Raises:
        SpecError: If a part of the overlay does not exist, or has an invalid path.
    """
    return _lay_over(document, overlay, _PrefabInterfaces(document, folder))


def _lay_over(document: Document, overlay: CaseOverlay, interfaces: PrefabInterfaces) -> Document:
    tree, problems = LocatedValue(document.data, document.root), list[Problem]()
    for number, name in enumerate(overlay.variants, 1):
        over = _named(tree, ("variants",), name)
        if over is None:
            problems.append(unknown_overlay(document, "variant", name, tree.data.get("variants"), number))
        elif isinstance(over.data, dict):
            tree = merge(tree, _only(over))
    if overlay.point is not None:
        over = _named(tree, ("sweeps", overlay.point[0], "points"), overlay.point[1])
        if over is not None and isinstance(over.data, dict):
            tree = merge(tree, _only(over))
    if problems:
        raise SpecError(problems)
    source = Source("\n".join(overlay.sets), "--set")
    start = 0
    for words in overlay.sets:
        try:
            tree = _set(tree, words, source, start, interfaces)
        except SpecError as error:
            problems += error.problems
        start += len(words) + 1
    if problems:
        raise SpecError(problems)
    return replace(document, data=tree.data, root=tree.node, sites=sites_of(tree.data))


def _named(tree: LocatedValue, section: tuple[str, ...], name: str) -> LocatedValue | None:
    for step in (*section, name):
        if not isinstance(tree.data, dict) or step not in tree.data:
            return None
        tree = tree.child(step)
    return tree


def _only(over: LocatedValue) -> LocatedValue:
    """Return a variant without the sections it must not change, which are reported elsewhere."""
    return mapping(over.node, {key: over.child(key) for key in over.data if key in ROOTS})


def _set(tree: LocatedValue, words: str, source: Source, start: int, interfaces: PrefabInterfaces) -> LocatedValue:
    """Set one value, given as `path=value`."""

    def wrong(offset: int, message: str, rule: str, hint: str | None = None) -> SpecError:
        line, column = source.place(start + offset)
        return SpecError([Problem("", message, line, column, source.file, hint, rule)])

    name, equals, text = words.partition("=")
    if not equals:
        raise wrong(0, f"`{words[:80]}` sets nothing: write PATH=VALUE, as in bodies.ball.material.density=500", "form")
    if not name.strip():
        raise wrong(0, "there is no path before `=`", "form")
    try:
        path = parse_dotted(name.strip())
    except ValueError as error:
        raise wrong(0, f"`{name[:80]}`: {error}", "form") from None
    offset = len(name) + 1
    value = _value(text, wrong, offset)
    try:
        check_path(tree.data, path, interfaces, new=isinstance(value.data, dict))
    except NoSuchSlot as error:
        at = sum(len(f"{step}") + 1 + isinstance(step, int) for step in path[: error.step])
        raise wrong(min(at, max(len(name) - 1, 0)), str(error), "unknown-path", error.hint) from None
    line, column = Document(source, tree.data, tree.node, {}).place(path)
    words = " ".join(words.split())
    origin = Origin(f"from `--set {words if len(words) <= 80 else words[:77] + '…'}`")

    def here(node: Node) -> Node:
        return Derived(line, column, origin)

    if value.data is not None:
        return put(tree, path, moved(value, here))
    if isinstance(path[-1], int):
        raise wrong(offset, "an item of a list cannot be removed; set the whole list", "form")
    return put(tree, path, None)


def _value(text: str, wrong: Any, offset: int) -> LocatedValue:
    """Parse a value from the command line."""
    if not text.strip():
        raise wrong(offset, "there is no value after `=` (null removes a value)", "form")
    if text.lstrip().startswith("#"):  # a colour, but a comment in YAML
        text = f'"{text.strip()}"' if '"' not in text and "\\" not in text else text
    try:
        found = parse_document(check_source(Source(text, "--set")))
    except SpecError as error:
        first = error.problems[0]
        lines = text.split("\n")
        before = sum(len(line) + 1 for line in lines[: first.line - 1]) + first.column - 1
        raise wrong(min(offset + before, offset + len(text)), first.message, first.rule, first.hint) from None
    return LocatedValue(found.data, found.root)
