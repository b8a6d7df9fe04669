"""Canonical form of a case: order, indentation, quotes. Comments are kept.

Keys are in the order of the language, names in the order of the author. Sections and bodies are written line by line;
smaller mappings go on one line if they fit.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, get_args, get_origin

from pydantic import BaseModel

from text2sim.spec_schema.models.case import Case
from text2sim.spec_schema.models.prefab_models import PrefabFile
from text2sim.spec_schema.text.document import Document, Path, parse_document
from text2sim.spec_schema.text.layout import LayoutEntry, plain_layout, written_layout
from text2sim.spec_schema.text.source import Source, check_source
from text2sim.spec_schema.text.writing import block_lines, key, scalar
from text2sim.spec_schema.vocabulary.slots import slots_by_key
from text2sim.spec_schema.vocabulary.words import LanguageSlot, slot_of

WIDTH = 110
INDENT = 2
SECTIONS = ("prefabs", "scene", "bodies", "actions", "render", "variants", "sweeps", "waive")
ANY = "*"

_SPREAD: tuple[Path, ...] = (
    (),
    ("scene",),
    ("scene", "statics"),
    ("bodies",),
    ("bodies", ANY),
    ("bodies", ANY, "links"),
    ("actions",),
    ("actions", ANY),
    ("render",),
    ("render", "cameras"),
    ("render", "lights"),
    ("render", "shots"),
    ("prefabs",),
    ("prefabs", ANY),
    ("prefabs", ANY, "params"),
    ("prefabs", ANY, "body"),
    ("prefabs", ANY, "bodies"),
    ("prefabs", ANY, "bodies", ANY),
    ("variants",),
    ("sweeps",),
    ("sweeps", ANY, "points"),
    ("waive",),
)
"""Mappings that are always written line by line."""


def format_text(text: str, file: str = "case.yaml") -> str:
    """Return the text of a case in canonical form; its data does not change.

    Raises:
        SpecError: If the text is not YAML that the language accepts. The case may be invalid otherwise.
    """
    return format_source(check_source(Source(text, file)))


def format_source(source: Source) -> str:
    """Return the text of a file in canonical form; see `format_text`."""
    return format_document(parse_document(source))


def format_document(document: Document) -> str:
    """Return the text of a document in canonical form; see `format_text`."""
    text = dump_layout(*written_layout(document))
    again = parse_document(Source(text, document.source.file))
    if again.data != document.data:
        raise AssertionError("the canonical form has other data than the original")
    return text


def dump_case(case: Case | Mapping[str, Any]) -> str:
    """Return a case, or its plain data (which may contain `${…}`), in canonical form."""
    if isinstance(case, Case):
        case = case.model_dump(mode="json", by_alias=True, exclude_unset=True, exclude_none=True)
    return "\n".join(_trimmed(_document(plain_layout(dict(case))))) + "\n"


def dump_layout(root: LayoutEntry, head: list[str], foot: list[str]) -> str:
    """Return a document, with the comments above and below it, in canonical form.

    Args:
        root: The document.
        head: Lines of comments above it.
        foot: Lines of comments below it.
    """
    lines = [*head, *_document(root)]
    if foot:
        lines += ["", *foot]
    return "\n".join(_trimmed(lines)) + "\n"


def _trimmed(lines: list[str]) -> list[str]:
    """Return lines without blank ones at the start and the end, and without repeated blank lines."""
    rows: list[str] = []
    for line in lines:
        if line or (rows and rows[-1]):
            rows.append(line)
    while rows and not rows[-1]:
        rows.pop()
    return rows


def _document(root: LayoutEntry) -> list[str]:
    """Return the lines of a whole document."""
    if not isinstance(root.value, list) or not root.value:
        return [_flow(root)]
    return _block(root, *_root(root), 0)


def _block(entry: LayoutEntry, slot: LanguageSlot | None, path: Path, indent: int) -> list[str]:
    """Return the lines of a collection, one or more for each entry."""
    margin = " " * indent
    lines: list[str] = []
    slot = _chosen(slot, entry)
    for child in _in_order(entry, slot):
        inner = (*path, child.key if child.key is not None else ANY)
        before = child.before
        if path == () and child.key in SECTIONS:
            before = ["", *before]
        lines += [margin + row if row else "" for row in before]
        lines += _entry(child, _inside(slot, child), inner, indent)
        lines += [margin + row for row in child.after]
    # A blank line above the first entry would separate it from its key.
    return lines[1:] if lines[:1] == [""] else lines


def _entry(entry: LayoutEntry, slot: LanguageSlot | None, path: Path, indent: int) -> list[str]:
    margin = " " * indent
    lead = margin + ("-" if entry.key is None else key(entry.key) + ":")
    trail = f"  {entry.trail}" if entry.trail else ""
    if isinstance(entry.value, str):
        long = len(lead) + len(entry.value) >= WIDTH or "\n" in entry.value
        rows = block_lines(entry.value, WIDTH - indent - INDENT) if long else None
        if rows is not None:
            body = [f"{margin}{' ' * INDENT}{row}" if row else "" for row in rows[1:]]
            return [f"{lead} {rows[0]}{trail}", *body]
    if not isinstance(entry.value, list):
        return [f"{lead} {scalar(entry.value, flow=False)}{trail}"]
    text = f"{lead} {_flow(entry, slot)}"
    spread = entry.value and (entry.has_comments or _spread(path, entry))
    if not spread and (len(text) <= WIDTH or not entry.value):
        return [text + trail]
    if entry.trail and entry.key is None:  # behind a dash alone, it would be read as that of the item before
        return [margin + entry.trail, *_entry(replace(entry, trail=None), slot, path, indent)]
    # A comment behind the bracket would be read as that of the last item.
    if not (spread or entry.mapping or trail or any(isinstance(item.value, list) for item in entry.value)):
        return _filled(entry, lead, indent)
    return [lead + trail, *_block(entry, slot, path, indent + INDENT)]


def _filled(entry: LayoutEntry, lead: str, indent: int) -> list[str]:
    """Return the lines of a long list of scalars, filled to the width."""
    rows = [lead + " ["]
    words = [scalar(item.value, flow=True) for item in entry.value]
    for number, word in enumerate(words):
        word += "," if number < len(words) - 1 else "]"
        gap = "" if rows[-1].endswith("[") else " "
        if len(rows[-1]) + len(gap) + len(word) > WIDTH and rows[-1].strip():
            rows.append(" " * (indent + INDENT) + word)
        else:
            rows[-1] += gap + word
    return rows


def _flow(entry: LayoutEntry, slot: LanguageSlot | None = None) -> str:
    """Return a value on one line."""
    if not isinstance(entry.value, list):
        return scalar(entry.value, flow=True)
    slot = _chosen(slot, entry)
    inner = [(child, _flow(child, _inside(slot, child))) for child in _in_order(entry, slot)]
    if not entry.mapping:
        return "[" + ", ".join(text for _, text in inner) + "]"
    return "{" + ", ".join(f"{key(child.key or '')}: {text}" for child, text in inner) + "}"


def _in_order(entry: LayoutEntry, slot: LanguageSlot | None) -> list[LayoutEntry]:
    """Return entries in canonical order: that of the language for the fields of a model, the author's otherwise."""
    if not entry.mapping:
        return entry.value
    ranks = {key: rank for rank, key in enumerate(slots_by_key(slot))}
    return sorted(entry.value, key=lambda child: ranks.get(child.key or "", len(ranks)))


def _root(entry: LayoutEntry) -> tuple[LanguageSlot, Path]:
    """Return the slot and path of a document: a case, or a prefab in its own file."""
    if entry.mapping and any(child.key == "prefab" for child in entry.value):
        return slot_of(PrefabFile), ("prefabs", ANY)
    return slot_of(Case), ()


def _chosen(slot: LanguageSlot | None, entry: LayoutEntry) -> LanguageSlot | None:
    """Return the alternative of a union that a collection is for, or None if it is unknown.

    An entry without a kind gets the union itself, because overlays and uses of prefabs need none.
    """
    if slot is None or not isinstance(entry.value, list):
        return None
    if slot.discriminator is not None:
        kinds = [child.value for child in entry.value if child.key == "kind"]
        if not kinds:
            return slot if entry.mapping else None
        model: type[BaseModel] | None = slot.models.get(kinds[0]) if isinstance(kinds[0], str) else None
        return slot_of(model) if model is not None else None
    if len(slot.members) > 1:
        given = "mapping" if entry.mapping else "list"
        fitting = [member for member in slot.members if member.structure == given]
        return _chosen(fitting[0], entry) if len(fitting) == 1 else None
    return slot


def _inside(slot: LanguageSlot | None, child: LayoutEntry) -> LanguageSlot | None:
    """Return the slot of an entry of a collection."""
    if slot is None:
        return None
    if get_origin(slot.base) is dict:
        return slot_of(get_args(slot.base)[1])
    return slots_by_key(slot).get(child.key or "")


def _spread(path: Path, entry: LayoutEntry) -> bool:
    return entry.mapping and any(
        len(path) == len(form) and all(want in (ANY, step) for want, step in zip(form, path, strict=True))
        for form in _SPREAD
    )
