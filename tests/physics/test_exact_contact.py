"""Contact with the surface of a mesh or sculpt: what its hull would fill stays hollow, and is as deep as the surface says."""

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
    dish:
      shape: {kind: sculpt, collision: exact, parts: {wall: {kind: revolve, closed: true, profile: PROFILE}}}
      pose: {pos: [0.5, 0, 0.1]}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.02}, pose: {pos: [0, 0, 0.06]}}
  pea: {kind: rigid, shape: {kind: sphere, radius: 0.02}, pose: {pos: [0.5, 0, 0.06]}}
"""
ANGLES = np.linspace(0, np.pi / 2, 10)
RINGS = ((RADIUS, ANGLES), (RADIUS - WALL, ANGLES[::-1]))
PROFILE = np.array([(r * np.sin(a), -r * np.cos(a)) for r, row in RINGS for a in row])


def bowl() -> str:
    """A hollow half ball, its rim at z = 0, as an .obj file."""
    mesh = trimesh.creation.revolve(PROFILE, sections=24)
    mesh.merge_vertices()
    mesh.fix_normals()
    return trimesh.exchange.obj.export_obj(mesh)


@pytest.fixture(scope="module")
def trial(simulate):
    """Balls that are let go 20 mm above the bottoms of two bowls, of which the hulls are solid half balls."""
    return simulate(CASE.replace("PROFILE", str(PROFILE.round(6).tolist())), {"bowl.obj": bowl()})


@pytest.mark.parametrize(("ball", "middle"), [("ball", 0.0), ("pea", 0.5)])
def test_a_ball_rests_on_the_inside_of_a_bowl(trial, agree, ball, middle):
    """Its middle is `RADIUS - WALL - BALL` below that of the bowl; on the hull it would be `BALL` above."""
    rest = 0.1 - (RADIUS - WALL - BALL)
    x, y, z = trial.pos(ball)[-1]
    agree("height of the ball [m]", z, rest, within=5e-4)
    agree("beside the middle [m]", np.hypot(x - middle, y), 0.0, within=2e-3)
