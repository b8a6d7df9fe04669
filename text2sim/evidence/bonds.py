"""Bonds, and attachments that break: what broke, and what still hangs together."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from text2sim.assets.surface import connected
from text2sim.evidence.recorded_case import RecordedCase, links_of
from text2sim.evidence.selection import RecordedTarget
from text2sim.recording.bonds import BondRecord
from text2sim.recording.states import Array


def breaks(recording: RecordedCase, control: str) -> list[dict[str, Any]]:
    """Return an occurrence for each bond of a control that broke: time [s], bodies, place [m] and cause.

    Args:
        recording: The recording.
        control: Name of the control.
    """
    broken = [bond for bond in recording.states.bonds if bond.control == control and bond.broken_at is not None]
    return [
        {"time": bond.broken_at, "between": [*bond.between], "pos": [*bond.pos], "by": bond.by}
        for bond in sorted(broken, key=lambda bond: (bond.broken_at or 0.0, bond.between))
    ]


def pieces(recording: RecordedCase, targets: Sequence[RecordedTarget]) -> tuple[Array, Array]:
    """Return the number of pieces into which bonded bodies have come apart, and the largest one's part of their mass.

    Args:
        recording: The recording.
        targets: The bodies; what bonds them to others does not count.

    Returns:
        Both of shape (F,).
    """
    masses = np.array([recording.masses[links_of([target])].sum() for target in targets])
    number = {target.copy: k for k, target in enumerate(targets)}
    bonds = [bond for bond in recording.states.bonds if all(name in number for name in bond.between)]
    pairs = np.array([[number[name] for name in bond.between] for bond in bonds], int).reshape(-1, 2)
    ends = np.array([np.inf if bond.broken_at is None else bond.broken_at for bond in bonds])
    moments = np.unique([0.0, *ends[np.isfinite(ends)]])
    counts, largest = [], []
    for moment in moments:
        sizes = np.bincount(connected(pairs[ends > moment], len(number)), weights=masses)
        counts.append(len(sizes))
        largest.append(sizes.max() / masses.sum() if masses.sum() > 0 else 1.0)
    frame = np.searchsorted(moments, recording.states.time + 1e-9, side="right") - 1
    return np.array(counts, float)[frame], np.array(largest)[frame]


def summary(recording: RecordedCase) -> dict[str, Any]:
    """Return by control how many bonds there were and broke, when, and the largest load of those that held.

    Loads are fractions of what breaks a bond: 1 or more broke it.
    """
    by_control: dict[str, list[BondRecord]] = {}
    for bond in recording.states.bonds:
        by_control.setdefault(bond.control, []).append(bond)
    return {name: _account(rows) for name, rows in by_control.items()}


def _account(bonds: list[BondRecord]) -> dict[str, Any]:
    times = sorted(bond.broken_at for bond in bonds if bond.broken_at is not None)
    held = max((bond for bond in bonds if bond.broken_at is None), key=lambda bond: bond.peak, default=None)
    return {
        "bonds": len(bonds),
        "broken": len(times),
        "first_at": times[0] if times else None,
        "last_at": times[-1] if times else None,
        "largest_load_held": None if held is None else round(held.peak, 4),
        "largest_load_held_at": None if held is None else held.peak_at,
    }
