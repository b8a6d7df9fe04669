"""The solvers of deformable bodies. What is left out is derived from the scene; `check --settings` says why."""

from typing import Annotated

from pydantic import Field

from text2sim.spec_schema.models.base import Bool, Bounds, Integer, Length, Model, NonNegative, Positive

Iterations = Annotated[Integer, Field(ge=1, le=1000)]


class SolverBounds(Bounds):
    """The space of a solver: an upright box."""


class Mpm(Model):
    """The material point method: soft bodies with solver mpm, grains, liquids, snow."""

    cell: Length | None = None
    """Cell [m] of the grid; the smallest `cell` of its bodies, or derived."""
    bounds: SolverBounds | None = None
    """Space of the grid; what comes within three cells of its walls stops there. Derived if left out."""


class Pbd(Model):
    """Position based dynamics: cloth with solver pbd."""

    particle_size: Length | None = None
    """Distance [m] of particles, and thickness of the cloth in contact; the smallest `cell` of its bodies, or
    derived."""
    bounds: SolverBounds | None = None
    """Space in which it looks for neighbours; its sides are walls. Derived if left out."""
    stretch_iterations: Iterations | None = None
    """Sweeps over the threads in each substep: more make a stiffer cloth."""
    bending_iterations: Iterations | None = None
    """Sweeps over the folds in each substep."""


class Fem(Model):
    """The finite element method: soft bodies with solver fem."""

    newton_iterations: Iterations | None = None
    """Of the implicit solver in each substep."""
    damping_beta: NonNegative | None = None
    """Damping in proportion to the stiffness [s] (Rayleigh); a body's `damping` is in proportion to its mass."""


class Ipc(Model):
    """Incremental potential contact: cloth and soft bodies that never pass through anything. Needs CUDA."""

    contact_distance: Length | None = None
    """Distance [m] at which contact begins to push."""
    contact_resistance: Positive | None = None
    """Stiffness [Pa] of contact."""
    friction: Bool = True
    """Friction between bodies."""
