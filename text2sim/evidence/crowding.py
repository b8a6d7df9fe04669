"""Crowding: how much closer together the particles of a liquid are than at its density."""

from math import pi

import numpy as np
from scipy.spatial import KDTree

from text2sim.evidence.recorded_case import RecordedCase
from text2sim.recording.deformables import RecordedDeformable
from text2sim.recording.states import Array
from text2sim.spec_schema.models.soft_bodies import Liquid
from text2sim.spec_schema.names.selectors import body_of

REACH = 2.5
"""Radius of the ball in which neighbours are counted, in spacings of particles."""
FRAMES, SAMPLES = 24, 2000
"""Largest number of frames and of particles that are examined."""
INNER = 75.0
"""Percentile of the particles that counts: those at walls and the surface have fewer neighbours."""
NOTABLE = 1.2
"""Density that is no longer chance."""


def crowding(recording: RecordedCase, body: RecordedDeformable) -> Array | None:
    """Return the density of a liquid relative to that of its material, shape (F,), NaN in frames between samples.

    A ball of radius r around a particle holds `4/3 pi (r / spacing)^3` of them at the density of the material. None for
    what is no liquid, for streams, whose particles wait in the mouth, and if it is never notably dense.
    """
    model = recording.case.bodies.get(body_of(body.body))
    if not isinstance(model, Liquid) or model.shape.kind == "stream":
        return None
    expected, found = 4 / 3 * pi * REACH**3, np.full(len(body.points), np.nan)
    for frame in np.unique(np.linspace(0, len(body.points) - 1, FRAMES).astype(int)):
        points = body.points[frame].astype(float)
        if not np.isfinite(points).all():
            continue
        some = points[:: 1 + len(points) // SAMPLES]
        neighbours = KDTree(points).query_ball_point(some, REACH * body.spacing, return_length=True)
        found[frame] = np.percentile(neighbours, INNER) / expected
    return found if np.nanmax(found, initial=0.0) > NOTABLE else None
