"""Options with which the engine cuts a solid into tetrahedra."""

import math
from typing import Any

REGULAR_VOLUME = 1 / (6 * math.sqrt(2))
"""Volume of a regular tetrahedron of edge 1."""


def tet_options(edge: float) -> dict[str, Any]:
    """Return the options of a morph that let the engine cut a body into tetrahedra with edges of about `edge` [m].

    The surface already has such edges (`soft_surface`) and stays as it is, which gives better tetrahedra than when
    tetgen divides it too. Most are smaller than the limit; their mean edge is 0.8 to 1 of the wanted one.
    """
    return {"maxvolume": float(f"{REGULAR_VOLUME * edge**3:.4g}"), "nobisect": True}
