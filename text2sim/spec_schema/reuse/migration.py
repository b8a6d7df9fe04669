"""Migration of documents from older versions of the language.

A step maps the data of a document to RFC 6902 operations. A document is migrated in memory whenever it is loaded;
`text2sim migrate` applies the same operations to the file.
"""

import re
from collections.abc import Callable, Iterator
from functools import reduce
from typing import Any

from text2sim.spec_schema.errors import Problem, SpecError
from text2sim.spec_schema.text.document import Document, Node, Path, mapping_at, parse_pointer, pointer, sites_of
from text2sim.spec_schema.vocabulary.words import show

LATEST = 2
"""The current version of the language."""

Operation = dict[str, Any]


def steps_for(data: Any) -> list[Operation]:
    """Return the RFC 6902 operations that migrate a document to the latest version.

    Args:
        data: Plain data of the document, in any version; it may be invalid otherwise.

    Returns:
        An empty list if it has the latest version, or an unknown one.
    """
    version = _version(data)
    if version is None or version == LATEST:
        return []
    operations = [operation for step in range(version, LATEST) for operation in STEPS[step](data)]
    return [*operations, {"op": "replace", "path": "/text2sim", "value": LATEST}]


def migrate(document: Document) -> tuple[Document, list[Problem]]:
    """Migrate a document to the latest version in memory; every value keeps its position.

    Returns:
        The document, which is the given one if it needs no changes, and the problems of its version.

    Raises:
        SpecError: If it has a later version.
    """
    data = document.data
    if data.get("text2sim") == LATEST and not isinstance(data["text2sim"], bool) or "text2sim" not in data:
        return document, []
    if _version(data) is not None:
        return _renamed(document, steps_for(data)), []
    given = data["text2sim"]
    known = f"this text2sim supports versions 1 to {LATEST} of the language (got {show(given)})"
    problem = document.problem(("text2sim",), known, rule="version")
    if isinstance(given, int) and not isinstance(given, bool) and given > LATEST:
        raise SpecError([problem])
    # The rest is checked as the latest version.
    return _renamed(document, [{"op": "replace", "path": "/text2sim", "value": LATEST}]), [problem]


def _version(data: Any) -> int | None:
    """Return the version of a document, or None if it is unknown."""
    version = data.get("text2sim") if isinstance(data, dict) else None
    known = isinstance(version, int) and not isinstance(version, bool) and 1 <= version <= LATEST
    return version if known else None


# --- the steps ------------------------------------------------------------------------------------------------

_FOV = re.compile(r"render\.cameras\.\w+\.fov", re.ASCII)


def _from_1(data: dict[str, Any]) -> Iterator[Operation]:
    """Rename `fov` of a camera to `fov_deg`: only fields that end in `deg` are in degrees."""
    sweeps = mapping_at(data, "sweeps")
    overlays: list[Path] = [("variants", name) for name in mapping_at(data, "variants")]
    overlays += [("sweeps", name, "points", point) for name in sweeps for point in mapping_at(sweeps[name], "points")]
    for root in ((), *overlays):
        where: Path = (*root, "render", "cameras")
        for name, camera in reduce(mapping_at, where, data).items():
            if isinstance(camera, dict) and "fov" in camera and "fov_deg" not in camera:
                place = pointer((*where, name))
                yield {"op": "move", "from": f"{place}/fov", "path": f"{place}/fov_deg"}
    for name in sweeps:
        grid = mapping_at(sweeps[name], "grid")
        for dots in grid:
            if _FOV.fullmatch(dots) and f"{dots}_deg" not in grid:
                place = ("sweeps", name, "grid")
                yield {"op": "move", "from": pointer((*place, dots)), "path": pointer((*place, f"{dots}_deg"))}


STEPS: dict[int, Callable[[dict[str, Any]], Iterator[Operation]]] = {1: _from_1}
"""The step from each version to the next."""


# --- in memory ------------------------------------------------------------------------------------------------


def _renamed(document: Document, operations: list[Operation]) -> Document:
    """Apply the operations of a step, which rename keys and replace values."""
    data, root = document.data, document.root
    for operation in operations:
        path = parse_pointer(operation["path"])
        old = parse_pointer(operation["from"])[-1] if operation["op"] == "move" else path[-1]
        value = operation.get("value")
        data, root = _change(data, root, path, str(old), value)
    return Document(document.source, data, root, sites_of(data))


def _change(data: Any, node: Node, path: Path, old: str, value: Any) -> tuple[Any, Node]:
    """Return a copy in which the key `old` is renamed to the last step of `path`, and optionally gets a value."""
    assert isinstance(data, dict)
    assert isinstance(node.children, dict)
    step = str(path[0])
    copied = node.copy()
    if len(path) > 1:
        inner, below = _change(data[step], node.children[step], path[1:], old, value)
        copied.children = node.children | {step: below}
        return data | {step: inner}, copied
    copied.children = {step if key == old else key: child for key, child in node.children.items()}
    copied.keys = {step if key == old else key: place for key, place in node.keys.items()}
    new = {step if key == old else key: item for key, item in data.items()}
    return (new | {step: value} if value is not None else new), copied
