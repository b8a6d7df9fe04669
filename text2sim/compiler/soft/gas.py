"""Gas in closed cloth."""

from math import sqrt
from pathlib import Path

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.casemesh import load_mesh
from text2sim.compiler.shapes.geometry import volume
from text2sim.compiler.shapes.softmesh import hull_area
from text2sim.spec_schema.errors import AssetError
from text2sim.spec_schema.models.shapes import Mesh
from text2sim.spec_schema.models.soft_bodies import Cloth

BREATHING = 0.5
"""Largest angle [rad] per substep of a hull that breathes on its gas."""


def gas_row(copy: Copy, folder: Path) -> tuple[float, float] | None:
    """Return pressure [Pa] and modulus [Pa] of the gas in a copy, for `templates/gas.py`; None if it has none.

    Raises:
        AssetError: if its mesh is open, or its file cannot be used.
    """
    if not isinstance(copy.model, Cloth) or not copy.model.material.has_gas:
        return None
    if isinstance(copy.shape, Mesh) and not load_mesh(copy.shape.file, folder).closed:
        raise AssetError("has an open surface, which encloses no gas: close it, or leave out pressure and gas_modulus")
    return copy.model.material.pressure or 0.0, copy.model.material.gas_modulus or 0.0


def gas_step(copy: Copy, folder: Path) -> float | None:
    """Return the substep [s] up to which the gas in a copy is stable; None if nothing limits it.

    A hull of area A, volume V and mass m per area breathes at `sqrt(modulus A / (V m))`.

    Raises:
        AssetError: if its mesh is open, or its file cannot be used.
    """
    row = gas_row(copy, folder)
    if row is None or not row[1]:
        return None
    wide = volume(copy.shape, folder) / hull_area(copy.shape, folder)
    return BREATHING * sqrt(wide * copy.model.material.area_density / row[1])
