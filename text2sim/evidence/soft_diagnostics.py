"""Diagnostics of deformable bodies: volume, stretch, penetration, speed, and points stuck at the solver's bounds."""

from collections.abc import Callable
from typing import Any

import numpy as np

from text2sim.evidence import deformation, folds, tearing
from text2sim.evidence.crowding import crowding
from text2sim.evidence.deformation import DeformationError
from text2sim.evidence.gaps import Cloud, nearest_solid
from text2sim.evidence.leaks import leaks
from text2sim.evidence.recorded_case import RecordedCase
from text2sim.recording.deformables import RecordedDeformable
from text2sim.recording.states import Array
from text2sim.spec_schema.models.soft_bodies import FLOWING
from text2sim.spec_schema.names.selectors import body_of

LOOKED_AT = 4_000_000
"""Largest number of points of a body, over all frames, that are examined; of longer runs, every n-th frame is."""
LOOKED_FOR_TEARS = 600_000
"""The same limit for counting pieces, which takes longer."""
WALL_DISTANCE = 1e-4
"""Distance [m] from the bounds of its solver below which a point lies against them. Particles of mpm stop earlier,
because nodes of the grid act on them from up to half a cell away: for them, their spacing counts instead."""


def soft_diagnostics(recording: RecordedCase) -> dict[str, dict[str, Any]]:
    """Return the worst value among the copies of each deformable body: {quantity: {value, at, copy, unit, ...}}.

    `volume` is relative to the start, and its worst value is the farthest from 1; `tears` stands in the row of a body
    with a tear strength, `elastic` in that of a cloth that stretches by its material. Quantities that a body lacks are
    omitted.
    """
    found: dict[str, dict[str, Any]] = {}
    states = recording.states
    for body in states.deformables if states.frames else ():
        rows = found.setdefault(body_of(body.body), {"kind": body.kind, "solver": body.solver})
        thin = body.thinned(LOOKED_AT, states.frames)
        time = states.time[:: thin.step]
        rows["every"] = max(rows.get("every", 1), thin.step)
        if body.solver == "pbd" and _material(recording, body, "tension_modulus") is not None:
            rows["elastic"] = True
        for name, unit, of in _QUANTITIES:
            try:
                values = of(recording, thin)
            except DeformationError:
                continue
            if values is not None:
                bad = _far_from_one if name == "volume" else np.asarray
                _record_worst(rows, name, values, {"unit": unit, "copy": body.body}, time, bad)
        speed = states.soft_speed[:, body.index].astype(float)
        _record_worst(rows, "speed", speed, {"unit": "m/s", "copy": body.body}, states.time)
        depth, where = penetration(recording, thin)
        _record_worst(rows, "penetration", depth, {"unit": "m", "copy": body.body}, time, where=where)
        if body.kind == "soft" and body.solver == "mpm":
            rarely = body.thinned(LOOKED_FOR_TEARS, states.frames)
            if _material(recording, body, "tear_stretch") is not None:
                rows["tears"] = True
            times, torn = states.time[:: rarely.step], 1.0 - tearing.pieces(rarely)[1]
            _record_worst(rows, "torn", torn, {"unit": "", "copy": body.body, **first_torn(torn, times)}, times)
        if body.kind in FLOWING:
            share, walls = leaks(recording, thin)
            _record_worst(rows, "leaked", share, {"unit": "", "copy": body.body}, time, where=walls)
    return found


def penetration(recording: RecordedCase, body: RecordedDeformable) -> tuple[Array, list[str]]:
    """Return the largest depth [m] of a body's points in a rigid body, shape (F,), and its name in each frame."""
    names = recording.names
    felt = [link for t in names.copies.values() if t.soft is None for link in names.felt_links(t)]
    solids = recording.shapes.of_links(np.array(sorted(felt), dtype=np.int64))
    found = nearest_solid(Cloud.of(body), recording.states, solids, 0.0)
    return 0.0 - found.value, [names.label_of_link(solids[i][0]) if i >= 0 else "" for i in found.of]


def _material(recording: RecordedCase, body: RecordedDeformable, field: str) -> Any:
    """Return a field of the material of a body; None if it is not given."""
    model = recording.case.bodies.get(body_of(body.body))
    return None if model is None else getattr(model.material, field, None)


def first_torn(torn: Array, times: Array) -> dict[str, float]:
    """Return the time at which a body first lost 1 % of itself: {since}; empty if it did not."""
    off = np.flatnonzero(torn > tearing.MIN_PIECE_SHARE)
    return {"since": float(times[off[0]])} if len(off) else {}


def _record_worst(
    rows: dict[str, Any], name: str, values: Array, context: dict[str, Any], time: Array,
    bad: Callable[[Array], Array] = np.asarray, where: list[str] | None = None,
) -> None:  # fmt: skip
    """Record the worst of values (F,), by default the largest, unless another copy's is worse."""
    with np.errstate(all="ignore"):
        badness = np.where(np.isfinite(values), bad(values), -np.inf)
    at = int(np.argmax(badness))
    if np.isfinite(badness[at]) and (name not in rows or badness[at] > bad(np.array(rows[name]["value"]))):
        rows[name] = {"value": float(values[at]), "at": float(time[at]), **context}
        if where is not None and where[at]:
            rows[name]["in"] = where[at]


def _far_from_one(values: Array) -> Array:
    return np.abs(np.log(np.maximum(values, 1e-300)))


def _volume(recording: RecordedCase, body: RecordedDeformable) -> Array:
    volume = deformation.volumes(body)
    return volume / volume[0]


def _strain(recording: RecordedCase, body: RecordedDeformable) -> Array | None:
    """Return the 99th percentile of strain, because single particles may have escaped; None for bodies that flow."""
    return None if body.kind != "soft" else np.percentile(deformation.strains(body), 99, axis=1)


def _share_at_walls(recording: RecordedCase, body: RecordedDeformable) -> Array | None:
    """Return the fraction of points at or beyond the bounds of their solver."""
    if body.domain is None:
        return None
    near = body.spacing if body.solver == "mpm" else WALL_DISTANCE
    low, high = np.array(body.domain[0]) + near, np.array(body.domain[1]) - near
    return np.array([((x <= low) | (x >= high)).any(axis=1).mean() for x in body.points])


_QUANTITIES: tuple[tuple[str, str, Callable[[RecordedCase, RecordedDeformable], Array | None]], ...] = (
    ("volume", "", _volume),
    ("stretch", "", lambda recording, body: deformation.stretches(body).max(axis=1).astype(float)),
    ("strain", "", _strain),
    ("inverted", "", lambda recording, body: deformation.inverted(body)),
    ("self_penetration", "m", lambda recording, body: folds.self_penetration(body, recording.thickness(body))),
    ("crowding", "", crowding),
    ("against_bounds", "", _share_at_walls),
)
"""Name, unit and values over frames; None if a body has none."""


def first_non_finite(recording: RecordedCase) -> tuple[int, list[str]] | None:
    """Return the first frame with a non-finite point, and the bodies affected; None if all are finite."""
    struck: dict[str, int] = {}
    for body in recording.states.deformables:
        bad = np.flatnonzero(~np.isfinite(body.points).all(axis=(1, 2)))
        if len(bad):
            struck[body.body] = int(bad[0])
    if not struck:
        return None
    first = min(struck.values())
    return first, [name for name, frame in struck.items() if frame == first]
