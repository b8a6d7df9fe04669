"""What is laid over a case before it is checked: variants, a point of a sweep, single values."""

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Overlay:
    """Changes to a case, in the order in which they are made. Falsy if there are none."""

    variants: tuple[str, ...] = ()
    """Names of variants of the case."""
    sets: tuple[str, ...] = ()
    """Single values, as `bodies.ball.material.density=500`."""
    point: tuple[str, str] | None = None
    """A point of a sweep: names of both. It comes after the variants and before the single values."""

    def __bool__(self) -> bool:
        return bool(self.variants or self.sets or self.point)

    def __add__(self, other: "Overlay") -> "Overlay":
        return Overlay(self.variants + other.variants, self.sets + other.sets, other.point or self.point)


NOTHING = Overlay()

SECTIONS = ("prefabs", "variants", "sweeps")
"""Sections of a case that its expanded form no longer has."""


def needs_layers(data: dict[str, Any], overlay: Overlay) -> bool:
    """Whether a case is more than a plain one."""
    return bool(overlay) or any(section in data for section in SECTIONS) or uses_prefabs(data)


def uses_prefabs(data: dict[str, Any]) -> bool:
    """Whether a body or static of a case comes from a prefab."""
    scene = data.get("scene")
    for section in (data.get("bodies"), scene.get("statics") if isinstance(scene, dict) else None):
        if isinstance(section, dict) and any(isinstance(entry, dict) and "use" in entry for entry in section.values()):
            return True
    return False
