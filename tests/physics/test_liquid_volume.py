"""Liquids keep their volume, lone drops stay slow, and what floats displaces its weight."""

import numpy as np
import pytest

from tests.physics.conftest import rows

pytestmark = pytest.mark.engine


def _tank(inner: float, height: float, z: float = 0.0) -> str:
    """Statics: four walls around a square of the given width, then the base, with its top at z."""
    wall = 0.03
    outer, at = inner + 2 * wall, (inner + wall) / 2
    boxes = {
        "left": ([wall, outer, height], [-at, 0, z + height / 2]),
        "right": ([wall, outer, height], [at, 0, z + height / 2]),
        "back": ([inner, wall, height], [0, at, z + height / 2]),
        "front": ([inner, wall, height], [0, -at, z + height / 2]),
        "base": ([outer, outer, 0.06], [0, 0, z - 0.03]),
    }
    return "".join(
        f"    {name}: {{shape: {{kind: box, size: {size}}}, pose: {{pos: {pos}}}}}\n"
        for name, (size, pos) in boxes.items()
    )


SPLASH = f"""
scene:
  duration: 1.4
  statics:
{_tank(0.206, 0.24)}
bodies:
  water: {{kind: liquid, cell: 0.0125, shape: {{kind: box, size: [0.1, 0.1, 0.15]}}, pose: {{pos: [0, 0, 0.4]}}}}
"""


def test_what_splashed_has_its_volume_again_and_no_drop_runs_away(simulate):
    """Nothing is faster than what falls by 0.475 m, from the top of the water to the base, and all ends up in the tank.

    Its centre is at half its depth, and at most 0.4 cells above, for particles keep a third of a cell away from the
    base. Where lone particles keep their velocity gradient, drops fly off at 9 m/s, or end in nan.
    """
    trial = simulate(SPLASH)
    points, _ = rows(trial.states, "water")
    assert np.isfinite(points).all()
    speed = np.linalg.norm(np.diff(points, axis=0), axis=2).max() / np.diff(trial.time).min()
    assert speed < 1.25 * np.sqrt(2 * 9.81 * 0.475)
    assert abs(points[-1, :, :2]).max() < 0.206 / 2
    depth = 0.0015 / 0.206**2
    assert depth / 2 < points[-1, :, 2].mean() < depth / 2 + 0.4 * 0.0125


SLOT = f"""
scene:
  duration: 2
  statics:
{_tank(0.09, 0.16, 0.006)}
bodies:
  water: {{kind: liquid, cell: 0.02, shape: {{kind: box, size: [0.0898, 0.0898, 0.1]}}, pose: {{pos: [0, 0, 0.0561]}}}}
"""


def test_a_liquid_keeps_its_volume_between_walls_on_all_sides(simulate):
    """The centre of mass of a liquid at rest stays where it is, but for a quarter of a cell.

    The base lies between two nodes. A particle near it is within three cells of all five walls, of which it comes last;
    where it is not seen, or volumes are integrated from velocities alone, the centre falls by 6 and 9 mm.
    """
    trial = simulate(SLOT)
    height = rows(trial.states, "water")[0][:, :, 2].mean(axis=1)
    assert abs(height[-1] - height[0]) < 0.02 / 4, f"{1000 * (height[-1] - height[0]):.1f} mm"


BALL = f"""
scene:
  duration: 1.5
  statics:
{_tank(0.3, 0.2)}
bodies:
  ball: {{kind: rigid, shape: {{kind: sphere, radius: 0.06}}, material: {{density: 500}}, pose: {{pos: [0, 0, 0.181]}}}}
  water: {{kind: liquid, cell: 0.02, shape: {{kind: box, size: [0.2998, 0.2998, 0.12]}}, pose: {{pos: [0, 0, 0.0601]}}}}
"""


def test_a_ball_of_half_the_density_of_water_floats_with_its_centre_at_the_surface(simulate):
    """By Archimedes' principle it displaces half its volume.

    The surface is half the distance of particles above the highest ones. Particles keep a quarter of a cell away from the
    ball, which lifts it by as much at most. Where the nodes around it were stopped, it would float 14 mm too high.
    """
    trial = simulate(BALL)
    points = rows(trial.states, "water")[0][-1]
    away = points[np.hypot(points[:, 0], points[:, 1]) > 0.09]
    surface = np.percentile(away[:, 2], 98) + 0.64 * 0.02 / 2
    assert abs(trial.pos("ball")[-1, 2] - surface) < 0.02 / 4
