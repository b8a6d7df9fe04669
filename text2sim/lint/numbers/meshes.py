"""Mesh files that are not the solid bodies that they stand for."""

from collections.abc import Iterator
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

from text2sim.compiler.shapes.casemesh import load_mesh
from text2sim.compiler.shapes.distance_field import FINE, DistanceField
from text2sim.compiler.shapes.geometry import pieces
from text2sim.compiler.shapes.meshfile import MeshFile
from text2sim.compiler.soft.solvers import is_soft
from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.lint.words import length
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.bodies import Articulated, Chain
from text2sim.spec_schema.models.shapes import Compound, Mesh
from text2sim.spec_schema.text.document import Path

# Imported where it is used: a check of a plain case needs no arrays, and must be quick.
if TYPE_CHECKING:
    import numpy as np

LONG, EMPTY = 1 / 3, 0.7
"""A mesh has few vertices where more than this part of its surface is in triangles longer than this part of it."""
CONVEX = 0.9999
"""Part of its hull that a convex mesh fills."""
MANY_TRIANGLES = 25_000
"""Triangles from which on taking a mesh apart is worth a word."""


class _Use(NamedTuple):
    """A mesh in a shape."""

    where: Path
    shape: Mesh
    weighs: bool
    """Whether its mass follows from its volume, and counts."""
    filled: bool = False
    """Whether it is filled with particles or tetrahedra."""


def _uses(facts: Facts) -> list[_Use]:
    """Return every mesh of the case."""
    return list(_found(facts))


def _found(facts: Facts) -> Iterator[_Use]:
    for name in (*facts.case.scene.statics, *facts.case.bodies):
        copy = facts.placed[name][0]
        model, where = copy.model, facts.where(name)
        if isinstance(model, Articulated):
            for link, its in (model.links or {}).items():
                own = (its.material or model.material).mass is None
                yield from _meshes(its.shape, (*where, "links", link, "shape"), own)
        elif isinstance(model, Chain):
            if model.payload is not None:
                own = model.payload.material.mass is None
                yield from _meshes(model.payload.shape, (*where, "payload", "shape"), own)
        elif is_soft(model):
            if isinstance(model.shape, Mesh) and model.kind != "cloth":
                yield _Use((*where, "shape"), model.shape, weighs=False, filled=True)
        elif (shape := getattr(model, "shape", None)) is not None:
            own = facts.moves(copy) and getattr(model.material, "mass", None) is None
            yield from _meshes(shape, (*where, "shape"), own)


def _meshes(shape: Any, where: Path, weighs: bool) -> Iterator[_Use]:
    if isinstance(shape, Mesh):
        yield _Use(where, shape, weighs)
    elif isinstance(shape, Compound):
        for name, part in shape.parts.items():
            yield from _meshes(part.shape, (*where, "parts", name, "shape"), weighs)


class _Surface(NamedTuple):
    """What the triangles of a mesh make."""

    open_edges: int
    """Edges with one triangle, or with more than two."""
    turned_edges: int
    """Edges whose two triangles look to different sides."""
    volume: float
    """Volume in the file's unit, negative where the triangles look inward."""


@lru_cache(maxsize=64)
def _surface(mesh: MeshFile) -> _Surface:
    import numpy as np

    faces = mesh.faces
    directed = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    ways = np.where(directed[:, 0] < directed[:, 1], 1, -1)
    keys = directed.min(axis=1) * len(mesh.vertices) + directed.max(axis=1)
    _, index, counts = np.unique(keys, return_inverse=True, return_counts=True)
    balance = np.bincount(index.ravel(), weights=ways)
    closed = counts == 2
    return _Surface(int((~closed).sum()), int((closed & (balance != 0)).sum()), _volume(mesh.vertices, faces))


def _volume(vertices: "np.ndarray", faces: "np.ndarray") -> float:
    """Volume that triangles enclose, in the file's unit; negative where they look inward."""
    import numpy as np

    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def _open(facts: Facts) -> Iterator[Problem]:
    for use in facts.own(_uses):
        mesh = load_mesh(use.shape.file, facts.folder)
        if mesh.closed or not use.weighs:
            continue
        found = _surface(mesh)
        if found.open_edges == 0 and found.turned_edges == 0:
            continue  # inside out, which is another rule
        fault = (
            f"is open ({found.open_edges} edges do not join two triangles)"
            if found.open_edges
            else f"has triangles that look to different sides ({found.turned_edges} edges)"
        )
        hull = mesh.volume * use.shape.scale**3
        text = (
            f"`{use.shape.file}` {fault}: it weighs what its convex hull would, {hull:.3g} m3; close the surface, or "
            "give the body a `mass`"
        )
        yield facts.problem("open-mesh", (*use.where, "file"), text)


def _inside_out(facts: Facts) -> Iterator[Problem]:
    for use in facts.own(_uses):
        mesh = load_mesh(use.shape.file, facts.folder)
        if mesh.closed:
            continue
        found = _surface(mesh)
        if found.open_edges == 0 and found.turned_edges == 0 and found.volume < 0:
            text = (
                f"the triangles of `{use.shape.file}` look inward: it is drawn inside out, and weighs what its convex "
                "hull would; turn all of them round"
            )
            yield facts.problem("inside-out-mesh", (*use.where, "file"), text)


def _unfilled(facts: Facts) -> Iterator[Problem]:
    for use in facts.own(_uses):
        mesh = load_mesh(use.shape.file, facts.folder)
        if mesh.closed or not use.filled:
            continue
        found = _surface(mesh)
        if found.open_edges == 0 and found.turned_edges == 0:
            continue
        fault = (
            f"{found.open_edges} of its edges do not join two triangles"
            if found.open_edges
            else f"{found.turned_edges} of its edges join triangles that look to different sides"
        )
        text = (
            f"`{use.shape.file}` has no inside to be filled: {fault}; close the surface (in Blender `Fill holes`, then "
            "`Recalculate outside`), or take `kind: cloth` for a skin"
        )
        yield facts.problem("open-soft-body", (*use.where, "file"), text)


def _slow(facts: Facts) -> Iterator[Problem]:
    for use in facts.own(_uses):
        if use.shape.collision != "decompose":
            continue
        faces = len(load_mesh(use.shape.file, facts.folder).faces)
        if faces > MANY_TRIANGLES:
            # Measured with a bumpy ring on one core: 7 s for 6,400 triangles, 21 s for 25,600, 51 s for 102,400.
            seconds = 7 * (faces / 6400) ** 0.72
            text = (
                f"to take `{use.shape.file}`, with {faces:,} triangles, apart into convex pieces, the engine needs "
                f"about {seconds:.0f} s before the first run; reduce it to some {MANY_TRIANGLES // 5:,} triangles"
            )
            yield facts.problem("slow-mesh", (*use.where, "collision"), text)


def _coarse(facts: Facts) -> Iterator[Problem]:
    for use, field in _exact(facts):
        if field.cell <= field.wall / 2 * (1 + 1e-6):
            continue
        through = field.cell >= field.wall
        text = (
            f"`{use.shape.file}` touches through a field with cells of {length(field.cell)}, and a quarter of its "
            f"walls are thinner than {length(field.wall)}: what presses on them "
            + ("goes through" if through else "may come out on the other side")
        )
        least = max(field.sides) / (FINE - 1)
        if use.shape.cell is not None and least <= field.wall / 2:
            text += f"; a `cell` of {length(field.wall / 2)} or less holds it"
        else:
            text += "; make them thicker, or take `collision: decompose`"
        key = "cell" if use.shape.cell is not None else "collision"
        yield facts.problem("coarse-field", (*use.where, key), text, severity="error" if through else None)


def _sparse(facts: Facts) -> Iterator[Problem]:
    for use, _ in _exact(facts):
        share = _open_share(load_mesh(use.shape.file, facts.folder))
        if share > EMPTY:
            text = (
                f"{share:.0%} of the surface of `{use.shape.file}` is in triangles longer than a third of it: contact "
                "is looked for at vertices, and an edge of another body goes through between them; take `collision: "
                "decompose`, or divide its triangles to edges of a 32nd of its length"
            )
            yield facts.problem("few-vertices", (*use.where, "collision"), text)


@lru_cache(maxsize=64)
def _open_share(mesh: MeshFile) -> float:
    """Part of the surface that is in triangles longer than `LONG` of the longest side of the mesh."""
    import numpy as np

    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    edge = np.maximum.reduce([np.linalg.norm(p - q, axis=1) for p, q in ((a, b), (b, c), (c, a))])
    whole = area.sum()
    return float(area[edge > LONG * np.ptp(mesh.vertices, axis=0).max()].sum() / whole) if whole > 0 else 0.0


def _needless(facts: Facts) -> Iterator[Problem]:
    uses = [use for use, _ in _exact(facts)]
    meshes = [load_mesh(use.shape.file, facts.folder) for use in uses]
    if any(mesh.volume < CONVEX * _volume(mesh.hull_vertices, mesh.hull_faces) for mesh in meshes):
        return
    for use in uses:
        text = (
            f"`{use.shape.file}` is convex, and nothing else here touches by its surface: `collision: hull` is the same"
        )
        yield facts.problem("convex-exact", (*use.where, "collision"), text)


def _exact(facts: Facts) -> Iterator[tuple[_Use, DistanceField]]:
    """Yield the meshes that touch by their surface, with their fields."""
    for use in facts.own(_uses):
        if use.shape.collision == "exact" and not use.filled:
            (piece,) = pieces(use.shape, facts.folder)
            if piece.field is not None:
                yield use, piece.field


RULES = (
    Rule(
        id="open-mesh",
        severity="warning",
        title="A mesh whose volume gives its mass does not enclose one.",
        reason="""\
Mass, centre of mass and inertia are those of the solid that a surface encloses. An open surface (an edge with one
triangle, or with three) encloses none, nor does one whose triangles look to different sides: there the convex hull
counts, which for a cup is the cup filled to the brim. Reported of bodies that move and have no `mass`.""",
        remedy="Close the surface in the tool that made it, or give a `mass`; the hull still places its centre.",
        example="""\
bodies:
  mug: {kind: rigid, shape: {kind: mesh, file: open.obj}, pose: {pos: [0, 0, 0.5]}}
""",
        fix="bodies: {mug: {material: {mass: 0.3}}}",
        run=_open,
    ),
    Rule(
        id="inside-out-mesh",
        severity="warning",
        title="The triangles of a mesh look inward.",
        reason="""\
The corners of a triangle go counterclockwise, seen from outside. Where all of them go the other way, pictures show the
inner side, and the volume is negative, so that the convex hull counts for the mass.""",
        remedy="Turn all faces round in the tool that made the file (`Recalculate outside`, `invert`).",
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
        title="A body that is to be filled has an open surface.",
        reason="""\
Soft bodies, grains, liquids and snow are filled with particles or cut into tetrahedra, and an open surface has no
inside: the engine's filler fills what it takes for it, and its cutter (tetgen) gives up, or ends the process.""",
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
        severity="warning",
        title="A mesh that is to be taken apart has very many triangles.",
        reason=f"""\
With `collision: decompose` the engine finds convex pieces (CoACD) before the first run, and keeps them on this machine.
That takes some 7 s for 6,400 triangles, 20 s for 25,000 and 50 s for 100,000 (measured, one core). Reported above
{MANY_TRIANGLES:,}.""",
        remedy="Use a simplified mesh, or shapes of the language: a `compound`, a `cup`, a `tube`.",
        example="""\
bodies:
  ring: {kind: rigid, shape: {kind: mesh, file: fine.obj, collision: decompose}, pose: {pos: [0, 0, 0.5]}}
""",
        fix="bodies: {ring: {shape: {file: null, collision: null, kind: torus, radius: 0.2, bar_radius: 0.05}}}",
        run=_slow,
    ),
    Rule(
        id="coarse-field",
        severity="warning",
        title="The field of an exact mesh has cells that are too large for its walls.",
        reason="""\
With `collision: exact` the distance to the surface is known at the nodes of a grid, and interpolated between them. In a
wall of less than two cells it never gets as deep as half of the wall, its gradient vanishes, and the engine no longer
knows to which side to push. Thickness is measured along rays; a quarter of the surface has thinner walls. A cell larger
than half of it is a warning, one larger than all of it an error.""",
        remedy="Take a smaller `cell`, thicker walls, `collision: decompose`, or a hollow shape: `cup`, `tube`.",
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
        severity="warning",
        title="An exact mesh has hardly any vertices on its faces.",
        reason="""\
With `collision: exact` the engine looks up vertices of one body in the field of the other. Where two edges cross
between their vertices it finds nothing: a plank of eight corners that was laid across the walls of a channel of sixteen
fell through it. With the channel divided to edges of a 16th of its length it still fell, of a 32nd it lay still.""",
        remedy="Take `collision: decompose`, or divide its triangles finely (in Blender `Subdivide`).",
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
        severity="warning",
        title="All meshes that are to touch by their surface are convex.",
        reason="""\
`collision: exact` is for hollows, holes and threads. Two convex bodies touch as hulls do in any case: the engine makes
no use of their fields, which take time to make.""",
        remedy="Leave `collision` out.",
        example="""\
bodies:
  crate: {kind: rigid, shape: {kind: mesh, file: closed.obj, collision: exact}, pose: {pos: [0, 0, 0.5]}}
""",
        fix="bodies: {crate: {shape: {collision: hull}}}",
        run=_needless,
    ),
)
