"""Stiff and creased sheets, and damp sand, against the equations of their laws."""

import numpy as np

from tests.physics.conftest import rows

FOLDED = """
scene: {duration: 1.6, dt: 0.004, gravity: [0, 0, 0], record: {rate: 25}}
bodies:
  flap:
    kind: rigid
    repeat: {kind: line, count: 3, step: [0, 0.5, 0]}
    shape: {kind: box, size: [0.08, 0.06, 0.01]}
    material: {touch_soft: false}
    mount: {kind: hinge, axis: y, anchor: [-0.06, 0, 0], actuator: {stiffness: 50, damping: 1}}
    pose: {pos: [0.06, 0, 0]}
  springy: {kind: cloth, cell: 0.02, shape: {kind: sheet, size: [0.2, 0.06]}, material: {area_density: 0.2, damping: 10}}
  foil: {kind: cloth, cell: 0.02, shape: {kind: sheet, size: [0.2, 0.06]}, material: {area_density: 0.2, crease_radius: 0.5, damping: 10}, pose: {pos: [0, 0.5, 0]}}
  card: {kind: cloth, cell: 0.02, shape: {kind: sheet, size: [0.2, 0.06]}, material: {area_density: 0.2, crease_radius: 0.005, damping: 10}, pose: {pos: [0, 1, 0]}}
  curled: {kind: cloth, cell: 0.02, shape: {kind: sheet, size: [0.2, 0.06], sag: 0.06}, material: {area_density: 0.2, rest_shape: start}, pose: {pos: [0, 1.5, 0]}}
  uncurled: {kind: cloth, cell: 0.02, shape: {kind: sheet, size: [0.2, 0.06], sag: 0.06}, material: {area_density: 0.2}, pose: {pos: [0, 2, 0]}}
actions:
  controls:
    fold: {kind: drive, joint: "flap[*]", position: {kind: ramp, to: -1.5, start: 0, end: 0.8}}
HOLDS
"""


def test_folds_tighter_than_the_crease_radius_stay(simulate, agree):
    """One half is held, the other turned by 1.5 rad and let go. Both edges of the row between them bend 0.02 m of cloth.

    An edge yields at 0.02 m / radius, and springs back by that: 0.04 rad in foil; 4 rad in card, so it never yields.
    Damping stops the swing about the angle at rest.
    """
    holds = "".join(
        f"    {strip}_{side}: {{kind: attach, body: {strip}, region: {{box: {{min: {box[0]}, max: {box[1]}}}}}, to: {to}}}\n"
        f"    {strip}_{side}_free: {{kind: release, attach: {strip}_{side}, at: 1}}\n"
        for k, strip in enumerate(("springy", "foil", "card"))
        for side, box, to in (
            ("held", ([-0.2, -0.1, -0.1], [-0.001, 0.1, 0.1]), "world"),
            ("turned", ([0.011, -0.1, -0.1], [0.2, 0.1, 0.1]), f'"flap[{k}]"'),
        )
    )
    trial = simulate(FOLDED.replace("HOLDS", holds))

    def bent(strip):
        points, _ = rows(trial.states, strip)
        left, right = (points[:, side].mean(axis=1) for side in (points[0, :, 0] < -0.05, points[0, :, 0] > 0.05))
        middle = points[:, np.abs(points[0, :, 0]) < 0.015].mean(axis=1)
        return np.pi - np.arccos(np.clip(np.einsum("ij,ij->i", unit(left - middle), unit(right - middle)), -1, 1))

    held = bent("foil")[24]
    agree("foil keeps its fold but for 0.08 rad at most [rad]", bent("foil")[-1], held - 0.04, within=0.04)
    agree("a fold that no edge yields to springs back [rad]", bent("card")[-1], 0.0, within=0.2)
    agree("as without a radius [rad]", bent("card"), bent("springy"), within=1e-3)
    high = {name: np.ptp(rows(trial.states, name)[0][..., 2], axis=1) for name in ("curled", "uncurled")}
    agree("a curl at rest stays [m]", high["curled"], high["curled"][0], within=2e-3)
    assert high["uncurled"][-1] < 0.03


HEAPS = """
scene: {duration: 0.4, dt: 0.004, statics: {floor: {shape: {kind: plane}, material: {friction: 0.8}}}}
bodies:
  firm: {kind: granular, cell: 0.02, shape: {kind: box, size: [0.12, 0.12, 0.2]}, material: {cohesion: 1600}, pose: {pos: [0, 0, 0.11]}}
  weak: {kind: granular, cell: 0.02, shape: {kind: box, size: [0.12, 0.12, 0.2]}, material: {cohesion: 400}, pose: {pos: [0, 0.6, 0.11]}}
"""


def test_damp_sand_stands_as_high_as_its_cohesion_lets_it(simulate):
    """Its compressive strength is 2 C tan(45 deg + phi / 2) (Mohr and Coulomb).

    1600 Pa give 6.1 kPa, 400 Pa 1.5 kPa; the foot of a block of 0.2 m bears rho g h = 3.1 kPa.
    """
    trial = simulate(HEAPS)
    high = {name: rows(trial.states, name)[0][-1, :, 2].max() for name in ("firm", "weak")}
    assert high["firm"] > 0.2, "it settles by a particle"
    assert high["weak"] < 0.17


CARD = """
  card:
    kind: cloth
    cell: 0.02
    shape: {kind: sheet, size: [0.26, 0.1]}
    material: {area_density: 0.3, rigidity: 0.02, air_resistance: 0}
    pose: {pos: [0, 1, 1]}
"""
CLAMPED = """
scene: {duration: 0.3, dt: 0.002, substeps: 16, record: {rate: 500}}
bodies:
  plain: {kind: cloth, cell: 0.02, shape: {kind: sheet, size: [0.26, 0.1]}, material: {area_density: 0.3, air_resistance: 0}, pose: {pos: [0, 0, 1]}}
%s
actions:
  controls:
    clamp_plain: {kind: attach, body: plain, region: {box: {min: [-0.2, -0.1, -0.1], max: [-0.069, 0.1, 0.1]}}, to: world}
%s
"""
CLAMP = "    clamp: {kind: attach, body: card, region: {box: {min: [-0.2, -0.1, -0.1], max: [-0.069, 0.1, 0.1]}}, to: world}"


def test_a_stiff_sheet_sways_like_a_cantilever_and_a_plain_one_as_in_the_engine(simulate, agree):
    """Let go when level, its end comes lowest after half a period of 2 pi L^2 / 3.516 sqrt(m / D) (Euler and Bernoulli).

    The engine's uneven triangles share a bend unevenly, edges of slivers are softened, and the clamp is somewhere
    between two rows of points: half a period was 23 % longer, so the sheet is two thirds as stiff.
    """
    trial, alone = simulate(CLAMPED % (CARD, CLAMP)), simulate(CLAMPED % ("", ""))

    def end(of, name):
        points, _ = rows(of.states, name)
        return points[:, points[0, :, 0] > 0.129, 2].mean(axis=1)

    low = end(trial, "card").argmin()
    agree("half a period [s]", trial.time[low], 1.23 * np.pi * 0.2**2 / 3.516 * np.sqrt(0.3 / 0.02), within=0.01)
    agree("a plain one beside it is as without it [m]", end(trial, "plain"), end(alone, "plain"), within=1e-3)


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
