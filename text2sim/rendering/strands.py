"""Strands, such as ropes: capsules in a row that meet in joints, along which patterns run on from link to link."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from text2sim.recording.film_record import WornMesh
from text2sim.rendering.meshes import RenderMesh

Array = NDArray[np.floating]

NEAR = 1e-3
"""Largest distance of a joint from the end of a capsule's straight piece, and difference of widths, over its length."""


def numbers_in_rows(parts: list[WornMesh]) -> dict[int, int]:
    """Return the number of each part that is one of several alike on consecutive links, by its place in the list."""
    found: dict[int, int] = {}
    for k, (one, other) in enumerate(pairwise(parts)):
        alike = (one.body, one.mesh, one.pos, one.quat) == (other.body, other.mesh, other.pos, other.quat)
        if alike and other.link == one.link + 1:
            found[k + 1] = found.setdefault(k, 0) + 1
    return found


def is_strand(mesh: RenderMesh, part: WornMesh) -> bool:
    """Return whether a part is a capsule whose straight piece begins at the joint of its link.

    Args:
        mesh: Mesh of the part.
        part: The part.
    """
    width, other, tall = np.sort(np.ptp(mesh.vertices, axis=0))
    from_joint = 2 * np.linalg.norm(part.pos)
    return bool(from_joint > 0 and max(other - width, abs(from_joint - (tall - width))) < NEAR * tall)
