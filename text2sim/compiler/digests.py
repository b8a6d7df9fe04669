"""Digests of a plan: of what its simulation depends on, and of what else its film depends on."""

import json
import re
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from hashlib import sha256
from typing import TYPE_CHECKING, Any

from text2sim import __version__

if TYPE_CHECKING:
    from text2sim.compiler.plan import Plan

_NOT_SIMULATED_FIELDS = frozenset(
    {"render", "files", "notes", "warnings", "why", "line", "surface", "part_surfaces", "control"}
)
"""Fields that change no simulation: looks, lines of the case, film, notes."""
LOOKS_SUFFIX = "_looks.npz"
"""How names of files end that say where parts have looks of their own."""
_PAINT = re.compile(rb' rgba="[^"]*"')
"""Colours in model files."""


def sim_digest(plan: "Plan") -> str:
    """Return the digest of what the simulation depends on."""
    seen = {
        path: unpainted(content) if path.endswith(".xml") else content
        for path, content in plan.files.items()
        if not path.endswith(LOOKS_SUFFIX)
    }
    return _digest(
        {
            "plan": _plain(plan, _NOT_SIMULATED_FIELDS) | {"files": _plain(seen, _NOT_SIMULATED_FIELDS)},
            "compiler": __version__,
        }
    )


def unpainted(model: bytes) -> bytes:
    """Return a model file without its colours."""
    return _PAINT.sub(b"", model)


def render_digest(plan: "Plan") -> str:
    """Return the digest of what the film depends on besides the states."""
    surfaces = [_plain([entity.surface, entity.part_surfaces], frozenset()) for entity in plan.entities]
    models = {
        path: _plain(content, frozenset())
        for path, content in plan.files.items()
        if path.endswith((".xml", LOOKS_SUFFIX))
    }
    return _digest({"render": plan.render, "surfaces": surfaces, "models": models, "compiler": __version__})


def _digest(content: Any) -> str:
    return sha256(json.dumps(content, sort_keys=True, separators=(",", ":")).encode()).hexdigest()


def _plain(value: Any, skipped: frozenset[str]) -> Any:
    """Return a value as data that JSON can hold, without the fields named in `skipped`."""
    if is_dataclass(value):
        return {f.name: _plain(getattr(value, f.name), skipped) for f in fields(value) if f.name not in skipped}
    if isinstance(value, Mapping):
        return {key: _plain(item, skipped) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item, skipped) for item in value]
    return sha256(value).hexdigest() if isinstance(value, bytes) else value
