"""Bodies that nothing touches.

The engine integrates with semi-implicit Euler steps of h = dt / substeps: v += h a, then x += h v. Under a constant
acceleration it therefore ends after N steps exactly at v = v0 + a h N and x = x0 + v0 h N + a h^2 N (N + 1) / 2, which
is a t h / 2 (first order) beyond the parabola. What is left is float32: half a unit in the last place for each addition.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from text2sim.evidence.diagnostics import energy_account, energy_from_nowhere

EPS = 2.0**-24
"""Relative rounding of one float32 operation."""

HAMMER = """
    kind: rigid
    shape:
      kind: compound
      parts:
        head: {shape: {kind: box, size: [0.12, 0.05, 0.05]}, pose: {pos: [0.02, 0.01, 0.3], euler_deg: [10, 20, 30]}, density: 7800}
        handle: {shape: {kind: cylinder, radius: 0.03, height: 0.55}}
    pose: {pos: [1, -2, 3], euler_deg: [30, 50, 70]}
"""


@pytest.mark.parametrize("substeps", [1, 4])
def test_free_fall_is_the_exact_solution_of_the_integrator_whatever_the_mass(simulate, agree, substeps):
    """Heights are z = z0 - g h^2 N (N + 1) / 2 and v = -g h N (Galileo; Hairer, Lubich, Wanner: Geometric Numerical Integration, I.1)."""
    trial = simulate(
        """
scene: {duration: 1.0, dt: 0.01, substeps: "${substeps}"}
bodies:
  light: {kind: rigid, shape: {kind: sphere, radius: 0.1}, material: {density: 10}, pose: {pos: [0, 0, 10]}}
  heavy: {kind: rigid, shape: {kind: box, size: [0.1, 0.2, 0.3]}, material: {density: 9000}, pose: {pos: [2, 0, 10]}}
actions: {measures: {height: {kind: position, of: light, axis: z}, speed: {kind: speed, of: light}}}
""",
        substeps=substeps,
    )
    h, n = 0.01 / substeps, substeps * np.arange(101)
    rounding = n[-1] * EPS * 10.0
    for body in ("light", "heavy"):
        agree(
            f"free fall, {substeps} substeps, {body}: z [m]",
            trial.pos(body)[:, 2],
            10 - 9.81 * h * h * n * (n + 1) / 2,
            within=rounding,
        )
    agree(
        f"free fall, {substeps} substeps: measured height [m]",
        trial.measure("height"),
        trial.pos("light")[:, 2],
        within=0,
    )
    agree(
        f"free fall, {substeps} substeps: measured speed [m/s]", trial.measure("speed"), 9.81 * h * n, within=rounding
    )


def test_a_projectile_flies_a_parabola_in_any_gravity(simulate, agree):
    """The path is x = x0 + v0 h N + g h^2 N (N + 1) / 2 for gravity that does not point down, of the centre of mass of a spinning body."""
    trial = simulate(f"""
scene: {{duration: 1.0, dt: 0.005, substeps: 1, gravity: [1.5, -2.0, 3.0]}}
bodies:
  hammer: {HAMMER}
actions:
  controls:
    throw: {{kind: initial_velocity, body: hammer, linear: [4, 5, -6], angular: [2, -1, 4]}}
""")
    h, n = 0.005, 2 * np.arange(len(trial.time))[:, None]
    start, go, gravity = trial.com("hammer")[0], np.array([4, 5, -6]), np.array([1.5, -2.0, 3.0])
    assert trial.states.gravity == pytest.approx(gravity)
    path = start + go * h * n + gravity * h * h * n * (n + 1) / 2
    agree("projectile: centre of mass [m]", trial.com("hammer"), path, within=n[-1, 0] * EPS * 5)
    agree("projectile: velocity [m/s]", trial.vel("hammer"), go + gravity * h * n, within=n[-1, 0] * EPS * 8)


def test_start_velocities_are_those_of_the_world_and_the_centre_of_mass(simulate, agree):
    """They have v and w as given, on bodies turned by (30, 50, 70) deg whose centre and principal axes are not those of their frame.

    Without forces the centre of mass then goes on at v (Newton I), and R I R' w stays what it is.
    """
    bodies = {
        "hammer": HAMMER,
        "brick": "{kind: rigid, shape: {kind: box, size: [0.1, 0.2, 0.4]}, pose: {pos: [3, 0, 0], euler_deg: [30, 50, 70]}}",
        "cup": "{kind: rigid, shape: {kind: cup, radius: 0.1, height: 0.2, thickness: 0.01}, pose: {pos: [5, 0, 0], euler_deg: [30, 50, 70]}}",
        "doll": "{kind: ragdoll, height: 0.5, pose: {pos: [7, 0, 0], euler_deg: [30, 50, 70]}}",
    }
    linear, angular, dt = np.array([1.0, 2.0, 3.0]), np.array([0.2, -0.1, 0.4]), 0.01
    trial = simulate(
        f"scene: {{duration: 0.5, dt: {dt}, substeps: 1, gravity: [0, 0, 0]}}\nbodies:\n"
        + "".join(f"  {name}: {text}\n" for name, text in bodies.items())
        + "actions: {controls: {"
        + ", ".join(
            f"go_{name}: {{kind: initial_velocity, body: {name}, linear: [1, 2, 3], angular: [0.2, -0.1, 0.4]}}"
            for name in bodies
        )
        + "}}\n"
    )
    for name in bodies:
        agree(f"start of a {name}: angular velocity [rad/s]", trial.ang(name)[0], angular, within=1e-6)
        if name == "doll":
            continue
        agree(f"start of a {name}: velocity of the centre [m/s]", trial.vel(name)[0], linear, within=1e-6)
        steps = len(trial.time) - 1
        agree(f"coasting {name}: momentum / mass [m/s]", trial.vel(name), linear, within=steps * EPS * 4)
        spin = trial.spin(name)
        size = np.linalg.norm(spin[0])
        turn = np.linalg.norm(angular) * dt
        agree(
            f"coasting {name}: angular momentum / its start",
            np.linalg.norm(spin - spin[0], axis=1) / size,
            0.0,
            within=turn**2,
        )


@pytest.mark.parametrize("substeps", [1, 4])
def test_damping_takes_velocity_and_spin_at_its_rate_from_any_free_body(simulate, agree, substeps):
    """It has v' = -c v and L' = -c L, so x - x0 = v0 / c (1 - exp(-c t)), and w' = -c w for a sphere; falling, v = g / c (1 - exp(-c t)).

    The engine integrates damping implicitly: v = v0 (1 + c h)^-n. The exponential differs from that by at most
    c h / (2 e) of v0, since (1 + c h)^-n = exp(-c t + c^2 h t / 2 - ...).
    """
    bodies = {
        "ball": "{kind: rigid, shape: {kind: sphere, radius: 0.1}, mount: {kind: free, damping: 2}}",
        "cup": "{kind: rigid, shape: {kind: cup, radius: 0.1, height: 0.2, thickness: 0.01}, pose: {pos: [5, 0, 0], euler_deg: [30, 50, 70]}, mount: {kind: free, damping: 2}}",
        "hammer": HAMMER + "    mount: {kind: free, damping: 2}\n",
        "drop": "{kind: rigid, shape: {kind: box, size: [0.1, 0.2, 0.3]}, pose: {pos: [9, 0, 0]}, mount: {kind: free, damping: 2}}",
    }
    go, turn, rate, h = np.array([1.0, 2.0, 3.0]), np.array([0.2, -0.1, 0.4]), 2.0, 0.01 / substeps
    trial = simulate(
        f"scene: {{duration: 1, dt: 0.01, substeps: {substeps}, gravity: [0, 0, -1]}}\nbodies:\n"
        + "".join(f"  {name}: {text}\n" for name, text in bodies.items())
        + "actions: {controls: {"
        + ", ".join(f"go_{n}: {{kind: initial_velocity, body: {n}, linear: [1, 2, 3], angular: [0.2, -0.1, 0.4]}}" for n in bodies if n != "drop")
        + "}}\n"
    )  # fmt: skip
    t, least = trial.time[:, None], rate * h / (2 * np.e)
    left, g, rounding = np.exp(-rate * t), np.array([0, 0, -1.0]), substeps * 100 * EPS * 8
    exact = (1 + rate * h) ** (-substeps * np.arange(0, len(t)) * round(t[1, 0] / 0.01))[:, None]
    agree(f"damped fall, {substeps} substeps: v [m/s]", trial.vel("drop"), g / rate * (1 - exact), within=rounding)
    for name in ("ball", "cup", "hammer"):
        what = f"damped {name}, {substeps} substeps"
        fall = g / rate * (1 - exact)
        agree(f"{what}: v, by the integrator [m/s]", trial.vel(name) - fall, go * exact, within=rounding)
        agree(f"{what}: v [m/s]", trial.vel(name) - fall, go * left, within=3.0 * least)
        way, drop = go / rate * (1 - left), g / rate * (t - (1 - left) / rate)
        # The falling part differs by g h / c, and its own share of the same error.
        agree(
            f"{what}: way [m]", trial.com(name) - trial.com(name)[0], way + drop, within=4.0 / rate * least + h / rate
        )
        spin = trial.spin(name)
        size = np.linalg.norm(spin[0])
        agree(f"{what}: L / its start", spin / size, spin[0] / size * left, within=least + (0.5 * 0.01) ** 2 + rounding)
    agree(f"damped ball, {substeps} substeps: w [rad/s]", trial.ang("ball"), turn * exact, within=rounding)
    assert trial.recording.states.frames == len(t)
    assert energy_from_nowhere(trial.recording) == []
    assert energy_account(trial.recording)["change"] < 0.0


def test_a_symmetric_top_precesses_about_its_angular_momentum(simulate, agree):
    """The axis turns about L at L / I1 (Landau and Lifshitz, Mechanics, section 33). Second order: halving h quarters the error."""
    speed, t = 6.0, 2.0
    errors = []
    for dt in (0.01, 0.005):
        trial = simulate(
            """
scene: {duration: "${t}", dt: "${dt}", substeps: 1, gravity: [0, 0, 0]}
bodies:
  top: {kind: rigid, shape: {kind: cylinder, radius: 0.15, height: 0.1}, pose: {euler_deg: [0, 40, 0]}}
actions: {controls: {go: {kind: initial_velocity, body: top, angular: [0, 0, "${speed}"]}}}
""",
            dt=dt, t=t, speed=speed,
        )  # fmt: skip
        axis, momentum = trial.turn("top")[:, :, 2], trial.spin("top")[0]
        across = trial.link("top").inertia[0][0]
        turned = Rotation.from_rotvec(np.outer(trial.time, momentum / across)).apply(axis[0])
        errors.append(np.linalg.norm(axis - turned, axis=1).max())
        agree(
            f"free top, dt {dt}: direction of its axis [rad]", errors[-1], 0.0, within=(speed * dt) ** 2 / 6 * speed * t
        )
        agree(
            f"free top, dt {dt}: energy / its start",
            trial.recording.kinetic(np.array([0]))[:, 0] / trial.recording.kinetic(np.array([0]))[0, 0],
            1.0,
            within=(speed * dt) ** 2 / 6,
        )
    agree("free top: order of convergence", np.log2(errors[0] / errors[1]), 2.0, within=0.2)


def test_a_brick_flips_about_its_middle_axis_as_eulers_equations_say(simulate, agree):
    """Euler: I1 w1' = (I2 - I3) w2 w3 and so on (Landau and Lifshitz, section 36), integrated to 1e-10, in the brick's frame.

    The start is nearly along the middle axis, which is unstable (Dzhanibekov). L keeps size and direction.
    """
    speed, t = 5.0, 5.0
    crossings = []
    for dt in (0.01, 0.005):
        trial = simulate(
            """
scene: {duration: "${t}", dt: "${dt}", substeps: 1, gravity: [0, 0, 0]}
bodies:
  brick: {kind: rigid, shape: {kind: box, size: [0.1, 0.2, 0.4]}}
actions: {controls: {go: {kind: initial_velocity, body: brick, angular: [0.05, "${speed}", 0.05]}}}
""",
            dt=dt, t=t, speed=speed,
        )  # fmt: skip
        inertia = np.diag(np.array(trial.link("brick").inertia))
        euler = solve_ivp(
            lambda _, w: np.cross(inertia * w, w) / inertia,  # noqa: B023
            (0, t), [0.05, speed, 0.05], t_eval=trial.time, rtol=1e-10, atol=1e-12,
        )  # fmt: skip
        own = np.einsum("fji,fj->fi", trial.turn("brick"), trial.ang("brick"))
        crossings.append([_zero(trial.time, own[:, 1]), _zero(trial.time, euler.y[1])])
        spin = trial.spin("brick")
        drift = np.linalg.norm(spin - spin[0], axis=1) / np.linalg.norm(spin[0])
        agree(f"flipping brick, dt {dt}: change of L / L", drift, 0.0, within=(speed * dt) ** 2)
        agree(
            f"flipping brick, dt {dt}: time of the flip [s]",
            *crossings[-1],
            within=(speed * dt) ** 2 * crossings[-1][1],
        )
    gaps = [abs(ours - theirs) for ours, theirs in crossings]
    agree("flipping brick: order of convergence", np.log2(gaps[0] / gaps[1]), 2.0, within=0.3)


def _zero(time, values):
    """Time of the first change of sign, interpolated linearly."""
    k = int(np.flatnonzero(values[:-1] * values[1:] < 0)[0])
    return time[k] + (time[k + 1] - time[k]) * values[k] / (values[k] - values[k + 1])
