"""Soft bodies of solver mpm that a link carries: the link feels them."""

from tests.physics.conftest import rows

CELL = 0.025
HANGING = """
scene: {duration: 0.4, dt: 0.004, record: {rate: 125}, mpm: {cell: "${cell}"}}
bodies:
  cart: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, material: {mass: 1, touch_soft: false}, pose: {pos: [-0.1, 0, 1]}}
  load: {kind: soft, shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [0, 0, 1]}}
  rotor:
    kind: rigid
    shape: {kind: box, size: [0.2, 0.2, 0.02]}
    material: {mass: 0.5, touch_soft: false}
    mount: {kind: hinge, axis: z, initial_velocity: 4}
    pose: {pos: [0, 0.6, 1]}
  rider: {kind: soft, shape: {kind: box, size: [0.1, 0.1, 0.1]}, material: {damping: 20}, pose: {pos: [0, 0.6, 1.06]}}
  lift:
    kind: rigid
    shape: {kind: box, size: [0.1, 0.1, 0.1]}
    material: {mass: 1, touch_soft: false}
    mount: {kind: slider, axis: z, actuator: {stiffness: 5000, damping: 150}}
    pose: {pos: [0, 1.2, 1]}
  hung: {kind: soft, shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [0, 1.2, 0.9]}}
actions:
  controls:
    tow: {kind: attach, body: load, region: {face: left}, to: cart}
    start: {kind: initial_velocity, body: load, linear: [1, 0, 0]}
    seat: {kind: attach, body: rider, region: {face: bottom}, to: rotor}
    hang: {kind: attach, body: hung, region: {face: top}, to: lift}
    stay: {kind: drive, joint: lift, position: {kind: constant, value: 0}}
"""


def test_a_body_feels_the_soft_one_that_is_attached_to_it(simulate, agree):
    """Momenta are kept, m v and I w: what is owed to a body is paid within a few substeps. A motor bears both weights.

    What turns with w has M dx^2 w / 2 more in the velocity gradients of its particles (Jiang et al., The affine
    particle-in-cell method, 2015, with its D = dx^2 / 4): in cells dx of the grid a small body is that much more inert.
    """
    trial = simulate(HANGING, cell=CELL)
    states, t = trial.states, trial.time
    row = {one.body: number for number, one in enumerate(states.deformables)}
    _, v = rows(states, "load")
    both = v + trial.vel("cart")  # 1 kg each
    agree("momentum along x of a load and its cart [N s]", both[:, 0], 1.0, within=0.06)
    agree("momentum along x at the end [N s]", both[-1, 0], 1.0, within=0.005)
    agree("momentum along z [N s]", both[:, 2], -2 * 9.81 * t, within=0.08)
    rotor, rider, inner = 0.5 * 2 * 0.2**2 / 12, 0.1**2 / 6, CELL**2 / 2
    w, spin = trial.ang("rotor")[:, 2], states.soft_spin[:, row["rider"], 2].astype(float)
    start = 4 * rotor
    agree("angular momentum of both [kg m2/s]", rotor * w + spin * (1 + inner / rider), start, within=0.03 * start)
    turning = start / (rotor + rider + inner)
    agree("they turn as one [rad/s]", w[t > 0.3], turning, within=0.02 * turning)
    sag = 2 * 9.81 / 5000
    agree("sag of the motor [m]", 1 - trial.pos("lift")[-1, 2], sag, within=0.02 * sag)
