"""Collisions: restitution, and what they conserve.

Restitution is made from the damping of a spring contact, whose substep h and frequency w have w h = 1/4
(`text2sim.compiler.settings.CONTACT_PHASE`). Where in a step two bodies first touch is a matter of chance: up to a step's
damping, 2 z w h of the speed, and a step's spring energy, (w h)^2 of the whole, are then missing or too many, half of it
on average.
"""

import numpy as np
import pytest

from text2sim.compiler.settings import CONTACT_PHASE, damping_ratio

G = 9.81


def scatter(restitution):
    """Bound of the error of a restitution, of first order in the substep."""
    return restitution * 2 * damping_ratio(restitution) * CONTACT_PHASE + CONTACT_PHASE**2 / 8


@pytest.mark.parametrize("e", [0.3, 0.5, 0.7, 0.9, 0.99])
def test_a_dropped_ball_rises_again_by_the_square_of_restitution(simulate, agree, e):
    """It rises to h' = e^2 h (Newton, Principia, scholium to the laws), for balls that touch at different moments of a step."""
    trial = simulate(
        """
scene: {duration: 0.75, dt: 0.001, substeps: 2, record: {rate: 1000}, statics: {floor: {shape: {kind: plane}}}}
bodies:
  ball:
    kind: rigid
    shape: {kind: sphere, radius: 0.05}
    material: {restitution: "${e}"}
    pose: {pos: [0, 0, 0.55]}
    repeat: {kind: line, count: 12, step: [0.3, 0, 0.0137]}
""",
        e=e,
    )
    found = []
    for k in range(12):
        height = trial.pos(f"ball[{k}]")[:, 2] - 0.05
        up = int(np.argmax(trial.vel(f"ball[{k}]")[:, 2] > 0.0))
        # Before the apex, the height that it will reach follows from energy.
        rise = (height + np.maximum(trial.vel(f"ball[{k}]")[:, 2], 0) ** 2 / (2 * G))[up:]
        free = height[up:] > 0.0
        found.append(np.sqrt(rise[free][0] / height[0]))
    agree(f"drop: restitution {e}, mean of 12", np.mean(found), e, within=scatter(e) / 2 + 0.01)
    agree(f"drop: restitution {e}, each", found, e, within=scatter(e))


def test_what_bounces_and_what_does_not_keep_to_themselves_on_one_floor(simulate, agree):
    """Each bounces with its own e on a floor that says nothing, one that has none with exp(-2), see below.

    Contacts are springs of the angular frequency w: they give way by no more than v / w, whoever else bounces.
    """
    trial = simulate(
        """
scene: {duration: 0.5, dt: 0.001, substeps: 2, record: {rate: 1000}, statics: {floor: {shape: {kind: plane}}}}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.05}, material: {restitution: 0.8}, pose: {pos: [0, 0, 0.55]}}
  half: {kind: rigid, shape: {kind: sphere, radius: 0.05}, material: {restitution: 0.4}, pose: {pos: [1, 0, 0.55]}}
  block: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [2, 0, 0.55]}}
""",
    )
    fall = np.sqrt(2 * G * 0.5)
    for body, e in (("ball", 0.8), ("half", 0.4), ("block", np.exp(-2))):
        agree(f"one floor, {body}: speed after / before", trial.vel(body)[:, 2].max() / fall, e, within=scatter(e))
        deepest = 0.05 - trial.pos(body)[:, 2].min()
        agree(f"one floor, {body}: depth, of v / w", deepest * CONTACT_PHASE / 0.0005 / fall, 0.5, within=0.5)


COLLISION = """
scene: {duration: 0.6, dt: 0.001, substeps: 2, gravity: [0, 0, 0]}
bodies:
  a: {kind: rigid, shape: {kind: sphere, radius: 0.1}, material: {mass: "${m[0]}", restitution: "${e}", friction: 0.01}, pose: {pos: [-0.3, 0, 0]}}
  b: {kind: rigid, shape: {kind: sphere, radius: 0.1}, material: {mass: "${m[1]}", restitution: "${e}", friction: 0.01}, pose: {pos: [0.3, "${offset}", 0]}}
actions:
  controls:
    go_a: {kind: initial_velocity, body: a, linear: [2, 0, 0]}
    go_b: {kind: initial_velocity, body: b, linear: [-1, 0, 0]}
  measures:
    px: {kind: momentum, axis: x}
    py: {kind: momentum, axis: y}
    px_b: {kind: momentum, of: b, axis: x}
    kinetic: {kind: energy, part: kinetic}
"""


@pytest.mark.parametrize(("e", "m"), [(0.99, (1.0, 1.0)), (0.9, (1.0, 3.0)), (0.5, (4.0, 1.0)), (None, (2.0, 1.0))])
def test_a_central_collision_keeps_momentum_and_returns_e_of_the_closing_speed(simulate, agree, e, m):
    """m1 v1 + m2 v2 is constant, v2' - v1' = e (v1 - v2), lost is (1 - e^2) mu (v1 - v2)^2 / 2 (Newton).

    Bodies without restitution do not stick either: a critically damped contact that only pushes returns exp(-2) of the
    speed (Schwager and Pöschel 2007) where the substep resolves it, as here; less at longer substeps.
    """
    trial = simulate(
        COLLISION.replace(', restitution: "${e}"', "") if e is None else COLLISION, e=e or 0, m=m, offset=0.0
    )
    (v1, w1), (v2, w2) = (trial.vel(body)[[0, -1], 0] for body in "ab")
    label, e = e or "left out", e or np.exp(-2)
    error = scatter(e)
    name = f"collision, e {label}, masses {m[0]:g} : {m[1]:g}"
    total = m[0] * 2 - m[1] * 1
    agree(f"{name}: momentum [kg m/s]", trial.measure("px"), total, within=1e-6 * (2 * m[0] + m[1]))
    agree(f"{name}: momentum of b [kg m/s]", trial.measure("px_b"), m[1] * trial.vel("b")[:, 0], within=1e-6 * m[1])
    agree(f"{name}: speed of parting / closing", (w2 - w1) / (v1 - v2), e, within=error)
    reduced = m[0] * m[1] / (m[0] + m[1])
    after = (m[0] * 2**2 + m[1]) / 2 - (1 - e**2) * reduced * 3**2 / 2
    agree(
        f"{name}: kinetic energy after [J]",
        trial.measure("kinetic")[-1],
        after,
        within=(2 * e * error + error**2) * reduced * 3**2 / 2 + 1e-6,
    )


@pytest.mark.parametrize(("dt", "substeps"), [(0.01, 20), (0.001, 1)])
def test_the_recorded_contacts_add_up_to_the_change_of_momentum(simulate, agree, dt, substeps):
    """Forces give m (v - v0) = m g t + sum F dt (Newton II), also of blows that begin and end within one recorded step."""
    trial = simulate(
        """
scene: {duration: 1.5, dt: "${dt}", substeps: "${substeps}", record: {rate: 100}, statics: {floor: {shape: {kind: plane}}}}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.05}, material: {restitution: "${0.9 if dt > 0.005 else 0.5}", mass: 2}, pose: {pos: [0, 0, 0.55]}}
  cup: {kind: rigid, shape: {kind: cup, radius: 0.1, height: 0.1, thickness: 0.01}, material: {mass: 2}, pose: {pos: [1, 0, 0.55], euler_deg: [20, 10, 0]}}
  box: {kind: rigid, shape: {kind: box, size: [0.1, 0.2, 0.1]}, material: {mass: 3}, pose: {pos: [1, 0, 0.8], euler_deg: [20, 10, 0]}}
actions: {controls: {go: {kind: initial_velocity, body: box, linear: [0.3, 0.2, 0], angular: [1, 2, 3]}}}
""",
        dt=dt, substeps=substeps,
    )  # fmt: skip
    bodies = ("ball", "cup", "box")
    for body in bodies:
        given = sum(trial.contact(body, other)[1].sum(axis=0) for other in ("floor", *bodies) if other != body) * dt
        mass, v = trial.link(body).mass, trial.vel(body)
        change = mass * (v[-1] - v[0] - np.array([0, 0, -G]) * trial.time[-1])
        agree(
            f"contacts of the {body}, {substeps} substeps: momentum [N s]",
            given,
            change,
            within=1e-5 * np.linalg.norm(change),
        )


def test_an_oblique_collision_of_equal_elastic_balls_parts_at_right_angles(simulate, agree):
    """In the frame in which one rests: v1'.v2' = 0 for e = 1 (Huygens); (1 - e^2) v_n^2 / 4 otherwise. Both momenta keep."""
    e, offset = 0.99, 0.12
    trial = simulate(COLLISION, e=e, m=(1.0, 1.0), offset=offset)
    agree("oblique collision: momentum along [kg m/s]", trial.measure("px"), 1.0, within=3e-6)
    agree("oblique collision: momentum across [kg m/s]", trial.measure("py"), 0.0, within=3e-6)
    a, b = (trial.vel(name)[-1] - np.array([-1.0, 0, 0]) for name in "ab")
    along = 3 * np.cos(np.arcsin(offset / 0.2))
    agree("oblique collision: v1'.v2' / v^2", a @ b / 9, (1 - e**2) * along**2 / 4 / 9, within=scatter(e) / 2 + 0.01)
    spin = sum(np.cross(trial.pos(n), trial.vel(n)) + trial.spin(n) for n in "ab")
    agree("oblique collision: angular momentum [kg m2/s]", spin[-1], spin[0], within=1e-4 * np.linalg.norm(spin[0]))
