"""Sections whose entries may stand for several: `repeat` of parts, links, controls, measures and the like."""

from collections.abc import Iterator
from typing import Any

from text2sim.spec_schema.text.document import Path


def multiplies(data: Any) -> bool:
    """Whether a case has entries that stand for several."""
    return any(True for _, section in sections(data) for _ in repeated(section))


def sections(data: Any) -> Iterator[tuple[Path, dict[str, Any]]]:
    """Mappings whose entries may stand for several, the inner ones first."""
    actions = _mapping(data, "actions")
    for name in ("controls", "measures", "events", "expect"):
        if name in actions:
            yield ("actions", name), _mapping(actions, name)
    bodies, statics = _mapping(data, "bodies"), _mapping(_mapping(data, "scene"), "statics")
    roots: list[tuple[Path, dict[str, Any]]] = [(("bodies", name), _mapping(bodies, name)) for name in bodies]
    roots += [(("scene", "statics", name), _mapping(statics, name)) for name in statics]
    for root, body in roots:
        links = _mapping(body, "links")
        for path, thing in ((root, body), *(((*root, "links", name), _mapping(links, name)) for name in links)):
            shape = _mapping(thing, "shape")
            if "parts" in shape:
                yield (*path, "shape", "parts"), _mapping(shape, "parts")
        if "links" in body:
            yield (*root, "links"), links


def repeated(section: dict[str, Any]) -> Iterator[str]:
    """Return the names of the entries that stand for several."""
    return (name for name, entry in section.items() if isinstance(entry, dict) and entry.get("repeat") is not None)


def _mapping(data: Any, key: str) -> dict[str, Any]:
    found = data.get(key) if isinstance(data, dict) else None
    return found if isinstance(found, dict) else {}
