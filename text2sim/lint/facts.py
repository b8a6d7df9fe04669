"""Facts for the rules: the resolved case and derived values, computed once on demand."""

import math
from collections.abc import Callable, Iterator
from functools import cache, cached_property, wraps
from typing import Any, TypeVar

from text2sim.compiler.build import Resolution
from text2sim.compiler.masses import masses_of
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.shapes import geometry
from text2sim.compiler.shapes.boxes import Bounds, moved, union
from text2sim.compiler.shapes.extents import extents
from text2sim.compiler.shapes.piece import Piece
from text2sim.compiler.shapes.rotation import Quaternion, Vec, quat_rotate, vector_dot
from text2sim.compiler.shapes.sculpting import piece_mesh
from text2sim.compiler.soft.solvers import is_soft
from text2sim.compiler.trees.tree import Tree, tree_links
from text2sim.lint.parts import Ground, StandingPart, near
from text2sim.lint.rule import SEVERITIES
from text2sim.spec_schema.errors import Problem, Severity
from text2sim.spec_schema.models.events import LeftDomainEvent, RegionEvent
from text2sim.spec_schema.names.selectors import body_of
from text2sim.spec_schema.text.document import Path, find_value

T = TypeVar("T")
REPLACING_CONTACT_MODELS = ("sap", "ipc")
"""Contact models that replace the engine's own contacts between rigid bodies."""


def once_per_case(make: Callable[["Facts"], T]) -> Callable[["Facts"], T]:
    """Let a function of the facts of a case be called only once for each case."""

    @wraps(make)
    def look_up(facts: "Facts") -> T:
        return facts.once(make)

    return look_up


class Facts:
    """A resolved case, with the values that rules derive from it."""

    def __init__(self, resolution: Resolution) -> None:
        self.resolution = resolution
        self.loaded = resolution.loaded
        self.placed = resolution.placed
        self.lowering = resolution.lowering
        self.rows = resolution.rows
        self.settings = resolution.settings
        self.plan = resolution.plan
        self.case = resolution.loaded.case
        self.folder = resolution.loaded.folder
        self.parts = cache(self._find_parts)
        """The convex pieces by which a copy collides, at their start poses; none for a plane."""
        self.box = cache(self._find_box)
        """The bounding box [m] of a copy at the start; None for a plane."""
        self._extents: dict[tuple[int, Quaternion], Bounds] = {}
        self._thinnest: dict[int | str, float] = {}
        self._made: dict[Any, Any] = {}

    def once(self, make: Callable[["Facts"], T]) -> T:
        """Return what `make` makes of these facts; it is called only once."""
        if make not in self._made:
            self._made[make] = make(self)
        return self._made[make]

    # --- places of the case ------------------------------------------------------------------------------------

    def problem(
        self,
        rule: str,
        where: str | Path,
        message: str,
        *,
        key: bool = False,
        severity: Severity | None = None,
        hint: str | None = None,
    ) -> Problem:
        """Return a problem.

        Args:
            rule: Id of the rule.
            where: JSON Pointer or path of the value that causes it.
            message: What is wrong, and the remedy with numbers.
            key: Whether to point at the key instead of the value.
            severity: The severity, if it differs from the rule's.
            hint: The nearest valid word.
        """
        severity = severity or SEVERITIES[rule]
        return self.loaded.problem(where, message, key=key, rule=rule, hint=hint, severity=severity)

    def where(self, name: str, *keys: str) -> Path:
        """Return the path of a body or static (or of one of its copies, `brick[3]`), or of a value inside it."""
        body = body_of(name)
        section = ("scene", "statics") if body in self.case.scene.statics else ("bodies",)
        return (*section, body, *keys)

    def first_path(self, *paths: Path) -> Path:
        """Return the first of these paths at which the case gives a value; else the last."""
        return next((path for path in paths if self.value_at(path) is not None), paths[-1])

    def first_given(self, name: str, *keys: str) -> Path:
        """Return the path of the first of these values that the case gives for a body or static; else of the body."""
        return self.first_path(*(self.where(name, key) for key in keys), self.where(name))

    # --- copies ------------------------------------------------------------------------------------------------

    @cached_property
    def copies(self) -> dict[str, Copy]:
        """Every copy of every static and body, by name."""
        return {copy.name: copy for group in self.placed.values() for copy in group}

    @cached_property
    def bonded(self) -> set[str]:
        """Names of the copies that a bond joins to others."""
        return {name for bond in self.rows.bonds for name in (bond.a, bond.b)}

    @cached_property
    def sprung(self) -> set[str]:
        """Names of the copies that a spring acts on at some time."""
        return {name for spring in self.rows.springs for name in (spring.a, spring.b)}

    @cached_property
    def planes(self) -> list[Ground]:
        """The grounds of the scene."""
        found = []
        for group in self.plan.statics:
            for copy, entity in zip(self.placed[group.name], group.entities, strict=True):
                if copy.shape.kind == "plane":
                    up = quat_rotate(copy.quat, (0.0, 0.0, 1.0))
                    level = vector_dot(up, copy.pos)
                    found.append(Ground(copy, up, level, entity.options["plane_size"][0] / 2))
        return found

    def ground(self, copy: Copy) -> Ground | None:
        """Return the ground that a copy is; None if it is not a plane."""
        return next((ground for ground in self.planes if ground.copy is copy), None)

    def tree(self, copy: Copy) -> Tree | None:
        """Return the tree of links of a copy; None for a primitive of the engine."""
        return self.lowering.trees.get(copy.name)

    def mount(self, copy: Copy) -> str:
        """Return how a copy is mounted: `static`, `driven`, `soft`, `tree`, or the kind of its mount."""
        if copy.body in self.case.scene.statics:
            return "static"
        if is_soft(copy.model):
            return "soft"
        kind = copy.model.kind
        return copy.model.mount.kind if kind == "rigid" else "driven" if kind == "driven" else "tree"

    def moves(self, copy: Copy) -> bool:
        """Return whether any part of a copy can move."""
        mount = self.mount(copy)
        if mount == "tree":
            tree = self.tree(copy)
            return tree is None or any(link.all_joints() for link in tree.links())
        return mount not in ("static", "fixed")

    def free(self, copy: Copy) -> bool:
        """Return whether a rigid copy or a tree is free: it falls if nothing is below it. See `loose`."""
        mount = self.mount(copy)
        if mount != "tree":
            return mount == "free"
        tree = self.tree(copy)
        roots = () if tree is None else tree.roots
        return any(joint.kind == "free" for link in roots for _, joint in link.all_joints())

    def loose(self, copy: Copy) -> bool:
        """Return whether nothing holds a copy, rigid or deformable."""
        return self.free(copy) if not is_soft(copy.model) else copy.body not in self._attached

    @cached_property
    def _attached(self) -> set[str]:
        """Deformable bodies with a part that is held, or sewn to another one, at some time."""
        attaches = [control for control in self.case.actions.controls.values() if control.kind == "attach"]
        return {body_of(name) for control in attaches for name in (control.body, control.to)}

    @cached_property
    def moving(self) -> list[Copy]:
        """Copies of bodies that can move."""
        return [copy for name in self.case.bodies for copy in self.placed[name] if self.moves(copy)]

    @cached_property
    def meant_to_leave(self) -> set[str]:
        """Bodies that the case expects to leave."""
        events = [e for e in self.case.actions.events.values() if isinstance(e, LeftDomainEvent | RegionEvent)]
        return {body_of(selector) for event in events if event.kind != "enters" for selector in event.subjects}

    # --- geometry at the start ---------------------------------------------------------------------------------

    def balls(self, copy: Copy) -> list[tuple[Vec, float]]:
        """Return the centre and radius [m] of balls around the pieces of a copy; none for a plane."""
        return self.lowering.balls.get(copy.name, [])

    def _find_parts(self, copy: Copy) -> list[StandingPart]:
        tree = self.tree(copy)
        if tree is not None:
            found = [self._part(geom.piece, copy.pos, copy.quat, False, None) for geom in tree.fixtures]
            for link, pos, quat, moves in tree_links(tree, copy.pos, copy.quat):
                geoms = (geom for geom in link.geoms if geom.touches)
                found += [self._part(geom.piece, pos, quat, moves, link.name) for geom in geoms]
            return found
        if copy.shape is None or copy.shape.kind == "plane":
            return []
        pieces, moves = geometry.pieces(copy.shape, self.folder), self.moves(copy)
        return [self._part(piece, copy.pos, copy.quat, moves, None) for piece in pieces]

    def _part(self, piece: Piece, pos: Vec, quat: Quaternion, moves: bool, link: str | None) -> StandingPart:
        mesh = piece_mesh(piece, self.folder) if piece.collision in ("decompose", "exact") else None
        return StandingPart(piece, pos, quat, moves, link, mesh)

    def _find_box(self, copy: Copy) -> Bounds | None:
        if copy.shape is not None and copy.shape.kind == "plane":
            return None
        tree = self.tree(copy)
        if copy.shape is None or (tree is not None and tree.initial):
            parts = self.parts(copy)
            return union(part.box for part in parts) if parts else None
        # Most copies of a body share their shape.
        key = (id(copy.shape), copy.quat)
        if key not in self._extents:
            self._extents[key] = extents(copy.shape, copy.quat, self.folder)
        return moved(self._extents[key], copy.pos)

    def thinnest(self, copy: Copy) -> float:
        """Return the smallest thickness [m] of the movable pieces of a copy; infinite if there are none."""
        key = copy.name if copy.shape is None else id(copy.shape)
        if key not in self._thinnest:
            thicknesses = (part.thickness for part in self.parts(copy) if part.moves)
            self._thinnest[key] = min(thicknesses, default=math.inf)
        return self._thinnest[key]

    def near(self, slack: float = 0.0, *, soft: bool = False) -> Iterator[tuple[Copy, Copy]]:
        """Yield the pairs of copies whose boxes overlap by more than `slack` [m], if at least one can move.

        The copy that is first in the case is first in the pair. Deformable bodies are included only if `soft`.
        """
        known = [(copy, box) for copy in self.copies.values() if (box := self.box(copy)) is not None]
        known = [entry for entry in known if soft or not is_soft(entry[0].model)]
        moves = [self.moves(copy) for copy, _ in known]
        for i, j in near([box for _, box in known], slack):
            if moves[i] or moves[j]:
                yield known[i][0], known[j][0]

    # --- mass and motion ---------------------------------------------------------------------------------------

    @cached_property
    def masses(self) -> dict[str, float]:
        """Mass [kg] of every rigid copy or tree by its name, except those from model files."""
        copies = (copy for name in self.case.bodies for copy in self.placed[name] if not is_soft(copy.model))
        known = (copy for copy in copies if getattr(copy.model, "file", None) is None)
        return masses_of(self.lowering, self.plan.bodies, known)

    @cached_property
    def pull(self) -> float:
        """Magnitude of gravity [m/s2]."""
        return math.hypot(*self.case.scene.gravity)

    @cached_property
    def up(self) -> Vec:
        """Unit vector against gravity, which must not be zero."""
        x, y, z = self.case.scene.gravity
        return (-x / self.pull, -y / self.pull, -z / self.pull)

    @property
    def own_contact(self) -> bool:
        """Whether rigid bodies use the engine's own contacts."""
        soft = self.settings.soft
        return soft is None or soft.model not in REPLACING_CONTACT_MODELS

    @property
    def substep(self) -> float:
        """Solver step [s]."""
        return self.case.scene.dt / self.settings.substeps

    @cached_property
    def velocities(self) -> dict[str, Vec]:
        """Initial velocity [m/s] of the copies that have one."""
        found: dict[str, Vec] = {}
        for row in self.rows.velocities:
            x, y, z = found.get(row.entity, (0.0, 0.0, 0.0))
            found[row.entity] = (x + row.linear[0], y + row.linear[1], z + row.linear[2])
        return found

    def value_at(self, where: Path) -> Any:
        """Return the evaluated data at a path; None if the case does not give it."""
        return find_value(self.loaded.data, where)
