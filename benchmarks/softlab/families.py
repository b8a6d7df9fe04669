"""Families of bodies, and pairs of them."""

from dataclasses import dataclass

SPEED = 1.5
"""Of the body that flies [m/s]."""
SLIDE = 1.0
"""Of the body that slides at the start [m/s]."""
FRICTION = 0.3
"""Asked of every body."""
FAMILIES = ("rigid", "rope", "soft mpm", "granular", "liquid", "snow", "cloth", "soft fem")
LOOSE = ("granular", "liquid", "snow")


@dataclass(frozen=True)
class Pair:
    """Two families, and the contact model under which they meet."""

    first: str
    second: str
    model: str

    @property
    def name(self) -> str:
        """As `--only` takes it."""
        words = [family.replace("soft ", "") for family in (self.first, self.second)]
        return "-".join(words) + ("-under-sap" if self.is_extra else "")

    @property
    def is_extra(self) -> bool:
        """Whether neither of the two needs this model: some third body of the scene does."""
        return self.model == "sap" and "soft fem" not in (self.first, self.second)


def pairs() -> list[Pair]:
    """Return every pair of families, and those that a body of a third one parts."""
    found = []
    for k, first in enumerate(FAMILIES):
        for second in FAMILIES[k:]:
            found.append(Pair(first, second, "sap" if "soft fem" in (first, second) else "particle"))
    parted = [("rigid", "soft mpm"), ("rigid", "cloth"), ("soft mpm", "cloth"), ("cloth", "cloth"), ("rigid", "rigid")]
    return found + [Pair(first, second, "sap") for first, second in parted]
