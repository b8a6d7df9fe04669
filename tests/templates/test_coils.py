"""Springs as meshes: between their ends, closed, and as long as they are."""

from types import SimpleNamespace

import numpy as np
import pytest

from text2sim.templates.coils import CORD, SIDES, Coils, coil, cord

A, B = np.array([0.1, 0.2, 1.0]), np.array([0.4, 0.2, 0.6])


def middles(vertices):
    """The line along the middle of a tube."""
    return vertices.reshape(-1, SIDES, 3).mean(axis=1)


def along(line):
    return np.linalg.norm(np.diff(line, axis=0), axis=1).sum()


@pytest.mark.parametrize("draw", [coil, cord])
@pytest.mark.parametrize("b", [B, A + [0, 0, -0.3], A + [0, 0, 0.3], A + [0.3, 0, 0]])
def test_a_spring_reaches_from_end_to_end_and_is_closed(draw, b):
    vertices, faces, normals = draw(A, b, 0.4)
    line = middles(vertices)
    np.testing.assert_allclose([line[0], line[-1]], [A, b], atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-9)
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()  # every edge has two faces
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    assert (np.cross(a, b) * c).sum() > 0  # they face outward


def test_a_coil_has_its_radius_and_as_many_turns_at_any_length():
    relaxed, stretched = (middles(coil(A, A + [0, 0, size], 0.3, 0.02)[0]) for size in (0.3, 0.5))
    for line in (relaxed, stretched):
        assert np.linalg.norm(line[:, :2] - A[:2], axis=1).max() == pytest.approx(0.02 * (1 - 0.16), rel=1e-3)
    turns = [np.unwrap(np.arctan2(*(line - A)[40:-40, :2].T))[[0, -1]] for line in (relaxed, stretched)]
    assert np.ptp(turns[0]) == pytest.approx(np.ptp(turns[1]), rel=1e-6)


@pytest.mark.parametrize("b", [B, A + [0.5, 0, 0], A + [0, 0, -0.5], A + [0, 0, 0.01]])
@pytest.mark.parametrize("length", [0.51, 0.6, 0.9])
def test_a_slack_cord_is_as_long_as_it_is(b, length):
    line = middles(cord(A, b, length)[0])
    assert along(line) == pytest.approx(length, rel=1e-3)
    assert line[CORD // 2, 2] < (A[2] + b[2]) / 2


def test_a_stretched_cord_keeps_its_volume():
    vertices = cord(A, A + [0, 0, 0.4], 0.1, 0.01)[0]
    assert np.linalg.norm(vertices[:SIDES] - A, axis=1) == pytest.approx(0.005)


def test_springs_are_drawn_in_their_span():
    row = {"control": "pull", "length": None, "start": 1.0, "end": 2.0}
    states = SimpleNamespace(
        layout={"springs": [row | {"control": "hidden"}, row]},
        spring_ends=lambda t: np.array([[[5.0, 0, 0], [6, 0, 0]], [[0, 0, 0], [t, 0, 0]]]),
    )
    coils = Coils(states, {"pull": {"form": "cord", "radius": 0.01}})
    assert [len(coils.at(t)) for t in (0.5, 1.0, 1.99, 2.0)] == [0, 1, 1, 0]
    (strand,) = coils.at(1.5)
    np.testing.assert_allclose(middles(strand.vertices)[[0, -1]], [[0, 0, 0], [1.5, 0, 0]], atol=1e-9)
    # Without a length, it has none to spare as it begins.
    np.testing.assert_allclose(middles(coils.at(1.0)[0].vertices)[:, 2], 0.0, atol=1e-9)
