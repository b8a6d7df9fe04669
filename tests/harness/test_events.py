"""Events and touches against recordings in which their times are known."""

import numpy as np
import pytest

from text2sim.evidence.events import _FINDERS, EventLog, find_events
from text2sim.evidence.measures import evaluate
from text2sim.evidence.recorded_case import RecordedCase
from text2sim.evidence.visibility import _moments
from text2sim.spec_schema.models.events import Event
from text2sim.spec_schema.published.language_reference import section_kinds


@pytest.fixture
def look(make_case):
    """Return a function that looks for events in a written run."""

    def find(folder, bodies=("ball", "other"), measures=None, controls=None, scene=None, **events) -> EventLog:
        case = make_case(bodies=bodies, measures=measures or {}, controls=controls or {}, scene=scene, events=events)
        recording = RecordedCase.load(folder, case)
        return find_events(recording, evaluate(recording))

    return find


def times(log: EventLog, name: str = "e") -> list[float]:
    assert log.problems == {}
    return [row["time"] for row in log.occurrences[name]]


@pytest.fixture
def collision(new_run):
    """A ball of 1 kg at 2 m/s hits another and stops: 2 N s from 0.5 s on; later a lighter touch."""
    run = new_run()
    floor, ball, other = run.add_link("floor"), run.add_link("ball"), run.add_link("other")
    assert floor == 0
    run.touch(ball, other, range(50, 54), (50.0, 0, 0), depth=0.003, pos=(0.1, 0.2, 0.3))
    run.touch(ball, other, [80, 81, 84, 85], (1.0, 0, 0))
    return run.write()


def test_an_impact_is_one_touch_with_its_momentum(collision, look):
    first, second = look(collision, e={"kind": "contact", "between": ["ball", "other"]}).occurrences["e"]
    assert first["between"] == ["ball", "other"]
    assert first["time"] == pytest.approx(0.5)
    assert first["end"] == pytest.approx(0.53)
    # What the first was given by the second: the ball loses its momentum.
    assert first["impulse"] == pytest.approx([-2.0, 0, 0])
    assert first["normal_impulse"] == pytest.approx(2.0)
    assert first["impact_impulse"] == pytest.approx(2.0)
    assert first["peak_force"] == pytest.approx(50.0)
    assert first["penetration"] == pytest.approx(0.003)
    assert first["pos"] == pytest.approx([0.1, 0.2, 0.3])
    # Two steps without contact do not end a touch.
    assert (second["time"], second["end"]) == (pytest.approx(0.8), pytest.approx(0.85))
    assert not second["ongoing"]


def test_the_other_way_round_the_momentum_has_the_other_sign(collision, look):
    rows = look(collision, e={"kind": "contact", "between": ["other", "ball"]}).occurrences["e"]
    assert rows[0]["between"] == ["other", "ball"]
    assert rows[0]["impulse"] == pytest.approx([2.0, 0, 0])


def test_light_touches_can_be_ignored(collision, look):
    assert times(look(collision, e={"kind": "contact", "between": ["ball", "other"], "min_impulse": 1.0})) == [0.5]


def test_a_heavy_rest_is_no_impact(new_run, look):
    run = new_run()
    floor, ball = run.add_link("floor"), run.add_link("ball")
    run.touch(floor, ball, range(10, 101), (0, 0, 10.0))
    folder = run.write()
    row = look(folder, e={"kind": "contact", "between": ["ball", "floor"]}).occurrences["e"][0]
    assert row["impulse"] == pytest.approx([0, 0, 9.1])
    assert row["impact_impulse"] == pytest.approx(0.5)
    assert row["ongoing"]
    assert times(look(folder, e={"kind": "contact", "between": ["ball", "floor"], "min_impulse": 1.0})) == []


def test_forces_of_several_links_of_a_body_add_up(new_run, look):
    run = new_run()
    ball = run.add_link("ball")
    hand, arm = run.add_link("other", link="hand"), run.add_link("other", link="arm")
    run.touch(ball, hand, range(10, 20), (3.0, 0, 0), depth=0.001)
    run.touch(ball, arm, range(15, 25), (0, 4.0, 0), depth=0.002)
    folder = run.write()
    whole = look(folder, e={"kind": "contact", "between": ["ball", "other"]}).occurrences["e"]
    assert [(row["time"], row["end"]) for row in whole] == [(pytest.approx(0.1), pytest.approx(0.24))]
    assert whole[0]["impulse"] == pytest.approx([-0.3, -0.4, 0])
    assert whole[0]["peak_force"] == pytest.approx(7.0)
    part = look(folder, e={"kind": "contact", "between": ["ball", "other.arm"]}).occurrences["e"]
    assert part[0]["between"] == ["ball", "other.arm"]
    assert part[0]["impulse"] == pytest.approx([0, -0.4, 0])


def test_copies_that_touch_each_other_are_listed_once(new_run, look):
    run = new_run()
    bricks = [run.add_link(f"brick[{i}]") for i in range(3)]
    run.touch(bricks[0], bricks[1], [10], (1.0, 0, 0))
    run.touch(bricks[1], bricks[2], [20], (1.0, 0, 0))
    log = look(run.write(), bodies=("brick",), e={"kind": "contact", "between": ["brick", "brick"]})
    assert [row["between"] for row in log.occurrences["e"]] == [
        ["brick[0]", "brick[1]"],
        ["brick[1]", "brick[2]"],
    ]


def test_separation_needs_a_while_without_touch(new_run, look):
    run = new_run()
    ball, other = run.add_link("ball"), run.add_link("other")
    run.touch(ball, other, [*range(0, 20), *range(23, 30), *range(60, 70), *range(98, 101)], (1.0, 0, 0))
    folder = run.write()
    between = ["ball", "other"]
    assert times(look(folder, e={"kind": "separation", "between": between})) == pytest.approx([0.29, 0.69])
    assert times(look(folder, e={"kind": "separation", "between": between, "for": 0.03})) == pytest.approx(
        [0.19, 0.29, 0.69]
    )
    assert times(look(folder, e={"kind": "separation", "between": between, "for": 0.5})) == []


def test_a_threshold_is_passed_between_frames_and_anew(new_run, look):
    run = new_run()
    run.add_link("ball", pos=np.outer(np.sin(2 * np.pi * 2 * run.time), [0, 0, 1]))
    height = {"height": {"kind": "position", "of": "ball", "axis": "z"}}
    folder = run.write()
    rising = look(folder, measures=height, e={"kind": "threshold", "measure": "height", "above": 0.5})
    assert times(rising) == pytest.approx([1 / 24, 13 / 24], abs=1e-3)
    falling = look(folder, measures=height, e={"kind": "threshold", "measure": "height", "below": 0.5})
    assert times(falling) == pytest.approx([5 / 24, 17 / 24], abs=1e-3)
    missed = look(folder, measures=height, e={"kind": "threshold", "measure": "height", "above": 1.2})
    assert times(missed) == [] and missed.nearest == {"e": "`height` was at most 0.998 m, at 0.12 s"}


def test_what_is_beyond_a_threshold_from_the_start_has_not_passed_it(new_run, look):
    run = new_run()
    run.add_link("ball", pos=(0, 0, 1))
    measures = {"height": {"kind": "position", "of": "ball", "axis": "z"}}
    log = look(run.write(), measures=measures, e={"kind": "threshold", "measure": "height", "above": 0.5})
    assert times(log) == [] and log.nearest == {"e": "`height` was already above it at 0 s"}


@pytest.fixture
def slowing(new_run):
    """A ball that slows down to rest at 0.5 s, is pushed at 0.7 s, and rests again from 0.75 s on."""
    run = new_run()
    t = run.time
    speed = np.where(t < 0.5, 0.5 - t, 0) + np.where((t >= 0.7) & (t < 0.75), 1.0, 0)
    run.add_link("ball", vel=np.outer(speed, [1, 0, 0]))
    run.add_link("other")
    return run.write()


def test_rest_is_told_from_where_the_quiet_begins(slowing, look):
    found = times(look(slowing, e={"kind": "rest", "of": "ball", "speed": 0.02}))
    assert found == pytest.approx([0.48, 0.75], abs=1e-3)
    assert times(look(slowing, e={"kind": "rest", "of": "ball", "for": 0.24})) == pytest.approx([0.75], abs=1e-3)
    assert times(look(slowing, e={"kind": "rest", "of": "other"})) == [0.0]
    hasty = look(slowing, e={"kind": "rest", "of": "ball", "speed": 0.001, "for": 0.5})
    assert hasty.occurrences["e"] == [] and "slowest at 0.5" in hasty.nearest["e"]
    for names in (["other", "ball"], ["ball", "other"]):
        assert times(look(slowing, e={"kind": "rest", "of": names, "for": 0.24})) == pytest.approx([0.75], abs=1e-3)


def test_after_looks_only_later(slowing, look):
    push = {"kind": "threshold", "measure": "speed", "above": 0.9}
    measures = {"speed": {"kind": "speed", "of": "ball"}}
    log = look(slowing, measures=measures, push=push, e={"kind": "rest", "of": "ball", "after": "push"})
    assert times(log) == pytest.approx([0.75], abs=1e-3)
    # A quiet that lasts through the other event counts from that event on.
    log = look(slowing, measures=measures, push=push, e={"kind": "rest", "of": "other", "after": "push"})
    assert times(log) == [log.first("push")]


def test_after_something_that_never_happened_nothing_happens(collision, look):
    never = {"kind": "contact", "between": ["ball", "floor"]}
    log = look(collision, never=never, e={"kind": "contact", "between": ["ball", "other"], "after": "never"})
    assert times(log) == []


def test_events_that_wait_for_each_other_are_named(collision, look):
    touch = {"kind": "contact", "between": ["ball", "other"]}
    log = look(collision, a={**touch, "after": "b"}, b={**touch, "after": "a"}, c=touch)
    assert set(log.problems) == {"a", "b"}
    assert len(log.occurrences["c"]) == 2


@pytest.mark.parametrize(
    ("region", "inside"),
    [
        ({"kind": "box", "min": [-1, -1, 0.2], "max": [1, 1, 0.6]}, (0.2, 0.6)),
        ({"kind": "sphere", "center": [0, 0, 0.4], "radius": 0.2}, (0.2, 0.6)),
        ({"kind": "cylinder", "center": [0, 0, 0.4], "radius": 1.0, "height": 0.4}, (0.2, 0.6)),
        ({"kind": "cylinder", "center": [0, 0, 0.4], "radius": 0.2, "height": 5.0, "axis": "x"}, (0.2, 0.6)),
    ],
)
def test_regions_are_entered_and_left(new_run, look, region, inside):
    run = new_run()
    run.add_link("ball", pos=np.outer(run.time + 0.003, [0, 0, 1]))
    folder = run.write()
    entered = look(folder, e={"kind": "enters", "of": "ball", "region": region})
    assert times(entered) == pytest.approx([inside[0] - 0.003], abs=1e-4)
    assert entered.occurrences["e"][0]["pos"] == pytest.approx([0, 0, inside[0]], abs=1e-4)
    assert times(look(folder, e={"kind": "leaves", "of": "ball", "region": region})) == pytest.approx(
        [inside[1] - 0.003], abs=1e-4
    )


def test_each_body_of_a_list_enters_leaves_and_comes_to_its_limit(new_run, make_case, look):
    run = new_run()
    for name, speed in (("ball", 1.0), ("other", 2.0)):
        link = run.add_link(name, pos=np.outer(run.time, [0, 0, speed]))
        run.add_joint(name, name, "hinge", q=speed * run.time, limits=(-1.0, 0.6), link=link)
    folder, both = run.write(), {"of": ["ball", "other", "ball"]}
    region = {"kind": "box", "min": [-1, -1, 0.405], "max": [1, 1, 0.805]}
    domain = {"domain": {"min": [-1, -1, -1], "max": [1, 1, 0.905]}}
    for event, wanted in (
        ({"kind": "enters", "region": region}, [("other", 0.2025), ("ball", 0.405)]),
        ({"kind": "leaves", "region": region}, [("other", 0.4025), ("ball", 0.805)]),
        ({"kind": "left_domain"}, [("other", 0.4525), ("ball", 0.905)]),
        ({"kind": "joint_limit"}, [("other", 0.2984), ("ball", 0.5968)]),
    ):
        log = look(folder, scene=domain, e=event | both)
        assert times(log) == pytest.approx([time for _, time in wanted], abs=1e-3)
        assert [row["of"] for row in log.occurrences["e"]] == [name for name, _ in wanted]
    assert [
        moment.bodies for moment in _moments(make_case(bodies=("ball", "other"), events={"e": event | both}), log)
    ] == [("other",)]
    heap = {"high": {"kind": "position", "axis": "z", "of": ["ball", "other"], "stat": "max"}}
    log = look(folder, measures=heap, e={"kind": "threshold", "measure": "high", "above": 1.01})
    assert times(log) == pytest.approx([0.505], abs=1e-3)


def test_a_region_that_a_body_carries_is_left_by_what_stays_behind(new_run, look):
    run = new_run()
    run.add_link("tray", pos=np.outer(run.time, [1, 0, 0]))
    run.add_link("ball")
    region = {"kind": "sphere", "center": [0, 0, 0], "radius": 0.405, "moves_with": "tray"}
    log = look(run.write(), bodies=("tray", "ball"), e={"kind": "leaves", "of": "ball", "region": region})
    assert times(log) == pytest.approx([0.405], abs=1e-4)


def test_leaving_the_domain(new_run, look):
    run = new_run()
    run.add_link("ball", pos=np.outer(run.time, [0, 0, 1]))
    run.add_link("other", pos=(9, 9, 9))
    folder, scene = run.write(), {"domain": {"min": [-1, -1, -1], "max": [1, 1, 0.755]}}
    assert times(look(folder, scene=scene, e={"kind": "left_domain", "of": "ball"})) == pytest.approx([0.755], abs=1e-4)
    assert times(look(folder, scene=scene, e={"kind": "left_domain", "of": "other"})) == [0.0]
    assert "no domain" in look(folder, e={"kind": "left_domain", "of": "ball"}).problems["e"]


def test_a_joint_limit_is_reached_once_however_it_trembles(new_run, look):
    run = new_run()
    run.add_link("drum")
    t = run.time
    q = (
        np.minimum(2 * t, 1.0)
        + np.where((t > 0.55) & (t < 0.65), -0.003 * (np.arange(len(t)) % 2), 0)
        - np.where(t > 0.9, 0.3, 0)
    )
    run.add_joint("drum", "drum", "hinge", q=q, limits=(-1.0, 1.0))
    log = look(run.write(), bodies=("drum",), e={"kind": "joint_limit", "of": "drum"})
    assert times(log) == pytest.approx([0.498], abs=1e-3)
    assert log.occurrences["e"][0]["end"] == "upper"


def test_a_joint_that_starts_at_an_end_has_not_come_there(new_run, look):
    run = new_run()
    run.add_link("flap")
    run.add_joint("flap", "flap", "hinge", q=1.5 * np.sin(np.pi * run.time / run.time[-1]), limits=(0.0, 1.4))
    log = look(run.write(), bodies=("flap",), e={"kind": "joint_limit", "of": "flap"})
    assert [row["end"] for row in log.occurrences["e"]] == ["upper", "lower"]


def test_releases_are_told_if_the_run_reached_them(slowing, look):
    controls = {
        "hold": {"kind": "attach", "body": "ball", "to": "other"},
        "let_go": {"kind": "release", "attach": "hold", "at": 0.4},
        "too_late": {"kind": "release", "attach": "hold", "at": 7.0},
    }
    assert times(look(slowing, controls=controls, e={"kind": "released", "attach": "hold"})) == [0.4]


def test_what_does_not_exist_is_a_problem_and_not_a_crash(collision, look):
    log = look(
        collision,
        nobody={"kind": "contact", "between": ["ball", "ghost"]},
        unknown={"kind": "threshold", "measure": "ghost", "above": 1.0},
        later={"kind": "contact", "between": ["ball", "other"], "after": "ghost"},
    )
    assert "ghost" in log.problems["nobody"]
    assert "ghost" in log.problems["unknown"]
    assert "ghost" in log.problems["later"]


def test_every_kind_has_its_finder():
    of_controls = {"released", "removed", "broken"}
    assert {*_FINDERS, *of_controls} ^ {*section_kinds(Event)} == set()
