"""Contact with the surface of a mesh: what its hull would fill stays hollow, and is as deep as the mesh says."""

import numpy as np
import pytest
import trimesh

RADIUS, WALL, BALL = 0.1, 0.02, 0.02

CASE = """\
scene:
  duration: 0.6
  dt: 0.005
  substeps: 2
  statics:
    bowl: {shape: {kind: mesh, file: bowl.obj, collision: exact}, pose: {pos: [0, 0, 0.1]}}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.02}, pose: {pos: [0, 0, 0.06]}}
"""


def bowl() -> str:
    """A hollow half ball, its rim at z = 0, as an .obj file."""
    angles = np.linspace(0, np.pi / 2, 10)
    rings = ((RADIUS, angles), (RADIUS - WALL, angles[::-1]))
    profile = np.array([(r * np.sin(a), -r * np.cos(a)) for r, row in rings for a in row])
    mesh = trimesh.creation.revolve(profile, sections=24)
    mesh.merge_vertices()
    mesh.fix_normals()
    return trimesh.exchange.obj.export_obj(mesh)


@pytest.fixture(scope="module")
def trial(simulate):
    """A ball that is let go 20 mm above the bottom of a bowl, of which the hull is a solid half ball."""
    return simulate(CASE, {"bowl.obj": bowl()})


def test_a_ball_rests_on_the_inside_of_a_bowl(trial, agree):
    """Its middle is `RADIUS - WALL - BALL` below that of the bowl; on the hull it would be `BALL` above."""
    rest = 0.1 - (RADIUS - WALL - BALL)
    agree("height of the ball [m]", trial.pos("ball")[-1, 2], rest, within=5e-4)
    agree("beside the middle [m]", np.hypot(*trial.pos("ball")[-1, :2]), 0.0, within=2e-3)
