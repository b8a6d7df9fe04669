"""Contacts of rigid bodies that overlap by more than the thinner body is thick.

The engine looks for contacts once a substep: what arrives with the speed v is up to v times the substep inside by then.
If that is more than a wall, the contact may push it out on the far side.
"""

from dataclasses import dataclass
from math import ceil

import numpy as np

from text2sim.evidence.recorded_case import RecordedCase

SAFE_SHARE = 0.5
"""Part of the thickness to which the advised substeps shall bring the overlap of an impact."""


@dataclass(frozen=True)
class DeepContact:
    """An overlap that is deeper than the thinner body is thick."""

    message: str
    substeps_factor: int
    """Factor on the substeps that brings the overlap of an impact, which is in proportion to them, to a safe one."""


def deepest_contact(recording: RecordedCase) -> DeepContact | None:
    """Return the contact that is deepest relative to the thinner of its bodies, if it is deeper than that is thick.

    Pairs that touch in the first step are left out: they may overlap as the case has them, which the lint tells.
    """
    log = recording.contacts
    thin = np.full(len(recording.states.links), np.inf)
    for link in np.unique(log.links):
        thin[link] = _thickness(recording, int(link))
    share = log.depth / thin[log.links].min(axis=1, initial=np.inf)
    early = {frozenset(pair) for pair in log.links[log.step <= 1].tolist()}
    rows = [row for row in np.flatnonzero(share > 1.0) if frozenset(log.links[row].tolist()) not in early]
    if not rows:
        return None
    row = max(rows, key=lambda row: share[row])
    depth, at, factor = 1e3 * log.depth[row], log.step[row] * recording.states.dt, ceil(share[row] / SAFE_SHARE)
    a, b = (recording.names.label_of_link(link) for link in log.links[row])
    message = (
        f"`{a}` and `{b}` overlap by {depth:.2g} mm at {at:.3g} s, and their thinnest part is "
        f"{depth / share[row]:.2g} mm thick: use more substeps (scene.substeps; {factor} times as many for an impact) "
        "or thicker walls"
    )
    return DeepContact(message, factor)


def _thickness(recording: RecordedCase, link: int) -> float:
    """Return the smallest side [m] of the boxes around the convex pieces of a link; infinite if it has none."""
    solids = [solid for solid in recording.shapes.of(link) if solid.kind not in ("plane", "surface")]
    return float(min((np.min(high - low) for low, high in (solid.bounds for solid in solids)), default=np.inf))
