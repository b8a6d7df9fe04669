"""The recorded bonds of a run: which bodies they joined, how loaded they were, and when they broke."""

import json
from dataclasses import dataclass
from pathlib import Path

MOST_BONDS = 100_000
"""Most bonds of a recording that are read."""


@dataclass(frozen=True)
class BondRecord:
    """A bond of two copies, or of links of them."""

    control: str
    """Name of the control."""
    between: tuple[str, str]
    """Their names."""
    pos: tuple[float, float, float]
    """Middle of their face, or of the points that are held [m], as it begins."""
    area: float | None
    """[m2]; None without a face."""
    peak: float
    """Largest load, as a fraction of what breaks it."""
    peak_at: float
    """Its time [s]."""
    broken_at: float | None
    """Time [s]; None if it held."""
    by: str | None
    """`tension` or `shear`."""


def read_bonds(states: Path) -> tuple[BondRecord, ...]:
    """Return the bonds of a run; none if there are none, or if the file is damaged.

    Args:
        states: Folder of the recorded states.
    """
    try:
        rows = json.loads((states / "bonds.json").read_text("utf-8"))[:MOST_BONDS]
        return tuple(_bond(row) for row in rows)
    except (OSError, ValueError, TypeError, LookupError, RecursionError):
        return ()


def _bond(row: dict) -> BondRecord:
    (a, b), (x, y, z), when = row["between"], row["pos"], row["broken_at"]
    return BondRecord(
        control=str(row["control"]),
        between=(str(a), str(b)),
        pos=(float(x), float(y), float(z)),
        area=None if row["area"] is None else float(row["area"]),
        peak=float(row["peak"]),
        peak_at=float(row["peak_at"]),
        broken_at=None if when is None else float(when),
        by=None if row["by"] is None else str(row["by"]),
    )
