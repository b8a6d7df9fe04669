"""Streams and viscosity against the equations of free flight and of momentum that diffuses from a floor."""

import numpy as np

from tests.physics.conftest import rows
from text2sim.templates.streams import Stream

JET = """
scene: {duration: 0.3, dt: 0.004, record: {rate: 250}}
bodies:
  jet:
    kind: liquid
    cell: 0.01
    shape: {kind: stream, radius: 0.02, speed: 1, start: 0.05, duration: 0.2, direction: [1, 0, 0]}
    material: {stiffness: 5e4}
    pose: {pos: [0, 0, 0.6]}
  at_once:
    kind: liquid
    shape: {kind: stream, radius: 0.02, speed: 1, duration: 0.1, direction: [1, 0, 0]}
    material: {stiffness: 5e4}
    pose: {pos: [0, 0.3, 0.6]}
"""


def test_a_stream_leaves_its_mouth_at_its_speed_and_falls_freely(simulate, agree):
    """After a time T a particle is at `speed T`, and falls freely from a cell beyond the mouth on.

    Until there the grid feels the pipe. What has not come out waits in the mouth.

    Velocities are averaged over a cell, along which T changes by 0.01 s: by 0.02 m of height at the end.
    """
    trial = simulate(JET)
    _check_jet(trial, agree, "jet", Stream((0, 0, 0.6), (1, 0, 0), 0.02, 1.0, 0.05, 0.2, 0.0064))
    # The first particle of this one comes out in the first substep.
    _check_jet(trial, agree, "at_once", Stream((0, 0.3, 0.6), (1, 0, 0), 0.02, 1.0, 0.0, 0.1, 0.0064))


def _check_jet(trial, agree, body, stream):
    early = trial.time <= stream.times[0] + 0.25
    points = rows(trial.states, body)[0][early]
    assert len(stream) == points.shape[1]
    flown = np.maximum(trial.time[early, None] - stream.times, 0.0)
    waits = flown == 0
    agree(
        "what waits does not move [m]", points[waits], np.broadcast_to(stream.mouth, points.shape)[waits], within=1e-6
    )
    agree("distance [m]", points[..., 0], stream.mouth[:, 0] + flown, within=0.01)
    fallen = 9.81 * np.maximum(flown - 0.01, 0.0) ** 2 / 2
    agree("height [m]", points[..., 2], stream.mouth[:, 2] - fallen, within=0.015)


SLABS = """
scene:
  duration: 0.04
  dt: 0.004
  record: {rate: 250}
  mpm: {bounds: {min: [-0.2, -0.15, -0.05], max: [0.2, 0.4, 0.1]}}
  statics: {floor: {shape: {kind: plane}, material: {friction: 5}}}
bodies:
  thin: {kind: liquid, cell: 0.01, shape: {kind: box, size: [0.2, 0.1, 0.05]}, material: {viscosity: 20, stiffness: 1e5}, pose: {pos: [0, 0, 0.025]}}
  thick: {kind: liquid, cell: 0.01, shape: {kind: box, size: [0.2, 0.1, 0.05]}, material: {viscosity: 40, stiffness: 1e5}, pose: {pos: [0, 0.25, 0.025]}}
actions:
  controls:
    thin: {kind: initial_velocity, body: thin, linear: [0.3, 0, 0]}
    thick: {kind: initial_velocity, body: thick, linear: [0.3, 0, 0]}
"""


def test_a_viscous_slab_is_stopped_by_the_floor_as_momentum_diffuses(simulate, agree):
    """A slab of height H and speed U sticks to the floor.

    Its mean displacement after t is `sum 2 U / (k H)^2 (1 - exp(-nu k^2 t)) / (nu k^2)` over `k = (n + 1/2) pi / H`,
    with `nu = viscosity / density`.

    Where the floor is felt is uncertain by half a cell, a tenth of H.
    """
    trial = simulate(SLABS)
    k, t = (np.arange(60)[:, None] + 0.5) * np.pi / 0.05, trial.time
    for body, viscosity in (("thin", 20), ("thick", 40)):
        nu = viscosity / 1000
        moved = (2 * 0.3 / (k * 0.05) ** 2 * (1 - np.exp(-nu * k**2 * t)) / (nu * k**2)).sum(axis=0)
        points, _ = rows(trial.states, body)
        own = points[..., 0].mean(axis=1)
        agree(f"displacement with {viscosity} Pa s [m]", own - own[0], moved, within=0.15 * moved[-1])
