"""Frames that agents are shown of a run: which moments, and which pictures between them."""

import numpy as np
import pytest

from text2sim.agents.frame_choice import (
    MIN_INTERVAL,
    FrameMoment,
    choose_frames,
    choose_stills,
    moments,
)
from text2sim.templates.cadence import Frame


def test_events_that_are_expected_come_first_and_those_at_one_time_count_once() -> None:
    times = {
        "left": 1.28,
        "right": 1.28,
        "a": 0.2,
        "b": 0.5,
        "c": 0.8,
        "d": 1.1,
        "front": 5.2,
        "middle": 6.4,
        "rear": 7.5,
    }
    evidence = {"events": {name: {"first": t} for name, t in times.items()}, "time": {"reached": 9.0}}
    actions = {
        "events": {"middle": {"after": "front"}, "rear": {"after": "middle"}},
        "expect": {"climbs": {"event": "rear", "within": [3, 9]}, "crooked": {"measure": "tilt", "on": "left"}},
    }
    told = [one.reason for one in moments(evidence, actions) if one.decisive]
    assert told == ["left", "front", "middle", "rear", "a", "right"], "the last one is in the picture of the first"
    actions["expect"]["meets"] = {"event": "right"}
    assert [one.reason for one in moments(evidence, actions) if one.decisive] == [
        "left",
        "right",
        "front",
        "middle",
        "rear",
        "a",
    ]


def test_the_longest_time_without_a_picture_gets_one() -> None:
    """Everything that is measured happens early; what comes to pass between there and the end is shown all the same."""
    pictures = [Frame(k, "main", k * 0.05, 0.0, k * 0.05, k * 0.05, 0.0, 1.0) for k in range(141)]
    wanted = [FrameMoment(0.15 * k, f"event {k}") for k in range(1, 15)]
    times = [one.frame.t for one in choose_frames(wanted, pictures, 12)]
    assert len(times) == 12 and times[0] == 0.0 and times[-1] == 7.0
    assert max(np.diff(times)) < 7.0 / 2


def test_each_shot_is_shown_although_nothing_is_wanted_in_it() -> None:
    """Four shots of a second; everything that is wanted lies in the first and the last."""
    pictures = [Frame(k, f"shot{k // 20}", k * 0.05, 0.0, k * 0.05, k * 0.05, 0.0, 1.0) for k in range(80)]
    wanted = [FrameMoment(0.1 * k, f"event {k}") for k in (*range(1, 10), *range(31, 39))]
    found = choose_frames(wanted, pictures, 12)
    assert len(found) == 12
    assert {one.frame.camera for one in found} == {"shot0", "shot1", "shot2", "shot3"}


def film(seconds: float, speed: float = 1.0, cameras: str = "m") -> list[Frame]:
    """A film of 25 pictures a second, in equal shots by cameras with these letters."""
    step, count = speed / 25, round(seconds / speed * 25)
    rows = [(k, cameras[k * len(cameras) // count], k * step) for k in range(count)]
    return [Frame(k, camera, t, 0.0, t, t, 0.0, speed) for k, camera, t in rows]


def moving(pictures: list[Frame], start: float, end: float) -> list[float]:
    """Motion that is even between two times [s], two heights of the picture in all."""
    return [2 * min(max((one.t - start) / (end - start), 0.0), 1.0) for one in pictures]


WIND = [
    FrameMoment(0.88, "expect:quiet", (), True), FrameMoment(3.88, "blue_down", (), True), FrameMoment(6.0, "calm", (), True),
    *(FrameMoment(t, f"before {t}") for t in (0.6, 0.75, 1.05, 1.2, 1.35, 5.7, 5.85, 6.15, 6.3, 6.45)),
]  # fmt: skip


def test_a_slide_gets_pictures_in_place_of_those_that_resemble_their_neighbours() -> None:
    """A towel slides from 3.4 s on until it is off the line at 3.88 s; before and after it, all hangs and lies still."""
    pictures = film(7.5)
    plain = choose_frames(WIND, pictures, 12)
    assert not any(3.4 < one.frame.t < 3.84 for one in plain), "time alone does not know"
    found = choose_frames(WIND, pictures, 12, moving(pictures, 3.4, 3.9))
    assert len(found) == 12
    assert sum(3.4 < one.frame.t < 3.84 for one in found) >= 2
    assert {"expect:quiet", "blue_down", "calm"} <= {reason for one in found for reason in one.reasons}
    assert max(b.frame.t - a.frame.t for a, b in zip(found, found[1:], strict=False)) < 3.0, "time counts as well"
    near = [*WIND, *(FrameMoment(0.02 * k, f"at {k}") for k in range(375))]
    assert all(one.reasons for one in choose_frames(near, pictures, 12, moving(pictures, 3.4, 3.9))), (
        "new ones are named"
    )


def test_a_film_is_judged_by_pictures_of_its_fall_and_no_two_alike() -> None:
    """All drives evenly until 1.9 s, slides and tips over, and rests from 2.9 s on."""
    pictures = film(4.88)
    wanted = [FrameMoment(1.06, "even"), FrameMoment(4.9, "slid"), FrameMoment(0.02, "on"), FrameMoment(1.7, "braking")]
    times = [one.t for one in choose_stills(wanted, pictures, moving(pictures, 1.9, 2.9))]
    assert len(times) == 8, "six, and those of two events between the ends"
    assert sum(1.95 < t < 2.85 for t in times) >= 3
    assert (times[0], times[-1]) == (0.0, pictures[-1].t) and any(abs(t - 1.06) < 0.03 for t in times)
    assert min(np.diff(times)) >= MIN_INTERVAL
    assert len(choose_stills(wanted[3:], pictures)) == 7


def test_a_film_is_judged_by_what_happens_in_it_before_what_only_stays() -> None:
    kept = [FrameMoment(t, f"expect:kept at {t}") for t in (0.6, 1.9, 2.2)]
    wanted = [*kept, FrameMoment(6.48, "after post and bell met", decisive=True)]
    pictures = film(9.0)
    times = [one.t for one in choose_stills(wanted, pictures, moving(pictures, 0.5, 2.5))]
    assert any(abs(t - 6.48) < 0.03 for t in times)


def test_events_at_the_end_are_shown_where_there_are_many() -> None:
    times = {"starts": 0.8, **{f"swing_{k}": 1.2 + 0.7 * k for k in range(7)}, "hit": 6.2, "out": 6.4, "rest": 7.3}
    evidence = {"events": {name: {"first": t} for name, t in times.items()}, "time": {"reached": 9.0}}
    expect = {name: {"event": name} for name in ("swing_6", "hit", "out", "rest")} | {
        "slow": {"measure": "x", "on": "starts"}
    }
    actions = {"events": {f"swing_{k}": {"after": f"swing_{k - 1}"} for k in range(1, 7)}, "expect": expect}
    told = [one.reason for one in moments(evidence, actions) if one.decisive]
    assert {"hit", "out", "rest", "swing_6"} <= {*told}
    assert len(told) == 5


def test_pictures_of_a_fast_film_are_a_tenth_of_a_second_of_film_apart() -> None:
    pictures = film(20.0, speed=4.0)
    wanted = [FrameMoment(0.16 * k, f"event {k}") for k in range(1, 40)]
    numbers = [one.frame.k for one in choose_frames(wanted, pictures, 12)]
    assert min(np.diff(numbers)) / 25 >= MIN_INTERVAL


def test_the_only_picture_of_a_shot_stays_although_nothing_moves_in_it() -> None:
    pictures = film(6.0, cameras="aaaaabccccc")
    decided = [FrameMoment(t, f"expect:{t}", (), True) for t in (2.6, 3.4, 3.8, 4.2, 4.6, 5.0, 5.4)]
    wanted = [FrameMoment(3.0, "max of calm"), *decided]
    found = choose_frames(wanted, pictures, 12, moving(pictures, 0.0, 1.0))
    assert "b" in {one.frame.camera for one in found}


@pytest.mark.parametrize(("speed", "count"), [(1.0, 1), (0.1, 2)])
def test_slow_motion_shows_what_is_nearer_to_each_other(speed: float, count: int) -> None:
    step = speed / 25
    pictures = [Frame(k, "main", k * step, 0, k * step, k * step, 0, speed) for k in range(round(2 / step))]
    wanted = [FrameMoment(1.07, "landing"), FrameMoment(1.12, "min of squash")]
    said = [one.reasons for one in choose_frames(wanted, pictures, 12) if one.reasons]
    assert len(said) == count
