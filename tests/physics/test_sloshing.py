"""Waves in a tank whose walls have no friction with liquids live on; friction takes the same height of each swing."""

import numpy as np
import pytest

from tests.physics.conftest import rows

pytestmark = pytest.mark.engine

CELL, LONG, WIDE, DEPTH, STEP = 0.02, 0.32, 0.12, 0.12, 0.06
"""Cell, length and width of the tank, mean depth of the water, and the step of its surface at the start [m]."""
WALL = 0.03
GRAVITY = 9.81


def _walls() -> str:
    sides = {
        "bottom": ([LONG + 2 * WALL, WIDE + 2 * WALL, WALL], [0, 0, -WALL / 2]),
        "left": ([WALL, WIDE + 2 * WALL, 0.25], [-(LONG + WALL) / 2, 0, 0.125]),
        "right": ([WALL, WIDE + 2 * WALL, 0.25], [(LONG + WALL) / 2, 0, 0.125]),
        "front": ([LONG, WALL, 0.25], [0, -(WIDE + WALL) / 2, 0.125]),
        "back": ([LONG, WALL, 0.25], [0, (WIDE + WALL) / 2, 0.125]),
    }
    return ", ".join(
        f"{name}: {{shape: {{kind: box, size: {size}}}, pose: {{pos: {pos}}}}}" for name, (size, pos) in sides.items()
    )


def _water(name: str, side: int) -> str:
    high = DEPTH - side * STEP / 2
    return (
        f"  {name}: {{kind: liquid, cell: {CELL}, shape: {{kind: box, size: [{LONG / 2 - 1e-3}, {WIDE - 2e-4}, {high}]}},"
        f" pose: {{pos: [{side * LONG / 4}, 0, {0.1 + high / 2}]}}}}"
    )


CASE = f"""
scene:
  duration: 1.5
  statics:
    tank: {{shape: {{kind: compound, parts: {{{_walls()}}}}}, material: {{friction: "${{mu}}"}}, pose: {{pos: [0, 0, 0.1]}}}}
bodies:
{_water("left", -1)}
{_water("right", 1)}
"""


def _swings(trial) -> tuple[np.ndarray, np.ndarray]:
    """Return the times [s] and places [m] at which the centre of mass turns."""
    points = np.concatenate([rows(trial.states, name)[0] for name in ("left", "right")], axis=1)
    t, x = np.asarray(trial.states.time), points[:, :, 0].mean(axis=1)
    turns = [k for k in range(1, len(x) - 1) if (x[k] - x[k - 1]) * (x[k + 1] - x[k]) <= 0 and t[k] > 0.2]
    return t[turns], x[turns]


def test_a_wave_has_its_period_and_friction_takes_it_away(simulate):
    """The first standing wave in a tank has the period T = 2 pi / sqrt(g k tanh(k h)) with k = pi / L.

    So says Lamb, Hydrodynamics, section 228, of low waves; this one is a quarter of the depth high, for which it gets a
    twentieth. The centre of mass swings with it.

    Without friction 25 % of the swing are lost in a period at most: by the grid, 16 cells across. Dry friction mu acts
    on all the weight, as on a mass on a spring, whose amplitude falls by 4 mu g / omega^2 in a period: with 0.03 by
    16 mm, all that there is.
    """
    t, x = _swings(simulate(CASE, mu=0.01))
    k = np.pi / LONG
    omega = np.sqrt(GRAVITY * k * np.tanh(k * DEPTH))
    assert t[2] - t[0] == pytest.approx(2 * np.pi / omega, rel=0.05)
    first, second = abs(np.diff(x))[:2]
    assert first > 0.02
    assert second > 0.75**0.5 * first
    _, rubbed = _swings(simulate(CASE, mu=0.03))
    lost = abs(np.diff(rubbed))[:2]
    assert lost[1] < lost[0] - 0.5 * 4 * 0.03 * GRAVITY / omega**2
