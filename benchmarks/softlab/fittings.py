"""What meshes that fit into each other do: a ball in a bowl, a peg in a washer, a bolt in a nut; how it is measured."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import trimesh

from benchmarks.softlab.lab import Lab, Run

PITCH, MAJOR, DEPTH, CLEARANCE = 3e-3, 12e-3, 1.6e-3, 0.3e-3
"""Of an M24 thread [m]."""
BOWL, WALL, BALL = 0.1, 0.01, 0.02
"""Outer radius and wall of the bowl, radius of the ball [m]."""
HOLE, PEG = 0.011, 0.010
"""Radii [m]."""

SCENES = {
    "bowl": """
scene:
  duration: 0.8
  dt: 0.005
  substeps: 2
  statics:
    part: {shape: {kind: mesh, file: bowl.obj, collision: %s}, pose: {pos: [0, 0, 0.1]}, material: {friction: 0.3}}
bodies:
  probe: {kind: rigid, shape: {kind: sphere, radius: 0.02}, pose: {pos: [0, 0, 0.06]}, material: {friction: 0.3}}
""",
    "washer": """
scene:
  duration: 0.6
  dt: 0.005
  substeps: 2
  contact: {friction_cone: pyramidal}
  statics:
    part: {shape: {kind: mesh, file: washer.obj, collision: %s}, pose: {pos: [0, 0, 0.1]}, material: {friction: 0.3}}
bodies:
  probe:
    kind: rigid
    shape: {kind: cylinder, radius: 0.01, height: 0.06}
    pose: {pos: [0.0003, 0, 0.127], euler_deg: [1, 0, 0]}
    material: {friction: 0.3}
""",
    "plank": """
scene:
  duration: 0.5
  dt: 0.005
  substeps: 2
  statics:
    part: {shape: {kind: mesh, file: channel.obj, collision: %s}, pose: {pos: [0, 0, 0.5]}, material: {friction: 0.5}}
bodies:
  probe: {kind: rigid, shape: {kind: box, size: [0.12, 0.03, 0.02]}, pose: {pos: [0, 0, 0.5303]}}
""",
    "bolt": """
scene: {duration: 1.0, dt: 0.005, substeps: 2, contact: {friction_cone: pyramidal}}
bodies:
  part:
    kind: driven
    shape: {kind: mesh, file: bolt.obj, collision: %s}
    motion: {kind: spin, axis: z, speed: 6.283185307}
    material: {friction: 0.1}
  probe:
    kind: rigid
    mount: {kind: slider, axis: z}
    shape: {kind: mesh, file: nut.obj, collision: %s}
    pose: {pos: [0, 0, 0.018]}
    material: {density: 7800, friction: 0.1}
""",
}
TRIALS = (
    ("bowl", "decompose", 0.0),
    ("bowl", "exact", 0.0),
    ("washer", "decompose", 0.0),
    ("washer", "exact", 0.0),
    ("plank", "decompose", 0.0),
    ("plank", "exact", 0.0),
    ("plank_16", "exact", 0.0),
    ("plank_32", "exact", 0.0),
    ("bolt", "decompose", 0.0),
    ("bolt", "exact", 0.8e-3),
    ("bolt", "exact", 0.4e-3),
)
"""Scene, `collision`, `cell` [m] (0: derived)."""


@dataclass(frozen=True)
class Fit:
    """One row of the table."""

    scene: str
    collision: str
    cell: float
    """[m]; 0: derived."""
    sunk: float
    """How deep the two are in each other at most, by their own geometry [m]; negative: how far apart at least."""
    end: str
    """What came of it."""
    cost: float
    """Processor seconds for a simulated one."""


def measure(lab: Lab, scene: str, collision: str, cell: float) -> Fit:
    """Run one trial."""
    said = f"{collision}, cell: {cell:g}" if cell else collision
    kind, _, divided = scene.partition("_")
    made = {one.__name__: one() for one in PARTS[kind]}
    if divided:
        made = {name: finer(mesh, int(divided)) for name, mesh in made.items()}
    files = {f"{name}.obj": str(mesh.export(file_type="obj")) for name, mesh in made.items()}
    text = SCENES[kind].replace("%s", said) + "waive: {overlap: it is a trial, lone-body: it is a trial}\n"
    run = lab.run(text, scene, files)
    sunk, end = LOOKS[kind](run)
    return Fit(scene, collision, cell, sunk, end, run.cpu / float(run.time[-1]))


def _in_bowl(run: Run) -> tuple[float, str]:
    away = np.linalg.norm(run.center("probe") - [0, 0, 0.1], axis=1)
    return float((away + BALL - (BOWL - WALL)).max()), f"ball at {1e3 * run.center('probe')[-1, 2]:.1f} mm"


def _in_washer(run: Run) -> tuple[float, str]:
    quat = run.arrays["links_quat"][:, run.links("probe")[0]]
    w, x, y, z = quat.T
    axis = np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=-1)
    along = run.center("probe")[:, None] + np.linspace(-0.03, 0.03, 121)[None, :, None] * axis[:, None]
    inside = np.abs(along[..., 2] - 0.1) < 0.005
    beside = np.where(inside, np.hypot(along[..., 0], along[..., 1]), 0.0).max()
    end = run.center("probe")[-1, 2]
    return float(beside + PEG - HOLE), "fell through" if end < 0.05 else f"stuck at {1e3 * end:.0f} mm"


def _across(run: Run) -> tuple[float, str]:
    """The lower side of the plank is laid on the walls at 0.52 m."""
    below = 0.53 - run.center("probe")[:, 2]
    return float(below.max()), "fell through" if below[-1] > 0.01 else "lies still"


def _on_bolt(run: Run) -> tuple[float, str]:
    """Two raised cosines that are shifted by e overlap by D sin(pi |e| / P) less the clearance."""
    turns = run.time - run.time[0]  # one a second
    height = run.center("probe")[:, 2]
    shift = height - height[0] + PITCH * turns
    sunk = DEPTH * np.sin(np.pi * np.clip(np.abs(shift) / PITCH, 0, 0.5)) - CLEARANCE
    half = len(turns) // 4
    lead = np.polyfit(turns[half:], height[half:], 1)[0]
    return float(sunk.max()), f"{-1e3 * lead:.2f} mm a turn (pitch {1e3 * PITCH:g} mm)".replace("-", "−")


def table(rows: list[Fit]) -> str:
    """Return the rows as Markdown."""
    lines = [
        "| scene | `collision` | cell | deepest in each other (− if apart) | what came of it | s per simulated s |",
        "|---|---|---|---|---|---|",
    ]
    for one in rows:
        cell = f"{1e3 * one.cell:g} mm" if one.cell else "derived" if one.collision == "exact" else ""
        depth = f"{1e3 * one.sunk:.2f}".replace("-", "−")
        lines.append(f"| {WORDS[one.scene]} | {one.collision} | {cell} | {depth} mm | {one.end} | {one.cost:.1f} |")
    return "\n".join(lines)


def revolved(profile: list[tuple[float, float]], sections: int = 48) -> trimesh.Trimesh:
    """Return a body of revolution about z from a closed profile of (radius, height) [m]."""
    mesh = trimesh.creation.revolve(np.array(profile), sections=sections)
    return _outward(mesh)


def bowl() -> trimesh.Trimesh:
    """A hollow half ball, open at the top; its rim is at z = 0."""
    angles = np.linspace(0, np.pi / 2, 16)
    rings = [(BOWL, angles), (BOWL - WALL, angles[::-1])]
    return revolved([(r * np.sin(a), -r * np.cos(a)) for r, row in rings for a in row])


def washer() -> trimesh.Trimesh:
    """A ring of 10 mm."""
    corners = [(HOLE, -0.005), (0.025, -0.005), (0.025, 0.005), (HOLE, 0.005)]
    return revolved([*corners, corners[0]])


def threaded(length: float, inner: float, chamfer: float = 0.0) -> trimesh.Trimesh:
    """Return a right-handed screw from z = 0 up.

    Args:
        length: [m].
        inner: Radius [m] in the grooves.
        chamfer: By how much its upper end is thinner than that [m].
    """
    around, high = 40, round(length / PITCH * 12) + 1
    turn, height = np.meshgrid(np.arange(around) / around, np.linspace(0, length, high), indexing="ij")
    radius = inner + DEPTH * (0.5 - 0.5 * np.cos(2 * np.pi * (height / PITCH - turn)))
    if chamfer:
        radius = np.minimum(radius, inner - chamfer + length - height)
    x, y = radius * np.cos(2 * np.pi * turn), radius * np.sin(2 * np.pi * turn)
    points = np.stack([x, y, height], axis=-1).reshape(-1, 3)
    a = (np.arange(around)[:, None] * high + np.arange(high - 1)).ravel()
    b = (a + high) % len(points)
    low, top = np.arange(around) * high, np.arange(around) * high + high - 1
    ends = [np.column_stack([np.full(around, len(points) + k), *np.array([rim, np.roll(rim, -1)])[::way]])
            for k, rim, way in ((0, low, -1), (1, top, 1))]  # fmt: skip
    faces = [np.column_stack([a, b, b + 1]), np.column_stack([a, b + 1, a + 1]), *ends]
    return _outward(trimesh.Trimesh(np.vstack([points, [0, 0, 0], [0, 0, length]]), np.vstack(faces)))


def bolt() -> trimesh.Trimesh:
    """A hexagonal head below z = 0, and a thread of 32 mm above."""
    head = trimesh.creation.cylinder(radius=0.036 / 3**0.5, height=0.011, sections=6)
    head.apply_translation([0, 0, -0.0055])
    core = trimesh.creation.cylinder(radius=MAJOR - DEPTH, height=2e-3)
    return trimesh.boolean.union([threaded(0.032, MAJOR - DEPTH, chamfer=0.4e-3), head, core])


def nut() -> trimesh.Trimesh:
    """A hexagonal nut of 12 mm: four turns of the same thread, wider by the clearance."""
    blank = trimesh.creation.cylinder(radius=0.036 / 3**0.5, height=0.012, sections=6)
    blank.apply_translation([0, 0, 0.006])
    tap = threaded(0.018, MAJOR - DEPTH + CLEARANCE)
    tap.apply_translation([0, 0, -PITCH])
    return trimesh.boolean.difference([blank, tap])


def channel() -> trimesh.Trimesh:
    """A trough of 100 mm, open above and at its ends, with walls of 10 mm."""
    outer, inner = trimesh.creation.box((0.1, 0.06, 0.04)), trimesh.creation.box((0.08, 0.1, 0.04))
    inner.apply_translation([0, 0, 0.01])
    return trimesh.boolean.difference([outer, inner])


def finer(mesh: trimesh.Trimesh, parts: int) -> trimesh.Trimesh:
    """Return a mesh with triangles divided until no edge is longer than some part of its longest side."""
    made = trimesh.remesh.subdivide_to_size(mesh.vertices, mesh.faces, float(mesh.extents.max()) / parts)
    return _outward(trimesh.Trimesh(*made[:2]))


def _outward(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    mesh.merge_vertices()
    mesh.fix_normals()
    return mesh


PARTS: dict[str, tuple[Callable[[], trimesh.Trimesh], ...]] = {
    "bowl": (bowl,), "washer": (washer,), "plank": (channel,), "bolt": (bolt, nut)
}  # fmt: skip
LOOKS: dict[str, Callable[[Run], tuple[float, str]]] = {
    "bowl": _in_bowl,
    "washer": _in_washer,
    "plank": _across,
    "bolt": _on_bolt,
}
WORDS = {
    "bowl": "a ball falls 30 mm to the bottom of a bowl", "washer": "a peg of 20 mm falls through a washer of 22 mm",
    "plank": "a plank on both walls of a channel of 16 vertices",
    "plank_16": "the same, divided to edges of a 16th of its length", "plank_32": "to edges of a 32nd",
    "bolt": "an M24 nut, free to slide, on a bolt that turns",
}  # fmt: skip
