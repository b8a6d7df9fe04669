"""Overlays of a case, applied before it is checked: variants, a point of a sweep, single values."""

import re
from dataclasses import dataclass
from typing import Any

from text2sim.spec_schema.reuse.sections import multiplies, placed_entries

LABEL = 48
"""Most characters of a label."""
_ODD = re.compile(r"[^A-Za-z0-9.+]+")


@dataclass(frozen=True)
class CaseOverlay:
    """Changes to a case, in the order of application. Falsy if there are none."""

    variants: tuple[str, ...] = ()
    """Names of variants of the case."""
    sets: tuple[str, ...] = ()
    """Single values, such as `bodies.ball.material.density=500`."""
    point: tuple[str, str] | None = None
    """Names of a sweep and a point of it, which is applied after the variants and before the single values."""

    def __bool__(self) -> bool:
        return bool(self.variants or self.sets or self.point)

    @property
    def words(self) -> list[str]:
        """Names of the variants and of the point, and the single values."""
        return [*self.variants, *(self.point[1:] if self.point else ()), *self.sets]

    @property
    def label(self) -> str:
        """Part of a file's name that identifies the overlay; empty if there is none."""
        words = [*self.variants, *(self.point or ())]
        for text in self.sets:
            path, _, value = text.partition("=")
            words.append(f"{path.rpartition('.')[2]}_{value}")
        names = [_ODD.sub("_", word).replace("__", "_").strip("_.")[:24] for word in words]
        return "-".join(name for name in names if name)[:LABEL].rstrip("-_.")

    def __add__(self, other: "CaseOverlay") -> "CaseOverlay":
        return CaseOverlay(self.variants + other.variants, self.sets + other.sets, other.point or self.point)


NOTHING = CaseOverlay()

SECTIONS = ("prefabs", "variants", "sweeps")
"""Sections of a case that its expanded form does not have."""


def needs_layers(data: dict[str, Any], overlay: CaseOverlay) -> bool:
    """Return whether a case has overlays, prefabs, or entries with `repeat`."""
    plain = not overlay and not any(section in data for section in SECTIONS)
    return not plain or uses_prefabs(data) or multiplies(data)


def uses_prefabs(data: dict[str, Any]) -> bool:
    """Return whether a body or static of a case comes from a prefab."""
    return any("use" in entry for _, entry in placed_entries(data))
