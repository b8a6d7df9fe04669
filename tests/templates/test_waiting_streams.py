"""Streams before and after they come out."""

import numpy as np

from text2sim.templates.streams import Stream, flowing


def test_what_is_to_come_rests_in_the_mouth_and_is_not_drawn():
    stream = Stream((0, 0, 1), (0, 0, -1), 0.02, 0.5, 0.1, 1.0, 0.005)
    assert abs(len(stream) * 0.005**3 / (np.pi * 0.02**2 * 0.5) - 1) < 0.1, "its particles have its volume"
    assert (np.diff(stream.times) >= 0).all() and stream.times[0] >= 0.1 and stream.times[-1] <= 1.1
    in_engine = np.full((len(stream), 3), 7.0)
    assert not flowing(stream.fill_in(in_engine, 0), stream.mouth, 0.005).any(), "nothing has come out at the start"
    stream.now = 0.6
    come = flowing(stream.fill_in(in_engine, 0), stream.mouth, 0.005)
    assert abs(come.mean() - 0.5) < 0.02
    assert (stream.fill_in(in_engine, 1)[~come] == 0).all()


def test_layers_of_a_stream_do_not_come_down_in_columns():
    """On a grid, with half of its layers shifted by half a distance, all places would be within the jitter of it."""
    spacing = 0.005
    mouth = Stream((0, 0, 1), (0, 0, -1), 0.02, 0.5, 0.0, 1.0, spacing).mouth[:, :2]
    off = np.abs((2 * mouth / spacing + 0.5) % 1 - 0.5)  # from the nearest line of the grid, in half distances
    assert (off > 0.25).mean() > 0.4
