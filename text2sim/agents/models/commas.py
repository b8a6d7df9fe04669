"""Repair of unquoted commas: `{what: a ball, a ramp}` means one text, but YAML reads the second half as a key."""

import re
from dataclasses import dataclass
from typing import Any

import yaml

from text2sim.spec_schema.text.document import open_parser
from text2sim.spec_schema.text.masking import mask

_COMMENT = re.compile(r"\s#")


@dataclass
class _Open:
    """A flow collection that is being read."""

    braces: bool
    """Whether it is a mapping in braces."""
    mapping: bool
    key: Any = None
    """The key whose value has not come yet."""
    last: int | None = None
    """Index of the last value, if it is plain text."""


def rejoined(text: str) -> tuple[str, list[tuple[int, str]]]:
    """Rejoin values that were split at unquoted commas: keys without a colon in `{…}`, after a plain value.

    Returns:
        The text, and the fragments that cannot be rejoined, each with its line, from 0. Text that is not YAML is
        returned unchanged.
    """
    joins: dict[int, int] = {}
    lost: list[tuple[int, str]] = []
    opened = [_Open(braces=False, mapping=False)]
    parser = open_parser(masked := mask(text))
    try:
        while (event := parser.get_event()) is not None:
            if isinstance(event, yaml.CollectionEndEvent):
                opened.pop()
            if not isinstance(event, yaml.ScalarEvent | yaml.CollectionStartEvent):
                continue
            here, start, end = opened[-1], event.start_mark.index, event.end_mark.index
            plain = isinstance(event, yaml.ScalarEvent) and not event.style
            if here.mapping and here.key is None:
                here.key = event
            elif here.mapping:
                key, here.key = here.key, None
                bare = plain and start == end and not masked[key.end_mark.index :].lstrip().startswith(":")
                if not (here.braces and bare):
                    here.last = start if plain and start < end else None
                elif here.last is not None and not _COMMENT.search(masked, here.last, key.end_mark.index):
                    joins[here.last] = key.end_mark.index
                else:
                    lost.append((key.start_mark.line, text[key.start_mark.index : key.end_mark.index]))
            if isinstance(event, yaml.CollectionStartEvent):
                mapping = isinstance(event, yaml.MappingStartEvent)
                opened.append(_Open(mapping and bool(event.flow_style), mapping))
    except yaml.YAMLError:
        return text, []
    for start, end in sorted(joins.items(), reverse=True):
        words = text[start:end].replace("\\", "\\\\").replace('"', '\\"')
        text = f'{text[:start]}"{words}"{text[end:]}'
    return text, lost
