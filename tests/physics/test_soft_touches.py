"""Solids that are written down are those of the case, and points that come near them touch when they must."""

import math

import numpy as np
import pytest

from text2sim.compiler.shapes import geometry
from text2sim.compiler.shapes.rotation import frame_apply
from text2sim.evidence.events import find_events
from text2sim.evidence.rigid_shapes import world_frames

BODIES = """
scene: {duration: 0.24, dt: 0.004, record: {rate: 125}, mpm: {cell: 0.02}, statics: {floor: {shape: {kind: plane}}}}
bodies:
  jelly: {kind: soft, shape: {kind: box, size: [0.08, 0.08, 0.08]}, pose: {pos: [0, 0, 0.26], euler_deg: [0, 0, 40]}}
  table: {kind: rigid, mount: {kind: fixed}, shape: {kind: box, size: [0.2, 0.2, 0.1]}, pose: {pos: [0, 0, 0.05]}}
  cup:
    kind: rigid
    shape: {kind: cup, radius: 0.05, height: 0.12, thickness: 0.01, segments: 8}
    pose: {pos: [0.5, 0, 0.5], euler_deg: [50, 20, 70]}
  pill: {kind: rigid, shape: {kind: capsule, radius: 0.02, length: 0.1}, pose: {pos: [0.5, 0.4, 0.5], euler_deg: [30, 0, 0]}}
  cone: {kind: rigid, shape: {kind: cone, radius: 0.05, height: 0.1}, pose: {pos: [0.5, -0.4, 0.5], euler_deg: [0, 60, 0]}}
  drum: {kind: rigid, shape: {kind: cylinder, radius: 0.04, height: 0.1}, pose: {pos: [-0.5, 0, 0.5], euler_deg: [0, 60, 0]}}
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.04}, pose: {pos: [-0.5, 0.4, 0.5]}}
actions:
  measures:
    gap: {kind: gap, of: jelly, to: table}
    side: {kind: position, of: jelly, axis: x, region: {edge: [right, front]}}
  events:
    lands: {kind: contact, between: [jelly, table]}
"""


def corners_of(piece):
    """Return points of a piece in its own frame."""
    size = piece.size
    if piece.kind == "hull":
        return list(piece.vertices)
    if piece.kind == "box":
        x, y, z = (s / 2 for s in size)
        return [(a, b, c) for a in (-x, x) for b in (-y, y) for c in (-z, z)]
    ring = [(math.cos(math.pi * k / 8), math.sin(math.pi * k / 8)) for k in range(16)]
    if piece.kind == "cylinder":
        return [(size[0] * c, size[0] * s, z) for c, s in ring for z in (-size[1] / 2, size[1] / 2)]
    half = size[1] / 2 if piece.kind == "capsule" else 0.0
    latitudes = [(math.cos(math.pi * k / 16), math.sin(math.pi * k / 16)) for k in range(-8, 9)]
    return [
        (size[0] * c * a, size[0] * s * a, size[0] * b + math.copysign(half, b)) for a, b in latitudes for c, s in ring
    ]


def test_solids_gaps_and_touches(simulate, agree):
    trial = simulate(BODIES)
    recording, states = trial.recording, trial.states
    for name in ("table", "cup", "pill", "cone", "drum", "ball"):
        (target,) = recording.names.select(name)
        solids = recording.shapes.of_links(target.links)
        made = geometry.pieces(trial.case.bodies[name].shape, trial.folder)
        assert len(solids) == len(made), name
        # Whatever the engine makes of a frame, the corners of the pieces have to lie on the recorded solids.
        corners = np.array([frame_apply(piece.pos, piece.quat, p) for piece in made for p in corners_of(piece)])
        world = trial.pos(name)[-1] + corners @ trial.turn(name)[-1].T
        nearest = np.full(len(world), np.inf)
        for link, solid in solids:
            pos, turn = world_frames(states, link, solid)
            nearest = np.minimum(nearest, solid.distance((world - pos[-1]) @ turn[-1]))
        agree(f"corners of `{name}` on its solids [m]", nearest, 0.0, within=2e-3)
        assert nearest.min() > -1e-3
    # It falls freely until its particles are a cell above the table, half a spacing inside its surface.
    points = states.deformables[0].points
    gap = trial.measure("gap")
    agree("the gap at the start [m]", gap[0], float(points[0, :, 2].min()) - 0.1, within=1e-6)
    (row, *_) = find_events(recording, {}).occurrences["lands"]
    assert row["time"] == pytest.approx(np.sqrt(2 * (gap[0] - 0.02) / 9.81), abs=0.012)
    # The edge between right and front, of a cube turned by 40 degrees.
    agree(
        "an edge of the body's own frame [m]",
        trial.measure("side")[0],
        0.04 * (np.cos(0.698) + np.sin(0.698)),
        within=0.02,
    )
