"""Fragments of a body touch all over, and do not push each other away."""

import numpy as np
import pytest

G, DT = 9.81, 0.005
SCENE = """
scene: {duration: 0.3, dt: 0.005, substeps: 1, statics: {floor: {shape: {kind: plane}}}}
bodies:
  slab:
    kind: rigid
    shape: {kind: box, size: [0.2, 0.15, 0.02]}
    material: {density: 2500}
    place: {on: floor}
    repeat: {kind: fragments, count: 6}
  cup:
    kind: rigid
    shape: {kind: cup, radius: 0.05, height: 0.1, thickness: 0.006}
    material: {mass: 0.3}
    pose: {pos: [0.5, 0, 2]}
    repeat: {kind: fragments, count: 8}
"""


@pytest.fixture(scope="module")
def trial(simulate):
    return simulate(SCENE)


def copies(trial, body):
    return [link for link in trial.recording.states.links if link.body.startswith(f"{body}[")]


def paths(trial, body):
    """Centres of mass of the fragments over time [m], shape (F, n, 3)."""
    return np.stack([trial.com(link.body) for link in copies(trial, body)], axis=1)


def test_a_slab_on_the_floor_stays_a_heap(trial):
    # A contact yields by a few times g timeconst^2 / 4 = 0.2 mm, and nothing pushes sideways.
    moved = paths(trial, "slab") - paths(trial, "slab")[0]
    assert np.abs(moved).max() < 5e-4


def test_a_falling_cup_stays_whole(trial):
    falls = paths(trial, "cup")
    # A symplectic Euler step falls by g t (t + h) / 2 in the time t.
    t = trial.time
    expected = falls[0] - np.multiply.outer(G * t * (t + DT) / 2, np.array([0, 0, 1.0]))[:, None]
    assert np.abs(falls - expected).max() < 1e-4
    apart = falls - falls.mean(axis=1, keepdims=True)
    assert np.abs(apart - apart[0]).max() < 1e-4


def test_the_engine_has_the_mass_of_the_whole(trial):
    assert sum(link.mass for link in copies(trial, "slab")) == pytest.approx(2500 * 0.2 * 0.15 * 0.02, rel=1e-3)
    assert sum(link.mass for link in copies(trial, "cup")) == pytest.approx(0.3, rel=1e-3)
