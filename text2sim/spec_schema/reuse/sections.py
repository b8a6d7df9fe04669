"""Sections of the plain data of a case: bodies and statics, and entries that may have `repeat`."""

from collections.abc import Iterator
from functools import reduce
from typing import Any

from text2sim.spec_schema.text.document import Path, mapping_at


def placed_entries(data: Any) -> Iterator[tuple[Path, dict[str, Any]]]:
    """Yield bodies and statics by path; an empty mapping for an entry that is not a mapping."""
    for section in (("bodies",), ("scene", "statics")):
        entries = reduce(mapping_at, section, data)
        for name in entries:
            yield (*section, name), mapping_at(entries, name)


def multiplies(data: Any) -> bool:
    """Return whether a case has parts, links, controls, measures, events or expectations with `repeat`."""
    return any(True for _, section in sections(data) for _ in repeated(section))


def sections(data: Any) -> Iterator[tuple[Path, dict[str, Any]]]:
    """Yield the mappings whose entries may have `repeat`, the inner ones first."""
    actions = mapping_at(data, "actions")
    for name in ("controls", "measures", "events", "expect"):
        if name in actions:
            yield ("actions", name), mapping_at(actions, name)
    for root, body in placed_entries(data):
        links = mapping_at(body, "links")
        for path, shaped in ((root, body), *(((*root, "links", name), mapping_at(links, name)) for name in links)):
            shape = mapping_at(shaped, "shape")
            if "parts" in shape:
                yield (*path, "shape", "parts"), mapping_at(shape, "parts")
        if "links" in body:
            yield (*root, "links"), links


def repeated(section: dict[str, Any]) -> Iterator[str]:
    """Return the names of the entries with `repeat`."""
    return (name for name, entry in section.items() if isinstance(entry, dict) and entry.get("repeat") is not None)
