"""Solvers of deformable bodies. Values that are left out are derived from the scene; `check --settings` says why."""

from typing import Annotated

from pydantic import Field

from text2sim.spec_schema.models.base import Bool, Bounds, Integer, Length, Model, NonNegative, Positive

Iterations = Annotated[Integer, Field(ge=1, le=1000)]


class SolverBounds(Bounds):
    """The space of a solver: an axis-aligned box."""


class Mpm(Model):
    """The material point method: soft bodies with solver mpm, grains, liquids, snow."""

    cell: Length | None = None
    """Cell [m] of the grid; by default the smallest `cell` of its bodies, or derived."""
    bounds: SolverBounds | None = None
    """Space of the grid; material within three cells of its walls stops there. Derived by default."""


class Pbd(Model):
    """Position based dynamics: cloth with solver pbd."""

    particle_size: Length | None = None
    """Distance [m] of particles, and thickness of the cloth in contact; by default the smallest `cell` of its bodies,
    or derived."""
    bounds: SolverBounds | None = None
    """Space in which it searches for neighbours; its sides are walls. Derived by default."""
    stretch_iterations: Iterations | None = None
    """Sweeps over the threads in each substep: more make a stiffer cloth. By default 4 to 32. With n sweeps in
    substeps h, a cloth of length L that hangs gets longer by a part `3 g h^2 L / (n cell^2)`, which they keep below a
    percent."""
    bending_iterations: Iterations | None = None
    """Sweeps over the folds in each substep."""


class Fem(Model):
    """The finite element method: soft bodies with solver fem."""

    newton_iterations: Iterations | None = None
    """Newton iterations of the implicit solver in each substep."""
    damping_beta: NonNegative | None = None
    """Rayleigh damping proportional to stiffness [s]; a body's `damping` is proportional to its mass."""


class Ipc(Model):
    """Incremental potential contact: cloth and soft bodies that never pass through anything. Needs CUDA."""

    contact_distance: Length | None = None
    """Distance [m] at which contact forces begin."""
    contact_resistance: Positive | None = None
    """Stiffness [Pa] of contact."""
    friction: Bool = True
    """Enable friction between bodies."""
