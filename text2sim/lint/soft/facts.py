"""Facts for the rules about deformable bodies: solvers, resolutions, and possible contacts."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes.boxes import Bounds
from text2sim.compiler.shapes.softmesh import solid_volume
from text2sim.compiler.soft.scales import PARTICLE_CELLS, Scales, scales, sheet_size, thickness
from text2sim.compiler.soft.solvers import contact_model, is_soft, solver_of, touches_soft
from text2sim.lint.facts import Facts
from text2sim.lint.motion.whereabouts import Whereabouts
from text2sim.lint.parts import Ground, lowest_of
from text2sim.lint.words import length


@dataclass(frozen=True, eq=False)
class SoftBody:
    """One copy of a deformable body."""

    copy: Copy
    solver: str
    """`mpm`, `pbd`, `fem` or `ipc`."""
    box: Bounds
    """Bounding box at the start [m]."""

    @property
    def name(self) -> str:
        """Name of the copy."""
        return self.copy.name

    @property
    def body(self) -> str:
        """Name of the body."""
        return self.copy.body

    @property
    def model(self) -> Any:
        """The validated body, as this copy has it."""
        return self.copy.model


class SoftFacts:
    """The deformable bodies of a case, from `facts.once`."""

    def __init__(self, facts: Facts) -> None:
        self.facts = facts
        self.scene = facts.case.scene
        self.model = contact_model(facts.case.bodies.values(), self.scene)
        """`rigid`, `particle`, `sap` or `ipc`."""

    @cached_property
    def bodies(self) -> list[SoftBody]:
        """All copies of all deformable bodies."""
        found = []
        for name, body in self.facts.case.bodies.items():
            solver = solver_of(body, self.scene)
            if solver is not None:
                for copy in self.facts.placed[name]:
                    box = self.facts.box(copy)
                    if box is not None:
                        found.append(SoftBody(copy, solver, box))
        return found

    def of(self, *solvers: str) -> list[SoftBody]:
        """Return the bodies of some solvers."""
        return [body for body in self.bodies if body.solver in solvers]

    @cached_property
    def scales(self) -> Scales:
        """Their resolutions."""
        return scales(self.scene, self.facts.placed, self.facts.folder)

    @property
    def cell(self) -> float:
        """Cell [m] of the mpm grid; 0 if there is none."""
        return self.scales.mpm_cell or 0.0

    @property
    def particle(self) -> float:
        """Distance [m] of pbd particles; 0 if there are none."""
        return self.scales.pbd_size or 0.0

    # --- sizes ---------------------------------------------------------------------------------------------------

    def thickness(self, body: SoftBody) -> float:
        """Return the smallest thickness [m] of the volume of a body; infinite for cloth."""
        return math.inf if body.model.kind == "cloth" else thickness(body.copy.shape, self.facts.folder)

    def volume(self, body: SoftBody) -> float:
        """Return the volume [m3] at the start; 0 for cloth."""
        return 0.0 if body.model.kind == "cloth" else solid_volume(body.copy.shape, self.facts.folder)

    def in_cells(self, size: float) -> str:
        """Return a length [m] in cells of the mpm grid, with their size: `2.2 cells of the mpm grid (20 mm)`."""
        return f"{size / self.cell:.2g} cells of the mpm grid ({length(self.cell)})"

    def points(self, body: SoftBody) -> int:
        """Return about how many particles or elements a body has; see `compiler.soft.scales`."""
        if body.model.kind == "cloth":
            a, b = sheet_size(body.copy.shape, self.facts.folder)
            return math.ceil(a * b / (0.866 * self.scales.spacing(body.body, body.solver) ** 2))
        if body.solver == "mpm":
            return math.ceil(self.volume(body) / (PARTICLE_CELLS * self.cell) ** 3)
        return math.ceil(6 * math.sqrt(2) * self.volume(body) / self.scales.spacing(body.body, body.solver) ** 3)

    # --- possible contacts ---------------------------------------------------------------------------------------

    @cached_property
    def rigid(self) -> list[Copy]:
        """Copies of rigid bodies and statics that deformable bodies feel, except planes."""
        return [
            copy
            for copy in self.facts.copies.values()
            if not is_soft(copy.model)
            and touches_soft(copy.model)
            and (copy.shape is None or copy.shape.kind != "plane")
            and self.facts.box(copy) is not None
        ]

    @cached_property
    def planes(self) -> list[Ground]:
        """The planes that deformable bodies feel."""
        return [ground for ground in self.facts.planes if touches_soft(ground.copy.model)]

    def comes_down_on(self, upper: Copy, lower: Copy) -> bool:
        """Return whether a copy starts above another one (or in it), whatever is between them."""
        a, b = self.facts.box(upper), self.facts.box(lower)
        if a is None or b is None or self.scene.gravity[2] >= 0.0:
            return False
        beside = any(a[1][k] <= b[0][k] or b[1][k] <= a[0][k] for k in (0, 1))
        return not beside and a[1][2] > b[0][2]

    def meets_plane(self, body: SoftBody, ground: Ground) -> bool:
        """Return whether a body could reach a plane."""
        return lowest_of(self.facts.once(Whereabouts).box(body.copy), ground.up) <= ground.level

    def pairs(self, *solvers: str) -> Iterator[tuple[SoftBody, Copy]]:
        """Yield the pairs of bodies of some solvers and rigid copies that could meet."""
        for body in self.of(*solvers):
            for copy in self.rigid:
                if self.facts.once(Whereabouts).meet(body.copy, copy):
                    yield body, copy
