"""Older versions of the language, and the steps that bring a document to the one that is spoken here.

A step is a function from the data of a document to RFC 6902 operations. In memory a document is migrated whenever it
is loaded; `text2sim migrate` does the same operations on the file.
"""

import re
from collections.abc import Callable, Iterator
from typing import Any

from text2sim.spec_schema.errors import Problem, SpecError
from text2sim.spec_schema.text.document import Document, Node, Path, mapping_at, parse_pointer, pointer, sites_of
from text2sim.spec_schema.vocabulary.words import show

LATEST = 2
"""The version of the language that this text2sim speaks."""

Operation = dict[str, Any]


def steps_for(data: Any) -> list[Operation]:
    """Return the RFC 6902 operations that bring a document to the latest version.

    Args:
        data: Plain data of the document, of any version that there was; it need not be valid otherwise.

    Returns:
        Nothing if it says the latest version, or none that is known.
    """
    version = _version(data)
    if version is None or version == LATEST:
        return []
    operations = [operation for step in range(version, LATEST) for operation in STEPS[step](data)]
    return [*operations, {"op": "replace", "path": "/text2sim", "value": LATEST}]


def migrate(document: Document) -> tuple[Document, list[Problem]]:
    """Bring a document to the latest version, in memory; every value keeps its position.

    Returns:
        The document, which is the one that was given if there is nothing to do; and what is wrong with its version.

    Raises:
        SpecError: If it is of a version to come, of which nothing else can be said.
    """
    data = document.data
    if data.get("text2sim") == LATEST and not isinstance(data["text2sim"], bool) or "text2sim" not in data:
        return document, []
    if _version(data) is not None:
        return _renamed(document, steps_for(data)), []
    given = data["text2sim"]
    known = f"versions 1 to {LATEST} of the language are known here (got {show(given)})"
    problem = document.problem(("text2sim",), known, rule="version")
    if isinstance(given, int) and not isinstance(given, bool) and given > LATEST:
        raise SpecError([problem])
    # The rest is judged as if it were of the latest version.
    return _renamed(document, [{"op": "replace", "path": "/text2sim", "value": LATEST}]), [problem]


def _version(data: Any) -> int | None:
    """The version that a document says it has, if there was such a one."""
    version = data.get("text2sim") if isinstance(data, dict) else None
    known = isinstance(version, int) and not isinstance(version, bool) and 1 <= version <= LATEST
    return version if known else None


# --- the steps ------------------------------------------------------------------------------------------------

_FOV = re.compile(r"render\.cameras\.\w+\.fov", re.ASCII)


def _from_1(data: dict[str, Any]) -> Iterator[Operation]:
    """`fov` of a camera is called `fov_deg`: degrees are only in fields that end in `deg`."""
    sweeps = mapping_at(data, "sweeps")
    overlays: list[Path] = [("variants", name) for name in mapping_at(data, "variants")]
    overlays += [("sweeps", name, "points", point) for name in sweeps for point in mapping_at(sweeps[name], "points")]
    for root in ((), *overlays):
        where: Path = (*root, "render", "cameras")
        cameras = data
        for step in where:
            cameras = mapping_at(cameras, step)
        for name, camera in cameras.items():
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
"""What leads away from each version, to the next."""


# --- in memory ------------------------------------------------------------------------------------------------


def _renamed(document: Document, operations: list[Operation]) -> Document:
    """Do the operations that steps are made of: a key gets another name, a value gets another value."""
    data, root = document.data, document.root
    for operation in operations:
        path = parse_pointer(operation["path"])
        old = parse_pointer(operation["from"])[-1] if operation["op"] == "move" else path[-1]
        value = operation.get("value")
        data, root = _change(data, root, path, str(old), value)
    return Document(document.source, data, root, sites_of(data))


def _change(data: Any, node: Node, path: Path, old: str, value: Any) -> tuple[Any, Node]:
    """A copy along the way to `path`, the key `old` of whose parent becomes its last step."""
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
