"""Differences as lines of text."""

from collections.abc import Iterable
from math import hypot
from typing import Any

from text2sim.spec_schema.changes.diff import NOTHING, Change, Effect
from text2sim.spec_schema.paths import dotted
from text2sim.spec_schema.text.writing import flow_text

MAX_VALUE_LENGTH = 72
"""Longest text of a value."""
MARKS = {"added": "+", "removed": "-", "moved": "~", "changed": "~", "kind": "~"}


def change_line(change: Change) -> str:
    """Return a change as a line: `~ bodies.ball.material.density  7800 → 500`."""
    where, mark = dotted(change.path), MARKS[change.kind]
    if change.kind == "added":
        return f"{mark} {where}  {_with_value(change.new, change.now)}"
    if change.kind == "removed":
        return f"{mark} {where}  (was {_with_value(change.old, change.was)})"
    if change.kind == "moved" and change.by is not None:
        far = f"[{', '.join(_number(x) for x in change.by)}] ({_number(hypot(*change.by))} m)"
        return f"{mark} {where}  moved by {far}: {_from_to(change)}"
    if change.kind == "kind" and isinstance(change.old, dict) and isinstance(change.new, dict):
        old, new = (value_text(kind) if (kind := row.get("kind")) else "no kind" for row in (change.old, change.new))
        return f"{mark} {where}  {old} → {new}: {_from_to(change)}"
    return f"{mark} {where}  {_from_to(change)}"


def effect_line(effect: Effect) -> str:
    """Return an effect as a line: `bodies.brick.repeat.rows  8 → 10  (rows)`."""
    because = f"  ({', '.join(effect.because)})" if effect.because else ""
    return f"= {dotted(effect.path)}  {value_text(effect.was)} → {value_text(effect.now)}{because}"


def sections(changes: Iterable[Change]) -> dict[str, list[Change]]:
    """Return the changes by section of the case, in the order of the language."""
    order = ("", "params", "prefabs", "scene", "bodies", "actions", "render", "variants", "sweeps", "waive")
    groups: dict[str, list[Change]] = {name: [] for name in order}
    for change in changes:
        first = str(change.path[0]) if change.path else ""
        groups.setdefault(first if first in order else "", []).append(change)
    return {name: rows for name, rows in groups.items() if rows}


def value_text(value: Any, width: int = MAX_VALUE_LENGTH) -> str:
    """Return a value as YAML, shortened to `width` characters."""
    if value is NOTHING:
        return "nothing"
    if isinstance(value, str):
        text = "".join(c if c.isprintable() else " " for c in value)
        text = text if text.strip() == text and text else f'"{text}"'
    elif isinstance(value, float):
        text = _number(value)
    else:
        text = flow_text(_rounded(value))
    return text if len(text) <= width else text[: width - 1] + "…"


def _from_to(change: Change) -> str:
    text = f"{value_text(change.old)} → {value_text(change.new)}"
    if change.was is NOTHING and change.now is NOTHING:
        return text
    was = change.old if change.was is NOTHING else change.was
    now = change.new if change.now is NOTHING else change.now
    return f"{text}  ({value_text(was)} → {value_text(now)})"


def _with_value(raw: Any, value: Any) -> str:
    text = value_text(raw)
    return text if value is NOTHING or isinstance(raw, dict) else f"{text}  ({value_text(value)})"


def _rounded(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _rounded(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_rounded(item) for item in value]
    return float(f"{value:.9g}") if isinstance(value, float) else value


def _number(value: float) -> str:
    return f"{value:.9g}"
