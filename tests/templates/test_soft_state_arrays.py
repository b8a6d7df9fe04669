"""Recorded states of deformable bodies, read back between frames."""

import numpy as np
import pytest

from text2sim.templates.soft_states import CHUNKS_IN_HAND, SoftStates

ROWS = [{"body": "a", "points": [0, 2]}, {"body": "b[1]", "points": [2, 5]}]


class Chunk(dict):
    """Stands in for an npz file; counts how often an array is read."""

    reads = 0

    def __getitem__(self, name):
        self.reads += 1
        return super().__getitem__(name)


@pytest.fixture
def chunks():
    points = np.arange(7 * 5 * 3, dtype=np.float32).reshape(7, 5, 3)
    bounds = [(0, 3), (3, 4), (4, 7)]
    return points, [Chunk(time=np.arange(a, b), soft_points=points[a:b]) for a, b in bounds]


def test_states_lie_on_the_line_between_frames_across_chunks(chunks):
    points, files = chunks
    states = SoftStates(ROWS, files)
    for a, b, w in [(0, 1, 0.25), (2, 3, 0.5), (3, 4, 0.9), (6, 6, 1.0)]:
        assert states.at("soft_points", (a, b, w)) == pytest.approx((1 - w) * points[a] + w * points[b])


def test_chunks_are_read_once_when_time_runs_on(chunks):
    _, files = chunks
    states = SoftStates(ROWS, files)
    before = [file.reads for file in files]
    for i in range(6):
        states.at("soft_points", (i, i + 1, 0.5))
        assert len(states._in_hand) <= CHUNKS_IN_HAND
    assert [file.reads - n for file, n in zip(files, before, strict=True)] == [1, 1, 1]


def test_the_centre_of_a_body_is_the_mean_of_its_points(chunks):
    points, files = chunks
    states = SoftStates(ROWS, files)
    assert states.centre("b[1]", (3, 4, 0.5)) == pytest.approx(points[3:5, 2:].mean(axis=(0, 1)))
    assert states.centre("a", (0, 0, 1.0)) == pytest.approx(points[0, :2].mean(axis=0))
    assert states.centre("floor", (0, 0, 1.0)) is None
