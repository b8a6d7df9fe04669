"""Overlays of a case, laid over it before it is checked: variants, a point of a sweep, single values."""

import re
from dataclasses import dataclass
from typing import Any

from text2sim.spec_schema.reuse.sections import multiplies

LABEL = 48
"""Characters of a label, at most."""
_ODD = re.compile(r"[^A-Za-z0-9.+]+")


@dataclass(frozen=True)
class CaseOverlay:
    """Changes to a case, in the order in which they are made. Falsy if there are none."""

    variants: tuple[str, ...] = ()
    """Names of variants of the case."""
    sets: tuple[str, ...] = ()
    """Single values, as `bodies.ball.material.density=500`."""
    point: tuple[str, str] | None = None
    """A point of a sweep: names of both. It comes after the variants and before the single values."""

    def __bool__(self) -> bool:
        return bool(self.variants or self.sets or self.point)

    @property
    def words(self) -> list[str]:
        """What is laid over the case, for people: names of variants, and what was set."""
        return [*self.variants, *(self.point[1:] if self.point else ()), *self.sets]

    @property
    def label(self) -> str:
        """Part of a file's name that says what is laid over the case; empty if nothing is."""
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
"""Sections of a case that its expanded form no longer has."""


def needs_layers(data: dict[str, Any], overlay: CaseOverlay) -> bool:
    """Whether a case is more than a plain one."""
    plain = not overlay and not any(section in data for section in SECTIONS)
    return not plain or uses_prefabs(data) or multiplies(data)


def uses_prefabs(data: dict[str, Any]) -> bool:
    """Whether a body or static of a case comes from a prefab."""
    scene = data.get("scene")
    for section in (data.get("bodies"), scene.get("statics") if isinstance(scene, dict) else None):
        if isinstance(section, dict) and any(isinstance(entry, dict) and "use" in entry for entry in section.values()):
            return True
    return False
