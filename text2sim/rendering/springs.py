"""Springs between bodies: coils of metal and cords of rubber, which are only drawn."""

from typing import Any

import numpy as np

from text2sim.recording.film_record import FilmRecord
from text2sim.rendering.finishes import material
from text2sim.rendering.shapes import mesh_shape, shaded
from text2sim.templates.coils import Coils

FINISHES = {"coil": "metal", "cord": "rubber"}


class Springs:
    """All springs of a film.

    Args:
        recording: The recording of the run.
    """

    def __init__(self, recording: FilmRecord):
        self._looks = recording.film.get("springs", {})
        self._coils = Coils(recording.states, self._looks)
        self._materials = {form: material(finish, two_sided=True) for form, finish in FINISHES.items()}
        self.has_metal = any(look["form"] == "coil" for look in self._looks.values())

    def shapes(self, t: float, bsdf: Any = None, *, metal_only: bool = False) -> dict[str, Any]:
        """Return the mesh of each spring that acts at a time [s], by name.

        Args:
            t: Simulated time [s].
            bsdf: Material instead of their own.
            metal_only: Whether cords are left out.
        """
        found = {}
        for k, strand in enumerate(self._coils.at(t)):
            if metal_only and strand.form != "coil":
                continue
            color, _ = shaded(self._looks[strand.control]["color"], FINISHES[strand.form])
            found[f"spring_{k}"] = mesh_shape(
                f"spring_{k}", bsdf or self._materials[strand.form], strand.vertices, strand.faces, strand.normals,
                colors=np.broadcast_to(color, strand.vertices.shape),
            )  # fmt: skip
        return found
