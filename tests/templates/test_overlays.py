"""What is written into pictures."""

import numpy as np

from text2sim.templates.cadence import Frame
from text2sim.templates.overlays import Overlay

GREY = np.full((180, 320, 3), 90, np.uint8)


def frame(k=0, t=0.0, speed=1.0):
    return Frame(k, "main", t, 0.0, t, t, 1.0, speed)


def overlay(measured=None, **wanted):
    plain = {"title": None, "time": False, "values": [], "inset": False}
    return Overlay({"overlay": plain | wanted, "fps": 10.0, "resolution": (320, 180)}, measured)


def changed(image):
    rows, columns = np.nonzero((image != GREY).any(axis=2))
    return (rows.min(), rows.max(), columns.min(), columns.max()) if len(rows) else None


def test_nothing_wanted_nothing_written():
    assert overlay().draw(GREY, frame()) is GREY
    assert overlay(values=["height"]).draw(GREY, frame()) is GREY, "nothing was measured yet"


def test_the_title_is_at_the_lower_left_and_goes():
    title = overlay(title="A ball through a wall")
    top, bottom, left, right = changed(title.draw(GREY, frame()))
    assert top > 120
    assert bottom < 178
    assert 5 < left < 30 < right < 310
    assert changed(title.draw(GREY, frame(k=40))) is None
    long = overlay(title="word " * 24).draw(GREY, frame())
    assert changed(long)[3] < 315, "cut off, not beyond the edge"


def test_time_and_values_are_at_the_upper_right():
    top, bottom, left, _ = changed(overlay(time=True).draw(GREY, frame(t=1.25)))
    assert bottom < 40
    assert left > 160
    slow = changed(overlay(time=True).draw(GREY, frame(t=1.25, speed=0.1)))
    assert slow[2] < left, "slow motion is said"
    measured = overlay(lambda t: [f"height {t:.1f} m"], time=True, values=["height"]).draw(GREY, frame())
    assert changed(measured)[1] > bottom


def test_the_first_picture_stays_in_a_corner():
    inset = overlay(inset=True)
    assert changed(inset.draw(np.full_like(GREY, 200), frame())) == (0, 179, 0, 319), "the first as it is"
    later = inset.draw(GREY, frame(k=5))
    assert (later[20:30, 20:30] == 200).all()
    assert (later[100:, 200:] == 90).all()


def test_a_view_that_is_repeated_says_so():
    again = frame(t=1.0)._replace(again=True)
    assert changed(overlay().draw(GREY, again)) is not None
    left = changed(overlay(time=True).draw(GREY, again))[2]
    assert left < changed(overlay(time=True).draw(GREY, frame(t=1.0)))[2]


def test_the_pace_of_a_film_that_nobody_paced_is_said_where_it_is_not_that_of_life():
    assert changed(overlay(pace=True).draw(GREY, frame())) is None
    assert changed(overlay(pace=True).draw(GREY, frame(speed=0.2))) is not None
