"""Soft bodies that stick to a wall, against the traction that they can bear."""

import numpy as np
import pytest

from tests.physics.conftest import rows

THICK, WIDE, TALL, CELL = 0.02, 0.1, 0.2, 0.01
DENSITY, GRAVITY = 1000.0, 9.81
FIRM, WEAK = 400.0, 100.0
SHIFTS = {"a": 0.0, "b": 0.004, "c": -0.004}
"""Where the wall is within a cell of the grid [m]."""
SCENE = """
scene:
  duration: 0.12
  dt: 0.004
  record: {rate: 250}
  statics:
"""
WALL = """
    wall_{name}: {{shape: {{kind: box, size: [0.1, 1, 0.6]}}, material: {{friction: 0.01}}, pose: {{pos: [{wall}, {y}, 0.6]}}}}
"""
SLAB = """
  {kind}_{name}:
    kind: soft
    solver: mpm
    cell: 0.01
    shape: {{kind: box, size: [0.02, 0.1, 0.2]}}
    material: {{youngs_modulus: 1e5, density: 1000, adhesion: {stress}}}
    pose: {{pos: [{x}, {beside}, 0.6]}}
"""


@pytest.fixture(scope="module")
def trial(simulate):
    """Two slabs on each of three walls: their weight per area of the wall is 196 Pa."""
    walls, slabs = [], []
    for k, (name, shift) in enumerate(SHIFTS.items()):
        walls.append(WALL.format(name=name, wall=shift - 0.05, y=1.1 * k))
        for kind, stress, beside in (("firm", FIRM, 0.2), ("weak", WEAK, -0.2)):
            place = {"x": shift + THICK / 2 + 0.001, "beside": 1.1 * k + beside}
            slabs.append(SLAB.format(kind=kind, name=name, stress=stress, **place))
    return simulate(SCENE + "".join(walls) + "bodies:\n" + "".join(slabs))


def fallen(trial, name):
    """How far the middle of a slab has come down [m], shape (F,)."""
    points, _ = rows(trial.states, name)
    return points[0, :, 2].mean() - points[..., 2].mean(axis=1)


@pytest.mark.parametrize("wall", SHIFTS)
def test_a_slab_whose_weight_its_adhesion_bears_stays_on_the_wall(trial, agree, wall):
    """It only sags by its shear: rho g thick^2 / (3 G) = 0.03 mm; a cell of the grid adds about as much."""
    agree("sunk [m]", fallen(trial, f"firm_{wall}")[-1], 0.0, within=2e-4)


@pytest.mark.parametrize("wall", SHIFTS)
def test_a_heavier_one_slides_against_the_traction(trial, agree, wall):
    """Its acceleration is g - traction area / mass. Half a cell around its contact sticks, too."""
    area = (WIDE + CELL) * (TALL + CELL)
    rate = GRAVITY - WEAK * area / (DENSITY * THICK * WIDE * TALL)
    way = np.interp(0.1, trial.time, fallen(trial, f"weak_{wall}"))
    agree("slid in 0.1 s [m]", way, rate * 0.1**2 / 2, within=0.15 * rate * 0.1**2 / 2)


PAIR = """
scene: {duration: 0.2, dt: 0.004, gravity: [0, 0, 0], record: {rate: 100}}
bodies:
  box:
    kind: rigid
    shape: {kind: box, size: [0.1, 0.12, 0.24]}
    material: {density: 500, friction: 0.01}
    pose: {pos: [0, 0, 0.5]}
"""
ON_PAIR = """
  slab_{name}:
    kind: soft
    solver: mpm
    cell: 0.01
    shape: {{kind: box, size: [0.02, 0.1, 0.2]}}
    material: {{youngs_modulus: 1e5, density: 1000, adhesion: 4000}}
    pose: {{pos: [{x}, 0, 0.5]}}
"""
PUSH = "actions: {controls: {go: {kind: initial_velocity, body: box, linear: [0, 0, 0.5]}}}\n"


def test_a_free_body_gives_the_slabs_on_it_their_momentum(simulate, agree):
    """A box of 1.44 kg at 0.5 m/s takes two slabs of 0.4 kg along; it has no friction to do so."""
    trial = simulate(PAIR + "".join(ON_PAIR.format(name=n, x=x) for n, x in (("a", 0.061), ("b", -0.061))) + PUSH)
    shared = 0.5 * 1.44 / (1.44 + 2 * 0.4)
    after = trial.time > 0.1
    agree("box [m/s]", np.polyfit(trial.time[after], trial.pos("box")[after, 2], 1)[0], shared, within=0.05 * shared)
    for name in ("slab_a", "slab_b"):
        speed = -np.polyfit(trial.time[after], fallen(trial, name)[after], 1)[0]
        agree(f"{name} [m/s]", speed, shared, within=0.05 * shared)
