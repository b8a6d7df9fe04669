"""Mesh files that are open, inside out, too fine, or unsuitable for their kind of collision."""

from collections.abc import Iterator
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

from text2sim.compiler.shapes.casemesh import load_mesh
from text2sim.compiler.shapes.distance_field import MAX_NODES, DistanceField
from text2sim.compiler.shapes.geometry import pieces
from text2sim.compiler.shapes.meshfile import MeshFile
from text2sim.compiler.shapes.triangles import enclosed_volume
from text2sim.compiler.soft.solvers import is_soft
from text2sim.lint.facts import Facts, once_per_case
from text2sim.lint.rule import Rule
from text2sim.lint.words import length, length_of_at_most
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.bodies import Articulated, Chain
from text2sim.spec_schema.models.shapes import Compound, Mesh
from text2sim.spec_schema.text.document import Path

# numpy is imported where it is used, because a check of a plain case must be quick.
if TYPE_CHECKING:
    pass

LONG_TRIANGLE, MAX_LONG_SHARE = 1 / 3, 0.7
"""Share of the mesh's size above which a triangle is long, and largest share of the surface in such triangles."""
CONVEX_FILL = 0.9999
"""Share of its hull that a convex mesh fills."""
MANY_TRIANGLES = 25_000
"""Most triangles of a mesh that is decomposed without a warning."""


class _Use(NamedTuple):
    """A mesh in a shape."""

    where: Path
    shape: Mesh
    mesh: MeshFile
    weighs: bool = False
    """Whether its volume gives the mass of a moving body."""
    filled: bool = False
    """Whether it is filled with particles or tetrahedra."""

    @property
    def fault(self) -> str:
        """Why its surface encloses no volume; empty if it does."""
        return "" if self.mesh.closed else _surface(self.mesh).fault


@once_per_case
def _uses(facts: Facts) -> list[_Use]:
    """Return every mesh of the case."""
    return [
        _Use(where, shape, load_mesh(shape.file, facts.folder), weighs, filled)
        for where, shape, weighs, filled in _find(facts)
    ]


def _find(facts: Facts) -> Iterator[tuple[Path, Mesh, bool, bool]]:
    """Yield path and shape of every mesh, whether it gives a mass, and whether it is filled."""
    for name in (*facts.case.scene.statics, *facts.case.bodies):
        copy = facts.placed[name][0]
        model, where = copy.model, facts.where(name)
        if isinstance(model, Articulated):
            for link_name, link in (model.links or {}).items():
                own = (link.material or model.material).mass is None
                yield from _meshes(link.shape, (*where, "links", link_name, "shape"), own)
        elif isinstance(model, Chain):
            if model.payload is not None:
                own = model.payload.material.mass is None
                yield from _meshes(model.payload.shape, (*where, "payload", "shape"), own)
        elif is_soft(model):
            if isinstance(model.shape, Mesh) and model.kind != "cloth":
                yield (*where, "shape"), model.shape, False, True
        elif (shape := getattr(model, "shape", None)) is not None:
            own = facts.moves(copy) and getattr(model.material, "mass", None) is None
            yield from _meshes(shape, (*where, "shape"), own)


def _meshes(shape: Any, where: Path, weighs: bool) -> Iterator[tuple[Path, Mesh, bool, bool]]:
    if isinstance(shape, Mesh):
        yield where, shape, weighs, False
    elif isinstance(shape, Compound):
        for name, part in shape.parts.items():
            yield from _meshes(part.shape, (*where, "parts", name, "shape"), weighs)


class _Surface(NamedTuple):
    """Topology and volume of the triangles of a mesh."""

    open_edges: int
    """Edges with one triangle, or with more than two."""
    turned_edges: int
    """Edges whose two triangles have opposite orientations."""
    volume: float
    """Volume in the file's unit, negative if the triangles face inward."""

    @property
    def fault(self) -> str:
        """Why the surface encloses no volume; empty if it does."""
        if self.open_edges:
            return f"is open ({self.open_edges} edges do not join two triangles)"
        if self.turned_edges:
            return f"has triangles of opposite orientation ({self.turned_edges} edges)"
        return ""


@lru_cache(maxsize=64)
def _surface(mesh: MeshFile) -> _Surface:
    import numpy as np

    faces = mesh.faces
    directed = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    signs = np.where(directed[:, 0] < directed[:, 1], 1, -1)
    keys = directed.min(axis=1) * len(mesh.vertices) + directed.max(axis=1)
    _, index, counts = np.unique(keys, return_inverse=True, return_counts=True)
    balance = np.bincount(index.ravel(), weights=signs)
    closed = counts == 2
    return _Surface(int((~closed).sum()), int((closed & (balance != 0)).sum()), enclosed_volume(mesh.vertices, faces))


def _open_meshes(facts: Facts) -> Iterator[Problem]:
    for use in _uses(facts):
        if use.weighs and use.fault:
            hull = use.mesh.volume * use.shape.scale**3
            text = (
                f"`{use.shape.file}` {use.fault}: its mass is that of its convex hull, {hull:.3g} m3; close the "
                "surface, or give the body a `mass`"
            )
            yield facts.problem("open-mesh", (*use.where, "file"), text)


def _inside_out(facts: Facts) -> Iterator[Problem]:
    for use in _uses(facts):
        if not use.mesh.closed and not use.fault and _surface(use.mesh).volume < 0:
            text = (
                f"the triangles of `{use.shape.file}` face inward: it is drawn inside out, and its mass is that of its "
                "convex hull; flip all triangles"
            )
            yield facts.problem("inside-out-mesh", (*use.where, "file"), text)


def _unfilled(facts: Facts) -> Iterator[Problem]:
    for use in _uses(facts):
        if use.filled and use.fault:
            text = (
                f"`{use.shape.file}` {use.fault} and has no inside to fill; close the surface (in Blender `Fill "
                "holes`, then `Recalculate outside`), or use `kind: cloth` for a skin"
            )
            yield facts.problem("open-soft-body", (*use.where, "file"), text)


def _slow_meshes(facts: Facts) -> Iterator[Problem]:
    for use in _uses(facts):
        faces = len(use.mesh.faces)
        if use.shape.collision == "decompose" and faces > MANY_TRIANGLES:
            # Measured with a bumpy ring on one core: 7 s for 6,400 triangles, 21 s for 25,600, 51 s for 102,400.
            seconds = 7 * (faces / 6400) ** 0.72
            text = (
                f"the engine needs about {seconds:.0f} s before the first run to decompose `{use.shape.file}`, with "
                f"{faces:,} triangles, into convex pieces; reduce it to about {MANY_TRIANGLES // 5:,} triangles"
            )
            yield facts.problem("slow-mesh", (*use.where, "collision"), text)


def _coarse(facts: Facts) -> Iterator[Problem]:
    for use, field in _exact(facts):
        if field.cell <= field.wall / 2 * (1 + 1e-6):
            continue
        through = field.cell >= field.wall
        text = (
            f"`{use.shape.file}` collides by a field with cells of {length(field.cell)}, and a quarter of its walls "
            f"are thinner than {length(field.wall)}: bodies pressed against them "
            + ("pass through" if through else "may come out on the other side")
        )
        least = max(field.sides) / (MAX_NODES - 1)
        if use.shape.cell is not None and least <= field.wall / 2:
            text += f"; use a `cell` of {length_of_at_most(field.wall / 2)} or less"
        else:
            text += "; make them thicker, or use `collision: decompose`"
        key = "cell" if use.shape.cell is not None else "collision"
        yield facts.problem("coarse-field", (*use.where, key), text, severity="error" if through else None)


def _sparse(facts: Facts) -> Iterator[Problem]:
    for use, _ in _exact(facts):
        share = _long_share(use.mesh)
        if share > MAX_LONG_SHARE:
            text = (
                f"{share:.0%} of the surface of `{use.shape.file}` is in triangles longer than a third of it: contact "
                "is detected at vertices, and an edge of another body passes through between them; use `collision: "
                "decompose`, or subdivide its triangles to edges of a 32nd of its length"
            )
            yield facts.problem("few-vertices", (*use.where, "collision"), text)


@lru_cache(maxsize=64)
def _long_share(mesh: MeshFile) -> float:
    """Return the share of the surface in triangles longer than `LONG_TRIANGLE` of the longest side of the mesh."""
    import numpy as np

    from text2sim.assets.surface import triangle_areas

    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    area = triangle_areas(mesh.vertices[mesh.faces])
    edge = np.maximum.reduce([np.linalg.norm(p - q, axis=1) for p, q in ((a, b), (b, c), (c, a))])
    whole = area.sum()
    return float(area[edge > LONG_TRIANGLE * np.ptp(mesh.vertices, axis=0).max()].sum() / whole) if whole > 0 else 0.0


def _needless_decomposition(facts: Facts) -> Iterator[Problem]:
    uses = [use for use, _ in _exact(facts)]
    hulls = [enclosed_volume(use.mesh.hull_vertices, use.mesh.hull_faces) for use in uses]
    if any(use.mesh.volume < CONVEX_FILL * hull for use, hull in zip(uses, hulls, strict=True)):
        return
    for use in uses:
        text = (
            f"`{use.shape.file}` is convex, and no other mesh here collides by its surface: `collision: hull` gives "
            "the same contacts"
        )
        yield facts.problem("convex-exact", (*use.where, "collision"), text)


def _exact(facts: Facts) -> Iterator[tuple[_Use, DistanceField]]:
    """Yield the meshes that collide by their surface, with their fields."""
    for use in _uses(facts):
        if use.shape.collision == "exact" and not use.filled:
            (piece,) = pieces(use.shape, facts.folder)
            if piece.field is not None:
                yield use, piece.field


RULES = (
    Rule(
        id="open-mesh",
        title="A mesh whose volume gives the mass is not closed.",
        reason="""\
Mass, centre of mass and inertia are those of the solid that a surface encloses. An open surface (an edge with one
triangle, or with three) encloses none, nor does one with triangles of opposite orientation: then the convex hull
counts, which for a cup is the cup filled to the brim. The rule checks moving bodies without a `mass`.""",
        remedy="Close the surface in the tool that made it, or give a `mass`; the hull still gives the centre of mass.",
        example="""\
bodies:
  mug: {kind: rigid, shape: {kind: mesh, file: open.obj}, pose: {pos: [0, 0, 0.5]}}
""",
        fix="bodies: {mug: {material: {mass: 0.3}}}",
        run=_open_meshes,
    ),
    Rule(
        id="inside-out-mesh",
        title="The triangles of a mesh face inward.",
        reason="""\
The corners of a triangle are in counterclockwise order, seen from outside. If all triangles have the opposite order,
pictures show the inner side, and the volume is negative, so the convex hull gives the mass.""",
        remedy="Flip all faces in the tool that made the file (`Recalculate outside`, `invert`).",
        example="""\
bodies:
  mug: {kind: rigid, shape: {kind: mesh, file: inverted.obj}, pose: {pos: [0, 0, 0.5]}}
""",
        fix="bodies: {mug: {shape: {file: closed.obj}}}",
        run=_inside_out,
    ),
    Rule(
        id="open-soft-body",
        severity="error",
        title="A body that is filled has an open surface.",
        reason="""\
Soft bodies, grains, liquids and snow are filled with particles or tetrahedra, and an open surface has no inside: the
engine's particle filler guesses it, and its mesher (tetgen) fails or crashes the process.""",
        remedy="Close the surface in the tool that made the file; a skin without volume is a `cloth`.",
        example="""\
bodies:
  mug: {kind: soft, shape: {kind: mesh, file: open.obj}, pose: {pos: [0, 0, 0.5]}}
""",
        fix="bodies: {mug: {shape: {file: closed.obj}}}",
        run=_unfilled,
    ),
    Rule(
        id="slow-mesh",
        title="A mesh for convex decomposition has very many triangles.",
        reason=f"""\
With `collision: decompose` the engine computes convex pieces (CoACD) before the first run and caches them on this
machine. That takes some 7 s for 6,400 triangles, 20 s for 25,000 and 50 s for 100,000 (measured, one core). The rule
reports more than {MANY_TRIANGLES:,}.""",
        remedy="Use a simplified mesh, or shapes of the language: a `compound`, a `cup`, a `tube`.",
        example="""\
bodies:
  ring: {kind: rigid, shape: {kind: mesh, file: fine.obj, collision: decompose}, pose: {pos: [0, 0, 0.5]}}
""",
        fix="bodies: {ring: {shape: {file: null, collision: null, kind: torus, radius: 0.2, bar_radius: 0.05}}}",
        run=_slow_meshes,
    ),
    Rule(
        id="coarse-field",
        title="The field of an exact mesh has cells that are too large for its walls.",
        reason="""\
With `collision: exact` the distance to the surface is known at the nodes of a grid and interpolated between them. In a
wall of less than two cells it never reaches half of the wall, its gradient vanishes, and the engine does not know to
which side to push. Thickness is measured along rays; a quarter of the surface has thinner walls. A cell larger than
half of it is a warning, one larger than all of it an error.""",
        remedy="Use a smaller `cell`, thicker walls, `collision: decompose`, or a hollow shape: `cup`, `tube`.",
        example="""\
bodies:
  ring: {kind: rigid, shape: {kind: mesh, file: ring.obj, collision: exact, cell: 0.05}, pose: {pos: [0, 0, 0.5]}}
""",
        fix="bodies: {ring: {shape: {cell: 0.01}}}",
        run=_coarse,
        own_contact=True,
    ),
    Rule(
        id="few-vertices",
        title="An exact mesh has hardly any vertices on its faces.",
        reason="""\
With `collision: exact` the engine looks up vertices of one body in the field of the other. It finds no contact where
two edges cross between their vertices: a plank with eight corners fell through the walls of a channel with sixteen.
With the channel subdivided to edges of a 16th of its length it still fell; of a 32nd, it lay still.""",
        remedy="Use `collision: decompose`, or subdivide its triangles (in Blender `Subdivide`).",
        example="""\
bodies:
  frame: {kind: rigid, shape: {kind: mesh, file: channel.obj, collision: exact}, pose: {pos: [0, 0, 0.5]}}
""",
        fix="bodies: {frame: {shape: {collision: decompose}}}",
        run=_sparse,
        own_contact=True,
    ),
    Rule(
        id="convex-exact",
        title="All meshes with exact collision are convex.",
        reason="""\
`collision: exact` is for hollows, holes and threads. Two convex bodies collide as hulls in any case: the engine does
not use their fields, which take time to compute.""",
        remedy="Leave `collision` out.",
        example="""\
bodies:
  crate: {kind: rigid, shape: {kind: mesh, file: closed.obj, collision: exact}, pose: {pos: [0, 0, 0.5]}}
""",
        fix="bodies: {crate: {shape: {collision: hull}}}",
        run=_needless_decomposition,
    ),
)
