"""Flat faces of polyhedra: they slide by Coulomb's law, and hold each other as wide faces do."""

from math import cos, radians, sin, tan

import numpy as np
import pytest

G, DT, MU, SLOPE = 9.81, 0.005, 0.3, 30.0
HALF = 8.0
"""Half of the keystone's angle [deg]: less than atan(0.8), so that friction holds it."""


def keystone(bottom: float, top: float, height: float, depth: float) -> str:
    corners = [
        [side * half, y, z]
        for y in (-depth / 2, depth / 2)
        for z, half in ((0.0, bottom / 2), (height, top / 2))
        for side in (-1, 1)
    ]
    return str([[round(c, 7) for c in corner] for corner in corners])


def abutment(side: int, bottom: float, top: float, height: float, depth: float) -> str:
    inner = [(side * bottom / 2, 0.0), (side * top / 2, height), (side * 0.5, 0.0), (side * 0.5, height)]
    return str([[round(x, 7), y, z] for y in (-depth / 2, depth / 2) for x, z in inner])


BOTTOM, HEIGHT, DEPTH = 0.24, 0.32, 0.5
TOP = BOTTOM + 2 * HEIGHT * tan(radians(HALF))
SCENE = f"""
scene:
  duration: 0.5
  dt: {DT}
  substeps: 2
  statics:
    slope:
      shape: {{kind: polyhedron, points: [[-2, -1, 0], [2, -1, 0], [-2, 1, 0], [2, 1, 0], [-2, -1, {4 * tan(radians(SLOPE))}], [-2, 1, {4 * tan(radians(SLOPE))}]]}}
      material: {{friction: 0.01}}
    left: {{shape: {{kind: polyhedron, points: {abutment(-1, BOTTOM, TOP, HEIGHT, DEPTH)}}}, pose: {{pos: [0, 5, 1]}}, material: {{friction: 0.8}}}}
    right: {{shape: {{kind: polyhedron, points: {abutment(1, BOTTOM, TOP, HEIGHT, DEPTH)}}}, pose: {{pos: [0, 5, 1]}}, material: {{friction: 0.8}}}}
bodies:
  cube:
    kind: rigid
    shape: {{kind: polyhedron, points: [[-0.1, -0.1, 0], [0.1, -0.1, 0], [-0.1, 0.1, 0], [0.1, 0.1, 0], [-0.1, -0.1, 0.1], [0.1, -0.1, 0.1], [-0.1, 0.1, 0.1], [0.1, 0.1, 0.1]]}}
    material: {{friction: {MU}}}
    pose: {{pos: [-1, 0, {3 * tan(radians(SLOPE))}], euler_deg: [0, {SLOPE}, 0]}}
  keystone:
    kind: rigid
    shape: {{kind: polyhedron, points: {keystone(BOTTOM, TOP, HEIGHT, DEPTH)}}}
    material: {{density: 2400, friction: 0.8}}
    pose: {{pos: [0, 5, 1]}}
  weight:
    kind: rigid
    shape: {{kind: box, size: [0.3, 0.4, 0.3]}}
    material: {{density: 7800, friction: 0.8}}
    pose: {{pos: [0, 5, {1 + HEIGHT + 0.15}]}}
"""


@pytest.fixture(scope="module")
def trial(simulate):
    return simulate(SCENE)


def test_a_cube_slides_down_a_wedge_as_coulomb_has_it(trial, agree):
    """V = g (sin s - mu cos s) t; a step of the implicit Euler method adds at most g dt."""
    way = np.array([cos(radians(SLOPE)), 0, -sin(radians(SLOPE))])
    speed = G * (sin(radians(SLOPE)) - MU * cos(radians(SLOPE))) * trial.time[-1]
    agree("speed of a cube down a wedge", trial.vel("cube")[-1] @ way, speed, within=G * DT)


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_loaded_keystone_touches_its_neighbours_by_whole_faces(trial, side):
    """One or two points hold no moment about the normal: the stone would turn out of the arch under its load."""
    log, (stone, wall) = trial.states, (trial.recording.names.select(name)[0].root for name in ("keystone", side))
    links = log.contact("links")
    both = (np.isin(links, (stone, wall)).all(axis=1)) & (log.contact("step") == log.contact("step").max())
    assert log.chunks.gather("contact_count", ())[both].sum() >= 3


def test_a_loaded_keystone_stays(trial, agree):
    """At rest: it turns by less than the depth of its contacts (0.5 mm at most) over its height."""
    turned = trial.turn("keystone")[-1] @ trial.turn("keystone")[0].T
    angle = np.arccos(np.clip((np.trace(turned) - 1) / 2, -1, 1))
    agree("turn of a loaded keystone [rad]", angle, 0.0, within=5e-4 / HEIGHT)
    agree("its way", trial.pos("keystone")[-1] - trial.pos("keystone")[0], 0.0, within=1e-3)
