"""Ropes hang, swing and bend as equations say; what is released on an event falls from that moment on."""

import numpy as np
import pytest
from scipy.optimize import brentq

from text2sim.evidence.events import find_events
from text2sim.evidence.measures import evaluate
from text2sim.recording.vectors import rotate

G = 9.81

HANGING = """
scene: {duration: 4.0, dt: 0.01, record: {rate: 50}, statics: {wall: {shape: {kind: box, size: [0.02, 0.02, 0.02]}, pose: {pos: [-0.05, 1, 1.5]}}}}
bodies:
  line: {kind: rope, length: 1.2, radius: 0.006, segments: 24, direction: x, damping: 2e-3, material: {mass: 0.3}, pose: {pos: [0, 0, 1.5]}}
  slide:
    kind: rigid
    shape: {kind: box, size: [0.04, 0.04, 0.04]}
    pose: {pos: [1.22, 0, 1.5]}
    mount: {kind: slider, axis: x, actuator: {stiffness: 4000, damping: 200}}
  swing: {kind: rope, length: 1.0, radius: 0.006, segments: 20, direction: [0.05, 0, -1], damping: 0, pose: {pos: [0, 2, 1.5]}}
  stiff: {kind: rope, length: 0.2, radius: 0.005, segments: 8, youngs_modulus: 1e7, direction: x, damping: 1e-3, pose: {pos: [0, 1, 1.5]}}
actions:
  controls:
    tie: {kind: attach, body: line.link_23, to: slide}
    come: {kind: drive, joint: slide, position: {kind: ramp, to: -0.4, start: 0, end: 1}}
    clamp: {kind: attach, body: stiff.link_0, to: wall}
"""


def nodes(trial, rope, links, length):
    """Joints and last end of a rope over time [m], (F, links + 1, 3)."""
    names = [f"{rope}.link_{k}" for k in range(links)]
    end = trial.pos(names[-1]) + rotate(trial.quat(names[-1]), np.array([0.0, 0.0, -length / links]))
    return np.stack([*(trial.pos(name) for name in names), end], axis=1)


@pytest.fixture(scope="module")
def hanging(simulate):
    return simulate(HANGING)


def test_a_rope_between_two_points_hangs_as_a_catenary(hanging, agree):
    """The last link is welded to the slider, and so level: the other 23 hang between its ends."""
    x = nodes(hanging, "line", 24, 1.2)
    lengths = np.linalg.norm(np.diff(x, axis=1), axis=2)
    agree("a rope does not stretch [m]", lengths, 0.05, within=1e-6)
    line = x[-1, :24]
    span, length = float(line[-1, 0] - line[0, 0]), 23 * 0.05
    a = brentq(lambda a: 2 * a * np.sinh(span / 2 / a) - length, 0.05, 5)
    along = (np.arange(24) * 0.05 - length / 2) / a
    theory = a * np.sqrt(1 + along**2) - a * np.sqrt(1 + along[0] ** 2)
    agree("sag of a catenary [m]", line[:, 2] - line[0, 2], theory, within=0.008)


def test_a_hanging_rope_swings_with_its_first_frequency(hanging, agree):
    """W = j/2 sqrt(g / L), j = 2.405 the first zero of the Bessel function J0."""
    x = nodes(hanging, "swing", 20, 1.0)[:, -1, 0]
    t, cross = hanging.time, np.flatnonzero(np.diff(np.sign(x)))
    moments = t[cross] - x[cross] * (t[cross + 1] - t[cross]) / (x[cross + 1] - x[cross])
    # Straight, as it starts, it swings in higher ways, too: over two periods they even out.
    agree(
        "period of a hanging rope [s]", (moments[4] - moments[0]) / 2, 4 * np.pi / 2.4048 * np.sqrt(1 / G), within=0.03
    )


def test_a_stiff_rope_bends_as_its_springs_say(hanging, agree):
    """Each joint turns by its moment over k = E I / l: seven links of 25 mm hang on the first, which is clamped."""
    x = nodes(hanging, "stiff", 8, 0.2)[-1]
    length, k = 0.025, 1e7 * np.pi * 0.005**4 / 4 / 0.025
    weight = 1000 * np.pi * 0.005**2 * length * G
    turns = np.arctan2(-np.diff(x[:, 2]), np.diff(x[:, 0]))
    middles = (x[1:, 0] + x[:-1, 0]) / 2
    moments = np.array([(weight * (middles[j:] - x[j, 0])).sum() for j in range(1, 8)])
    agree("turn of each joint [rad]", np.diff(turns), moments / k, within=0.02 * moments[0] / k)
    assert x[0, 2] - x[-1, 2] > 0.02


WAITING = """
scene: {duration: 1.0, dt: 0.01, record: {rate: 25}, statics: {floor: {shape: {kind: plane}}, beam: {shape: {kind: box, size: [3, 0.1, 0.1]}, pose: {pos: [0, 0, 2]}}}}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 0.6]}}
  box: {kind: rigid, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0.6, 0, 1.5]}}
  other: {kind: rigid, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [1.2, 0, 1.5]}}
actions:
  controls:
    hang: {kind: attach, body: box, to: beam}
    hold: {kind: attach, body: other, to: world}
    drop: {kind: release, attach: hang, on: landed}
    follow: {kind: release, attach: hold, on: gate}
  measures:
    fast: {kind: speed, of: box}
  events:
    landed: {kind: contact, between: [ball, floor]}
    gate: {kind: enters, of: box, region: {kind: box, min: [0, -1, 0.5], max: [1, 1, 1.2]}, after: quick}
    quick: {kind: threshold, measure: fast, above: 1.0}
"""


def test_what_waits_for_an_event_falls_when_it_is_found_later(simulate, agree):
    """The program sees it come; the recording, of which every fourth step is kept, says the same."""
    trial = simulate(WAITING)
    log = find_events(trial.recording, evaluate(trial.recording))
    t = trial.time
    for body, event in (("box", "landed"), ("other", "gate")):
        speed = trial.vel(body)[:, 2]
        falling = np.flatnonzero(speed < -0.5)[0]
        since, found = t[falling] + speed[falling] / G, log.first(event)
        assert found is not None
        agree(f"{body} falls from its event on [s]", since, found, within=0.0101)
    assert not log.problems


LOADED = """
scene: {duration: 0.5, dt: 0.0025, max_speed: 50}
bodies:
  rope: {kind: rope, length: 1.0, radius: 0.004, segments: 20, material: {mass: 0.05}, youngs_modulus: 1e5, pose: {pos: [0, 0, 2]}}
  bob: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, material: {mass: 10}, pose: {pos: [0, 0, 0.93]}}
actions:
  controls:
    tie: {kind: attach, body: rope.link_19, to: bob}
    kick: {kind: impulse, body: bob, impulse: [5, 0, 0], at: 0.1}
"""


def test_a_light_rope_survives_a_heavy_load_that_is_struck(simulate, agree):
    """200 times its weight hangs on it; with one substep it is at 1e4 m/s within 0.12 s. The load swings on at J / m."""
    trial = simulate(LOADED)
    agree("light rope, struck load: highest speed [m/s]", np.abs(trial.vel("bob")).max(), 0.5, within=0.15)
    agree("light rope: height of the load [m]", trial.pos("bob")[:, 2], 0.93, within=0.02)


PULLEYS = """
scene: {duration: 0.2, dt: 0.005}
bodies:
  wheel:
    kind: rigid
    shape: {kind: cylinder, radius: 0.1, height: 0.04}
    pose: {pos: [0, 0, 1.5], euler_deg: [90, 0, 0]}
    material: {mass: 4, friction: 1.0}
    mount: {kind: hinge, axis: z}
  belt: {kind: rope, along: [[-0.105, 0, 1.3], {round: wheel}, [0.105, 0, 1.3]], radius: 0.005, segments: 18, anchored: false, material: {mass: 0.06}}
  light: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [-0.105, 0, 1.24]}, material: {mass: 0.5}}
  heavy: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [0.105, 0, 1.24]}, material: {mass: 3}}
  post:
    kind: rigid
    shape: {kind: cylinder, radius: 0.1, height: 0.1}
    pose: {pos: [0, 1, 1.5], euler_deg: [90, 0, 0]}
    material: {friction: 0.1}
    mount: {kind: fixed}
  line:
    kind: rope
    along: [[-0.105, 1.006, 1.3], {round: post, turns: 1}, [0.105, 0.994, 1.3]]
    radius: 0.005
    segments: 32
    anchored: false
    material: {mass: 0.02, friction: 0.01}
  small: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [-0.105, 1.006, 1.24]}, material: {mass: 0.5}}
  large: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [0.105, 0.994, 1.24]}, material: {mass: 3}}
actions:
  controls:
    a: {kind: attach, body: belt.link_0, to: light}
    b: {kind: attach, body: belt.link_17, to: heavy}
    c: {kind: attach, body: line.link_0, to: small}
    d: {kind: attach, body: line.link_31, to: large}
"""


def acceleration(trial, body):
    """Of a body upwards [m/s2], from its way once the rope is taut."""
    part = trial.time > 0.05
    return 2 * np.polyfit(trial.time[part], trial.pos(body)[part, 2], 2)[0]


def test_light_ropes_over_a_pulley_and_round_a_post(simulate, agree):
    """Ropes of 20 and 60 g between 0.5 and 3 kg, which flew apart: contacts were too soft for links of half a gram.

    Atwood: a = g (m2 - m1) / (m1 + m2 + m_rope + I / (R + r)^2), I = M R^2 / 2, as long as the rope does not slip.

    Euler and Eytelwein: round a post that stands still the pull grows by e^(mu b R / (R + r)) over the angle b, for friction
    acts on the surface of the post and the pull along the middle of the rope; a = g (m2 - m1 e^..) / (m2 + m1 e^..).
    """
    trial = simulate(PULLEYS)
    atwood = G * (3 - 0.5) / (3.5 + 0.06 + 0.02 / 0.105**2)
    agree("two weights over a pulley [m/s2]", -acceleration(trial, "heavy"), atwood, within=0.03 * atwood)
    agree("the lighter one rises [m/s2]", acceleration(trial, "light"), atwood, within=0.05 * atwood)
    turning = abs(trial.ang("wheel")[-1]).max()
    agree("the pulley turns with the rope [rad/s]", turning, -trial.vel("heavy")[-1, 2] / 0.105, within=0.03 * turning)
    grown = np.exp(0.1 * 3 * np.pi * 0.1 / 0.105)
    capstan = G * (3 - 0.5 * grown) / (3 + 0.5 * grown)
    agree("a rope slips round a post [m/s2]", -acceleration(trial, "large"), capstan, within=0.06 * capstan)
    depth = max(trial.contact("line", "post")[2].max(), trial.contact("belt", "wheel")[2].max())
    assert depth < 0.0025, "half the radius of the rope"


FINE = """
scene: {duration: 0.35, dt: 0.005}
bodies:
  post:
    kind: rigid
    shape: {kind: cylinder, radius: 0.06, height: 0.1}
    pose: {pos: [0, 0, 1.5], euler_deg: [90, 0, 0]}
    material: {friction: 0.1}
    mount: {kind: fixed}
  line:
    kind: rope
    along: [[-0.065, 0.006, 1.0], {round: post, turns: 1}, [0.065, -0.006, 1.42]]
    radius: 0.005
    segments: 70
    anchored: false
    material: {mass: 0.02, friction: 0.01}
  small: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [-0.065, 0.006, 0.94]}, material: {mass: 0.5}}
  large: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [0.065, -0.006, 1.36]}, material: {mass: 3}}
actions:
  controls:
    c: {kind: attach, body: line.link_0, to: small}
    d: {kind: attach, body: line.link_69, to: large}
"""


def test_many_short_links_slide_round_a_post(simulate, agree):
    """70 links of 0.3 g, of which each spins faster and faster unless its joints are damped; Euler-Eytelwein as above."""
    trial = simulate(FINE)
    grown = np.exp(0.1 * 3 * np.pi * 0.06 / 0.065)
    capstan = G * (3 - 0.5 * grown) / (3 + 0.5 * grown)
    agree("a fine rope slips round a post [m/s2]", -acceleration(trial, "large"), capstan, within=0.06 * capstan)
    spins = np.abs(np.stack([trial.ang(f"line.link_{k}") for k in range(1, 69)]))
    agree("links turn with the rope [rad/s]", spins.max(), 1.5 / 0.065, within=60)


def test_a_heavy_payload_of_a_thin_chain_takes_a_blow(simulate, agree):
    """V = J / m. The 20 links weigh 0.2 kg together, and their joints' inertia is lost beside the load's if it is too small.

    The chain turns by v dt / 2 L in the step of the blow, so that the speed is within v^2 t / L of J / m soon after it.
    """
    radius, density, mass = 0.115, 7850.0, 7850 * 4 / 3 * np.pi * 0.115**3
    trial = simulate(f"""
scene: {{duration: 0.3, dt: 0.01, record: {{rate: 100}}}}
bodies:
  line:
    kind: chain
    links: 20
    link_length: 0.05
    radius: 0.003
    pose: {{pos: [0, 0, 2.5]}}
    payload: {{shape: {{kind: sphere, radius: {radius}}}, material: {{density: {density}}}}}
actions:
  controls:
    blow: {{kind: impulse, body: line.payload, impulse: [{mass}, 0, 0], at: 0.1}}
""")
    speed = np.linalg.norm(trial.vel("line.payload"), axis=1)
    agree("before the blow [m/s]", speed[trial.time < 0.095], 0.0, within=1e-3)
    agree("after the blow [m/s]", speed[np.searchsorted(trial.time, 0.12)], 1.0, within=0.02)


LOST = """
scene: {duration: 0.6, dt: 0.01, record: {rate: 100}, statics: {floor: {shape: {kind: plane}}}}
bodies:
  line:
    kind: chain
    links: 20
    link_length: 0.05
    radius: 0.003
    anchored: false
    pose: {pos: [0, 0, 1.6]}
    payload: {shape: {kind: sphere, radius: 0.115}, material: {mass: 50}}
  made:
    kind: articulated
    links:
      seg:
        repeat: 21
        parent: "seg_${k - 1}"
        shape: {kind: capsule, radius: 0.003, length: 0.044}
        pose: {pos: [0, 0, "${-0.05 if k else 0}"]}
        joint: {kind: ball, anchor: [0, 0, 0.025]}
      load:
        parent: seg_20
        shape: {kind: sphere, radius: 0.115}
        material: {mass: 50}
        pose: {pos: [0, 0, -0.14]}
        joint: {kind: ball, anchor: [0, 0, 0.115]}
    material: {density: 7800}
    pose: {pos: [1, 0, 2.5]}
actions:
  controls:
    blow: {kind: impulse, body: made.load, impulse: [50, 0, 0], at: 0.1}
"""


def test_links_that_are_lost_in_32_bits_are_not_in_64(simulate, agree):
    """A loose chain falls by g t^2 / 2 and lands on its payload; of one made link by link the load leaves a blow with J / m."""
    trial = simulate(LOST)
    height, t = trial.pos("line.payload")[:, 2], trial.time
    fall = t < 0.26
    agree("a loose chain falls [m]", height[fall], 0.485 - G * t[fall] ** 2 / 2, within=0.002)
    agree("its payload lies [m]", height[-1], 0.115, within=0.005)
    speed = np.linalg.norm(trial.vel("made.load"), axis=1)
    agree("a chain made by hand after a blow [m/s]", speed[np.searchsorted(t, 0.12)], 1.0, within=0.02)
