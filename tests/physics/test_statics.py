"""What rests: piles, chains, loads on springs. Forces are those of statics to float32; what gives does so by a formula.

A constraint is an impedance d between 0.9 and 0.95 (over the first millimetre), with the time constant 2 h: under a
load that would accelerate it with a, it gives way by (1 - d) / d^2 (dmax timeconst)^2 a (MuJoCo, Computation: Solver
parameters, which the engine follows). A contact with the pyramidal cone has four edges, each with 2 mu^2 (1 + mu^2) of
the softness of the normal: together mu^2 (1 + mu^2) / 2 of it.
"""

import numpy as np
import pytest
from scipy.optimize import fsolve

G = 9.81


def depth_of(step, acceleration, mu=0.5):
    """How far [m] a contact gives way, with the impedance d of that depth x: 0.9 + 0.05 * 2 (x / 1 mm)^2 to half a mm."""
    depth = 0.0
    for _ in range(50):
        d = 0.9 + 0.1 * min(depth / 1e-3, 0.5) ** 2
        depth = mu**2 * (1 + mu**2) / 2 * (1 - d) / d**2 * (0.95 * 2 * step) ** 2 * acceleration
    return depth


@pytest.mark.parametrize(("dt", "substeps"), [(0.01, 1), (0.01, 4)])
def test_a_resting_body_pushes_with_its_weight_and_gives_way_by_the_formula(simulate, agree, dt, substeps):
    """The contact gives N = m g, however many points touch, in contact records and in the measure; also where down is not -z."""
    trial = simulate(
        """
scene:
  duration: 1.5
  dt: "${dt}"
  substeps: "${substeps}"
  gravity: [4, 0, -9]
  statics: {slope: {shape: {kind: plane}, pose: {euler_deg: [0, "${-degrees(atan2(4, 9))}", 0]}}}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, material: {mass: 3}, pose: {pos: [-0.04061385, 0, 0.09138116]}}
  box: {kind: rigid, shape: {kind: box, size: [0.3, 0.2, 0.2]}, material: {mass: 3}, pose: {pos: [-0.04061385, 1, 0.09138116], euler_deg: [0, "${-degrees(atan2(4, 9))}", 0]}}
  cup: {kind: rigid, shape: {kind: cup, radius: 0.1, height: 0.2, thickness: 0.01}, material: {mass: 3}, pose: {pos: [-0.04061385, 2, 0.09138116], euler_deg: [0, "${-degrees(atan2(4, 9))}", 0]}}
actions: {measures: {weight: {kind: contact_force, of: box}, depth: {kind: penetration, of: ball}}}
""",
        dt=dt, substeps=substeps,
    )  # fmt: skip
    gravity = np.array([4, 0, -9.0])
    size = np.linalg.norm(gravity)
    name = f"rest, substep {dt / substeps * 1e3:g} ms"
    for body in ("ball", "box", "cup"):
        step, force, depth = trial.contact(body, "slope")
        last = step == step.max()
        agree(f"{name}: force on the {body} [N]", force[last].sum(axis=0), -3 * gravity, within=2e-3 * 3 * size)
        theory = depth_of(dt / substeps, size) / (4 if body == "box" else 1)  # its four corners share the load
        if body != "cup":
            agree(f"{name}: depth of the {body} [m]", depth[last].max(), theory, within=0.02 * theory + 2e-7)
        agree(f"{name}: speed of the {body} [m/s]", np.linalg.norm(trial.vel(body)[-1]), 0.0, within=1e-3)
    agree(f"{name}: measured contact force [N]", trial.measure("weight")[-1], 3 * size, within=2e-3 * 3 * size)
    agree(
        f"{name}: measured penetration [m]",
        trial.measure("depth")[-1],
        trial.contact("ball", "slope")[2][-1],
        within=1e-7,
    )


def test_a_stack_stands_and_each_box_carries_what_is_above(simulate, agree):
    """The k-th contact from above carries k m g; nothing drifts."""
    trial = simulate("""
scene: {duration: 3.0, dt: 0.01, statics: {floor: {shape: {kind: plane}}}}
bodies:
  box: {kind: rigid, shape: {kind: box, size: [0.2, 0.2, 0.1]}, material: {mass: 2}, place: {on: floor}, repeat: {kind: stack, count: 6}}
""")
    below = ["floor", *(f"box[{k}]" for k in range(5))]
    for k in range(6):
        step, force, depth = trial.contact(f"box[{k}]", below[k])
        last = step > step.max() - 50
        agree(f"stack: force under box {k} [N]", force[last, 2].sum() / 50, (6 - k) * 2 * G, within=1e-3 * 2 * G)
        drift = trial.pos(f"box[{k}]")[-1] - trial.pos(f"box[{k}]")[len(trial.time) // 3]
        agree(f"stack: drift of box {k} in 2 s [m]", drift, 0.0, within=2e-5)
        agree(f"stack: speed of box {k} [m/s]", trial.vel(f"box[{k}]")[-1], 0.0, within=1e-4)
        # Where two boxes give way, the load moves their common mass; four corners share it.
        theory = depth_of(0.005, (6 - k) * G) / 4 * (2 if k else 1)
        agree(f"stack: depth under box {k} [m]", depth[last].max(), theory, within=theory)


def test_a_spring_scale_shows_the_weight_of_a_chain_and_its_load(simulate, agree):
    """At rest k x = (sum of all masses) g: the tension at the top of a hanging chain is its weight."""
    trial = simulate("""
scene: {duration: 4.0, dt: 0.005, substeps: 2}
bodies:
  scale: {kind: rigid, shape: {kind: box, size: [0.2, 0.2, 0.05]}, material: {mass: 1}, pose: {pos: [0, 0, 2]}, mount: {kind: slider, axis: z, spring: 800, damping: 200}}
  chain:
    kind: chain
    links: 6
    link_length: 0.15
    radius: 0.02
    anchored: false
    pose: {pos: [0, 0, 1.9]}
    payload: {shape: {kind: sphere, radius: 0.1}, material: {mass: 5}}
actions: {controls: {hook: {kind: attach, body: chain.link_0, to: scale, at: 0}}}
""")
    total = sum(link.mass for link in trial.states.links if link.body in ("scale", "chain"))
    bars = 6 * 7800 * (np.pi * 0.02**2 * 0.11 + 4 / 3 * np.pi * 0.02**3)
    agree("chain: mass of bars and load [kg]", total, 1 + 5 + bars, within=1e-5)
    agree("spring scale: stretch [m]", -trial.joint("scale")[0][-1], total * G / 800, within=1e-5)
    ends = trial.pos("chain.payload")[-1] - trial.pos("chain.link_0")[-1]
    agree("hanging chain: length [m]", -ends[2], 6 * 0.15 + 0.1, within=1e-5)


def test_a_chain_between_two_points_hangs_in_the_discrete_catenary(simulate, agree):
    """Slopes: tan a_i = (V - (i + 1/2) w) / H for n equal rigid links: the slopes are evenly spaced (Hooke 1675; Routh, Statics I, 443).

    The chain starts stretched; a driven carriage brings its last link, which is attached to it, 0.6 m nearer. The joints
    are damped, and what is left of the swinging dies away by nearly a half every second.
    """
    links, length = 16, 0.1
    trial = simulate(
        """
scene: {duration: 10.0, dt: 0.01, substeps: 4}
bodies:
  chain: {kind: chain, links: "${bars + 1}", link_length: "${l}", radius: 0.01, direction: x, joint: {damping: 0.1, armature: 0.0001}}
  carriage:
    kind: driven
    shape: {kind: box, size: [0.05, 0.05, 0.05]}
    pose: {pos: ["${bars * l + 0.2}", 0, 0]}
    motion: {kind: waypoints, times: [0, 2], positions: [[0, 0, 0], [-0.6, 0, 0]]}
actions: {controls: {grip: {kind: attach, body: "chain.link_${bars}", to: carriage, at: 0}}}
""",
        bars=links, l=length,
    )  # fmt: skip
    path = np.array([trial.pos(f"chain.link_{k}")[-1] for k in range(links + 1)])
    span, rise = path[-1, 0] - path[0, 0], path[-1, 2] - path[0, 2]
    agree("catenary: span [m]", span, links * length - 0.6, within=2e-3)

    def shape(forces):
        angle = np.arctan2(forces[1] - np.arange(links) - 0.5, forces[0])
        return np.stack([np.cumsum(length * np.cos(angle)), -np.cumsum(length * np.sin(angle))], axis=1)

    forces = fsolve(lambda f: shape(f)[-1] - (span, rise), (2.0, links / 2))
    agree("catenary: joints [m]", path[1:, [0, 2]], shape(forces), within=5e-4)
    agree("catenary: at rest [m/s]", trial.vel("chain.link_8")[-1], 0.0, within=2e-3)
