"""Settings of the solvers of deformable bodies, as templates print them."""

from dataclasses import dataclass
from typing import Any

from text2sim.compiler.shapes.rotation import Quaternion, Vec

MAX_SPEED = 1000.0
"""Default speed [m/s] at which a run stops as diverged: faster than any body should be."""


@dataclass(frozen=True)
class MpmSettings:
    """Settings of the material point method."""

    cell: float
    density: float
    """Cells in a metre."""
    low: Vec
    high: Vec


@dataclass(frozen=True)
class PbdSettings:
    """Settings of position-based dynamics."""

    particle_size: float
    low: Vec
    high: Vec
    stretch_iterations: int
    bending_iterations: int
    hash_size: Vec
    """Extent of the hash grid [m], which repeats."""


@dataclass(frozen=True)
class FemSettings:
    """Settings of the finite element method."""

    newton_iterations: int
    damping_alpha: float
    damping_beta: float
    floor: float | None
    """Height [m] of the floor that fem bodies touch; None if there is none."""


@dataclass(frozen=True)
class SapSettings:
    """Settings of the sap coupler, which fem bodies need."""

    floor: bool
    """Whether there is a floor."""
    rigid: bool
    """Whether there is anything rigid besides the floor."""


@dataclass(frozen=True)
class IpcSettings:
    """Settings of the ipc coupler."""

    contact_distance: float
    """[m]"""
    resistance: float | None
    """Stiffness of contact [Pa]; None for the engine's own."""
    friction: bool


@dataclass(frozen=True)
class SoftRecord:
    """What the recorder needs to know about a deformable body."""

    kind: str
    """soft, cloth, granular, liquid or snow."""
    solver: str
    """mpm, pbd, fem or ipc."""
    spacing: float
    """Distance [m] of neighbouring points at rest."""
    pos: Vec
    """Where its frame is placed [m]."""
    quat: Quaternion
    """How its frame is turned; the engine may be given a mesh that is already turned."""
    mass: float
    """[kg]"""
    bending: tuple[float | None, float | None, bool] | None = None
    """A row of `templates/bending.py`; None for what bends as the engine has it."""
    elastic: tuple[float, float, Vec | None] | None = None
    """A row of `templates/elastic_sheets.py`; None for what hardly stretches."""
    gas: tuple[float, float] | None = None
    """A row of `templates/gas.py`; None for what encloses no gas."""
    damping: float | None = None
    """Rate [1/s] of `templates/internal_damping.py`; None for what has no internal friction of its own."""
    stream: dict[str, Any] | None = None
    """Arguments of `templates/streams.py`; None for what is there at the start."""
    adhesion: float | None = None
    """Traction [Pa] of `templates/adhesion.py`; None for what does not stick."""


@dataclass(frozen=True)
class SoftSettings:
    """Resolved settings of a scene with deformable bodies. `why` holds a sentence for each that was derived."""

    model: str
    """particle, sap or ipc; rigid if bodies of different families do not touch."""
    precision: str
    """32 or 64 bits."""
    mpm: MpmSettings | None
    pbd: PbdSettings | None
    fem: FemSettings | None
    sap: SapSettings | None
    substeps: tuple[tuple[float, str], ...]
    """Longest substeps [s] that are stable, each with a reason."""
    why: dict[str, str]
    ipc: IpcSettings | None
    max_speed: float = MAX_SPEED
    """Speed [m/s] of a point or a link at which the run has diverged."""
    impact: float = 0.0
    """Speed [m/s] at which something may hit snow."""

    def values(self) -> dict[str, str]:
        """Return settings as text, by the names that `why` uses."""
        found = {"model": self.model, "precision": self.precision, "max_speed": f"{self.max_speed:g} m/s"}
        if self.mpm is not None:
            found |= {"mpm_cell": f"{self.mpm.cell:g} m", "mpm_bounds": _bounds_in_words(self.mpm.low, self.mpm.high)}
            found["soft_reach"] = f"{self.mpm.cell / 4:g} m"  # its derived value
        if self.pbd is not None:
            found |= {
                "pbd_size": f"{self.pbd.particle_size:g} m",
                "pbd_bounds": _bounds_in_words(self.pbd.low, self.pbd.high),
                "stretch_iterations": str(self.pbd.stretch_iterations),
                "bending_iterations": str(self.pbd.bending_iterations),
            }
        if self.fem is not None:
            found |= {
                "newton_iterations": str(self.fem.newton_iterations),
                "damping_alpha": f"{self.fem.damping_alpha:g} 1/s",
                "damping_beta": f"{self.fem.damping_beta:g} s",
                "floor": f"{self.fem.floor:g} m" if self.fem.floor is not None else "none",
            }
        if self.ipc is not None:
            found["contact_distance"] = f"{self.ipc.contact_distance:g} m"
        return found


def _bounds_in_words(low: Vec, high: Vec) -> str:
    return " to ".join("[" + ", ".join(f"{x:g}" for x in corner) + "]" for corner in (low, high))
