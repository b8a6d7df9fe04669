"""Rows of condensed pages that a reader does not need."""

import re

from text2sim.agents.page_selection import SOFT_FIELDS

_RARE_ROWS, _RARE_ROWS_OF_STATICS = (
    re.compile(rf"^- `(?:torsional_friction|{rows})` .*\n", re.MULTILINE)
    for rows in ("quality|tone|motion_blur|ambient|supports", "seed|record|density|mass")
)
_EXAMPLES = re.compile(r"\n(?:```yaml\n[^`]*\n```|  e\.g\. `.*`)(?=\n|$)")
_COPY_ROWS = re.compile(r"^- `vary` .*\n|, vary: \{[^}]*\}", re.MULTILINE)
_BELT_ROWS = re.compile(r"^.*\bsurface_velocity\b.*\n?", re.MULTILINE)
_SOFT_ROWS = re.compile(
    rf"^- `(?:{'|'.join(SOFT_FIELDS)})`.*\n"
    r"|^ *- `\w+`[^:\n]*: (?:For|Of) (?:deformable|mpm and fem) bodies.*\n",
    re.MULTILINE,
)
_ROW = re.compile(r"- `\w+`\*?(?: \(.*?\))?: ")
_SOFT_WORDS = re.compile(r"\b(?:deforms?|deformable|liquids?|[Cc]loth|soft body|mpm|pbd|fem)\b")
_SOFT_EXAMPLE = re.compile(r"\w+: \{.*\b(?:curtain|jelly|water)\b.*\}$")
"""An example with the name of a deformable body."""


def without_rare_rows(text: str, *, of_statics: bool) -> str:
    """Drop rows of fields that Writers rarely need: of bodies and films, or of the scene and its statics."""
    return (_RARE_ROWS_OF_STATICS if of_statics else _RARE_ROWS).sub("", text)


def without_examples(text: str) -> str:
    """Drop examples of how a kind is written."""
    return _EXAMPLES.sub("", text)


def without_copies(text: str) -> str:
    """Drop what tells copies apart."""
    return _COPY_ROWS.sub("", text)


def without_belts(text: str) -> str:
    """Drop rows about moving surfaces."""
    return _BELT_ROWS.sub("", text)


def without_deformables(text: str) -> str:
    """Drop rows, sentences and examples about deformable bodies."""
    rows = []
    for row in _SOFT_ROWS.sub("", text).split("\n"):
        if _ROW.match(row):
            first, *more = row.split(". ")
            row = ". ".join([first, *(part for part in more if not _SOFT_WORDS.search(part))])
            row += "" if row.endswith((".", ":")) or not more else "."
        if not _SOFT_EXAMPLE.match(row):
            rows.append(row)
    return "\n".join(rows)
