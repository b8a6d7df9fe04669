"""What flows stays on its side of thin walls, also of one that pushes it."""

import pytest

from tests.physics.conftest import rows

PISTON = """
scene:
  duration: 0.7
  dt: 0.005
  record: {rate: 20}
  mpm: {cell: 0.02}
  statics:
    floor: {shape: {kind: box, size: [0.5, 0.3, 0.04]}, pose: {pos: [0.2, 0, -0.02]}}
    front: {shape: {kind: box, size: [0.006, 0.2, 0.3]}, pose: {pos: [0.403, 0, 0.15]}}
    near: {shape: {kind: box, size: [0.5, 0.006, 0.3]}, pose: {pos: [0.2, -0.063, 0.15]}}
    far: {shape: {kind: box, size: [0.5, 0.006, 0.3]}, pose: {pos: [0.2, 0.063, 0.15]}}
bodies:
  stuff:
    kind: KIND
    shape: {kind: box, size: [0.24, 0.11, 0.12]}
    pose: {pos: [0.27, 0, 0.065]}
  plate:
    kind: driven
    shape: {kind: box, size: [0.01, 0.116, 0.3]}
    pose: {pos: [0.14, 0, 0.16]}
    motion: {kind: waypoints, times: [0.05, 0.5], positions: [[0, 0, 0], [0.1, 0, 0]]}
"""


@pytest.mark.parametrize("kind", ["liquid", "granular"])
def test_nothing_passes_walls_of_a_third_of_a_cell_or_a_plate_of_half_a_cell(simulate, kind):
    """Not one particle is beyond a wall, in the floor or behind the plate.

    The mean height above the floor of what fills a space of length l evenly is V / (2 l w). Particles keep 0.32 cells,
    6.4 mm, away from all sides, which raises it by at most 22 %.
    """
    trial = simulate(PISTON.replace("KIND", kind))
    points, _ = rows(trial.states, "stuff")
    x, y, z = (points[..., k] for k in range(3))
    assert x.max() < 0.4
    assert abs(y).max() < 0.06
    assert z.min() > 0
    assert (x[-1] > 0.24).all()
    if kind == "liquid":
        space = (0.4 - 0.14 - 0.1 - 0.005) * 0.12
        even = 0.24 * 0.11 * 0.12 / space / 2
        assert even < z[-1].mean() < 1.22 * even


TOWERS = """
scene: {duration: 0.08, dt: 0.01, mpm: {cell: 0.02}, statics: {floor: {shape: {kind: plane}}}}
bodies:
  dry: {kind: granular, shape: {kind: cylinder, radius: 0.05, height: 0.13}, place: {on: floor}}
  damp: {kind: granular, shape: {kind: cylinder, radius: 0.05, height: 0.13}, material: {cohesion: 1800}, place: {on: floor, at: [0.3, 0]}}
  water: {kind: liquid, shape: {kind: box, size: [0.1, 0.1, 0.13]}, place: {on: floor, at: [0.6, 0]}}
"""


def test_what_starts_on_a_floor_does_not_burst(simulate):
    """Its lowest 6.4 mm are moved up, by 3.2 mm on average: its centre rises by 0.16 mm, and not by its own pressure."""
    trial = simulate(TOWERS)
    for name in ("dry", "damp", "water"):
        points, _ = rows(trial.states, name)
        assert points[..., 2].mean(axis=1).max() < points[0, :, 2].mean() + 1e-3
    points, _ = rows(trial.states, "damp")
    wide = abs(points[..., 1]).max(axis=1)
    assert wide.max() < wide[0] + 0.002, "2 C tan(45 deg + phi / 2) is three times the pressure at its foot"
