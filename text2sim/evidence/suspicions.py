"""Suspicions about a recording: messages about signs of a wrong simulation.

Three of the engine's solvers never check their own state, and silently clamp what reaches their bounds: a run can
finish with unphysical results.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from text2sim.evidence.recorded_case import RecordedCase
from text2sim.recording.states import Array
from text2sim.spec_schema.names.selectors import body_of

MIN_VOLUME_RATIO, MAX_VOLUME_RATIO = 0.5, 2.0
"""Volumes of a soft body, relative to the start, beyond which it is reported. Hard pressing leaves 0.85."""
MAX_DEPTH = 2.5
"""Depth of a point in a rigid body that is reported, in spacings of points; plates that press mpm bodies get to 2."""
DEEP_FEM = 0.5
"""The same for fem bodies, in lengths of their edges."""
MAX_INVERTED = 0.02
"""Fraction of the tetrahedra inside out that is reported."""
MAX_LEAKED = 0.01
"""Fraction of grains or a liquid leaked through its container that is reported."""
MAX_CROWDING = 1.4
"""Density of a liquid, relative to its material's, that is reported; see tests/physics/test_narrow_vessel.py."""
AT_WALLS = 0.01
"""Fraction of a body's points at the bounds of its solver that is reported."""
MAX_TORN = 0.01
"""Fraction of a soft body outside its largest piece that is reported."""
MAX_STRETCH = 1.5
"""Length of a thread of cloth that is reported, relative to its length at rest."""


def suspicions(recording: RecordedCase, found: dict[str, dict[str, Any]]) -> list[str]:
    """Return one message for each sign that `soft_diagnostics` found, for the worst copy of a body only."""
    spacing = {body_of(body.body): body.spacing for body in recording.states.deformables}
    rows = []
    for name, row in found.items():
        for quantity, is_bad, words in _SIGNS:
            seen = row.get(quantity)
            if seen is not None and is_bad(seen["value"], row, spacing.get(name, np.inf)):
                values = {"where": seen.get("in", ""), "solver": row["solver"], "mm": 1e3 * seen["value"]}
                message = words.format(value=seen["value"], percent=100 * seen["value"], **values)
                rows.append(f"`{seen['copy']}` {message} at {seen.get('since', seen['at']):.3g} s")
    return rows + _beyond_the_grid(recording)


def _beyond_the_grid(recording: RecordedCase) -> list[str]:
    """Report rigid bodies that leave the bounds in which a solver couples to them, after having been inside."""
    rows, states = [], recording.states
    domain = next((body.domain for body in states.deformables if body.solver == "mpm" and body.domain), None)
    if domain is None or not states.frames:
        return rows
    low, high = np.array(domain[0]), np.array(domain[1])
    for target in recording.names.loose:
        if target.soft is not None or not recording.names.touches_soft(target.copy):
            continue
        place = states.pos[:, target.root]
        outside: Array = np.any((place < low) | (place > high), axis=1)
        if outside.any() and not outside.all() and not outside[0]:
            at = states.time[int(np.argmax(outside))]
            rows.append(f"`{target.copy}` leaves the grid of mpm, and touches nothing in it any more, at {at:.3g} s")
    return rows


_Bad = Callable[[float, dict[str, Any], float], bool]


def _is_deep(value: float, row: dict[str, Any], spacing: float) -> bool:
    return value > (DEEP_FEM if row["solver"] in ("fem", "ipc") else MAX_DEPTH) * spacing


def _is_inflated(value: float, row: dict[str, Any], spacing: float) -> bool:
    return row["kind"] == "soft" and not MIN_VOLUME_RATIO <= value <= MAX_VOLUME_RATIO


def _is_pulled(value: float, row: dict[str, Any], spacing: float) -> bool:
    return row["kind"] == "cloth" and value > MAX_STRETCH and not row.get("elastic")


_SIGNS: tuple[tuple[str, _Bad, str], ...] = (
    ("volume", _is_inflated, "has {value:.3g} times the volume that it had"),
    ("inverted", lambda value, row, spacing: value > MAX_INVERTED, "has {percent:.2g} % of its tetrahedra inside out"),
    (
        "torn",
        lambda value, row, spacing: value > MAX_TORN and not row.get("tears"),
        "is torn (up to {percent:.2g} % of it were off the largest piece), which its material knows nothing of: "
        "particles two cells apart let go of each other; for the first time",
    ),
    ("stretch", _is_pulled, "is drawn out to {value:.3g} times its length in places"),
    ("penetration", _is_deep, "is {mm:.3g} mm deep in `{where}`"),
    (
        "crowding",
        lambda value, row, spacing: value > MAX_CROWDING,
        "is pressed together to {value:.2g} times its density, so its levels and what it displaces are wrong (the "
        "walls of a vessel that moves, or holds grains or snow too, need a cell and more: `thin-wall`)",
    ),
    (
        "leaked",
        lambda value, row, spacing: value > MAX_LEAKED,
        "has {percent:.2g} % of its mass in or behind walls and floors, most of it by `{where}`, reached",
    ),
    (
        "against_bounds",
        lambda value, row, spacing: value > AT_WALLS,
        "meets an invisible wall: it has {percent:.2g} % of its points at the walls of the space of {solver} "
        "(scene.{solver}.bounds)",
    ),
)
"""Quantity of the diagnostics, a test whether a value of it is suspicious, and the message."""
