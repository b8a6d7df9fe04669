"""Sections whose entries may have `repeat`: parts, links, controls, measures, events, expectations."""

from collections.abc import Iterator
from typing import Any

from text2sim.spec_schema.text.document import Path, mapping_at


def multiplies(data: Any) -> bool:
    """Return whether a case has such entries with `repeat`."""
    return any(True for _, section in sections(data) for _ in repeated(section))


def sections(data: Any) -> Iterator[tuple[Path, dict[str, Any]]]:
    """Yield the mappings whose entries may have `repeat`, the inner ones first."""
    actions = mapping_at(data, "actions")
    for name in ("controls", "measures", "events", "expect"):
        if name in actions:
            yield ("actions", name), mapping_at(actions, name)
    bodies, statics = mapping_at(data, "bodies"), mapping_at(mapping_at(data, "scene"), "statics")
    roots: list[tuple[Path, dict[str, Any]]] = [(("bodies", name), mapping_at(bodies, name)) for name in bodies]
    roots += [(("scene", "statics", name), mapping_at(statics, name)) for name in statics]
    for root, body in roots:
        links = mapping_at(body, "links")
        for path, thing in ((root, body), *(((*root, "links", name), mapping_at(links, name)) for name in links)):
            shape = mapping_at(thing, "shape")
            if "parts" in shape:
                yield (*path, "shape", "parts"), mapping_at(shape, "parts")
        if "links" in body:
            yield (*root, "links"), links


def repeated(section: dict[str, Any]) -> Iterator[str]:
    """Return the names of the entries with `repeat`."""
    return (name for name, entry in section.items() if isinstance(entry, dict) and entry.get("repeat") is not None)
