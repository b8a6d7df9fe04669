"""Expectations: every form, fulfilled and missed, and what a run that ended early leaves open."""

import numpy as np
import pytest

from text2sim.evidence.events import EventLog
from text2sim.evidence.expectations import Ending, Finding, judge_expectations
from text2sim.evidence.measures import Series
from text2sim.spec_schema.models.expectations import Expect

TIME = np.linspace(0, 1, 101)
FINISHED = Ending(1.0, 1.0, finished=True, stopped=False)
DIVERGED = Ending(0.6, 1.0, finished=False, stopped=False)
STOPPED = Ending(0.6, 1.0, finished=False, stopped=True)


def events(**times: list[float]) -> EventLog:
    rows = {name: [{"name": name, "kind": "contact", "time": t} for t in row] for name, row in times.items()}
    return EventLog(rows)


LOG = events(hit=[0.2, 0.5], miss=[], late=[0.9])
EARLY = events(hit=[0.2, 0.5], miss=[], late=[])


def judge(ending: Ending = FINISHED, log: EventLog | None = None, **expect) -> Finding:
    time = TIME[TIME <= ending.end + 1e-9]
    series = {
        "ramp": Series("ramp", "m", 10 * time),
        "hat": Series("hat", "m", 1 - np.abs(time - 0.5)),
        "broken": Series("broken", "m", np.where(time > 0.3, np.nan, 1.0)),
        "ghost": Series("ghost", "m", np.full(len(time), np.nan), "`ghost` was not recorded"),
    }
    log = log or (LOG if ending.finished else EARLY)
    return judge_expectations({"e": Expect.model_validate(expect)}, time, series, log, ending)[0]


@pytest.mark.parametrize(
    ("expect", "ok"),
    [
        ({"event": "hit"}, True),
        ({"event": "miss"}, False),
        ({"event": "hit", "within": [0.1, 0.3]}, True),
        ({"event": "hit", "within": [0.3, 0.6]}, False),  # the first time counts, not the second
        ({"event": "miss", "never": True}, True),
        ({"event": "hit", "never": True}, False),
        ({"event": "hit", "never": True, "within": [0.6, 1.0]}, True),
        ({"event": "hit", "never": True, "within": [0.4, 1.0]}, False),
        ({"event": "hit", "count": 2}, True),
        ({"event": "hit", "count": 1}, False),
        ({"event": "hit", "count": [1, 3]}, True),
        ({"event": "hit", "count": [3, 9]}, False),
        ({"event": "miss", "count": 0}, True),
        ({"event": "hit", "before": "late"}, True),
        ({"event": "late", "before": "hit"}, False),
        ({"event": "hit", "before": "miss"}, False),
        ({"event": "hit", "count": 2, "within": [0.1, 0.3], "before": "late"}, True),
        ({"event": "unheard_of"}, False),
        ({"event": "late", "on": "hit", "within": [0.6, 0.8]}, True),  # 0.9 s is 0.7 s after 0.2 s
        ({"event": "late", "on": "hit", "within": [0, 0.6]}, False),
        ({"event": "hit", "on": "late", "within": [0, "end"]}, False),  # its first time is earlier
        ({"event": "late", "on": "hit", "within": [0, 0.6], "never": True}, True),
        ({"event": "late", "on": "miss", "within": [0, 0.6], "never": True}, False),  # nothing to count from
        ({"measure": "ramp", "on": "hit", "at": 0.3, "equals": 5, "tolerance": 1e-6}, True),
        ({"measure": "ramp", "on": "hit", "during": [0, "end"], "above": 1.99}, True),
        ({"measure": "ramp", "on": "hit", "during": [0, 0.1], "stat": "max", "below": 3.01}, True),
        ({"measure": "ramp", "on": "hit", "during": [0, 0.1], "stat": "max", "below": 2.99}, False),
        ({"measure": "ramp", "on": "late", "at": 0.3, "above": 0}, False),  # the run is over by then
        ({"measure": "ramp", "on": "miss", "at": 0, "above": -1}, False),
        ({"measure": "ramp", "at": 0.505, "equals": 5.05, "tolerance": 1e-6}, True),  # between two frames
        ({"measure": "ramp", "at": 0.5, "above": 4.9, "below": 5.1}, True),
        ({"measure": "ramp", "at": 0.5, "above": 5.1}, False),
        ({"measure": "ramp", "at": "start", "equals": 0.0, "tolerance": 1e-9}, True),
        ({"measure": "ramp", "at": "end", "above": 9.99}, True),
        ({"measure": "ramp", "at": 1.2, "above": 1.0}, False),  # later than the run
        ({"measure": "ramp", "during": "all", "below": 10.1}, True),
        ({"measure": "ramp", "during": [0.2, 0.4], "above": 1.99, "below": 4.01}, True),
        ({"measure": "ramp", "during": [0.2, 0.4], "above": 2.5}, False),
        ({"measure": "hat", "during": [0.495, 0.505], "above": 0.994}, True),
        ({"measure": "hat", "during": "all", "stat": "max", "above": 0.99}, True),
        ({"measure": "hat", "during": "all", "stat": "mean", "equals": 0.75, "tolerance": 1e-6}, True),
        ({"measure": "hat", "during": "all", "stat": "range", "equals": 0.5, "tolerance": 1e-6}, True),
        ({"measure": "hat", "during": [0.2, 0.6], "stat": "change", "equals": 0.2, "tolerance": 1e-6}, True),
        ({"measure": "hat", "during": [0.5, "end"], "stat": "change", "above": 0}, False),
        ({"measure": "ramp", "on": "hit", "during": [0, 0.1], "stat": "change", "equals": 1, "tolerance": 1e-6}, True),
        ({"measure": "hat", "during": "all", "stat": "min", "below": 0.4}, False),
        # hat - 0.75 goes evenly from -1/4 to 1/4: its standard deviation is 1/2 over sqrt(12).
        ({"measure": "hat", "during": "all", "stat": "std", "equals": 0.5 / 12**0.5, "tolerance": 2e-4}, True),
        ({"measure": "hat", "during": [0.5, "end"], "stat": "max", "above": 0.99}, True),
        ({"measure": "hat", "during": [0.6, "end"], "stat": "max", "above": 0.91}, False),
        ({"event": "late", "within": [0.8, "end"]}, True),
        ({"event": "hit", "within": [0.8, "end"]}, False),
        ({"measure": "broken", "at": 0.5, "below": 2.0}, False),
        ({"measure": "broken", "during": "all", "below": 2.0}, False),
        ({"measure": "ghost", "at": 0.5, "below": 2.0}, False),
        ({"measure": "unheard_of", "at": 0.5, "below": 2.0}, False),
    ],
)
def test_of_a_finished_run(expect, ok):
    finding = judge(**expect)
    assert finding.ok is ok, finding.why


@pytest.mark.parametrize(
    ("expect", "ok"),
    [
        ({"event": "hit"}, True),
        ({"event": "hit", "within": [0.1, 0.3]}, True),
        ({"event": "hit", "within": [0.3, 0.6]}, False),
        ({"event": "hit", "never": True}, False),
        ({"event": "hit", "count": 1}, False),
        ({"event": "hit", "count": [1, 2]}, None),
        ({"event": "miss"}, None),
        ({"event": "miss", "within": [0.0, 0.5]}, False),
        ({"event": "miss", "never": True}, None),
        ({"event": "miss", "never": True, "within": [0.0, 0.5]}, True),
        ({"event": "hit", "before": "late"}, None),
        ({"measure": "ramp", "at": 0.5, "above": 4.9}, True),
        ({"measure": "ramp", "at": 0.7, "above": 0.0}, None),
        ({"measure": "ramp", "on": "hit", "at": 0.5, "above": 0.0}, None),
        ({"measure": "ramp", "on": "late", "at": 0.0, "above": 0.0}, None),
        ({"measure": "ramp", "at": "end", "above": 0.0}, None),
        ({"measure": "ramp", "during": [0.1, 0.5], "above": 0.9}, True),
        ({"measure": "ramp", "during": "all", "above": -1.0}, None),
        ({"measure": "ramp", "during": "all", "below": 5.0}, False),
        ({"measure": "ramp", "during": [0.7, 0.8], "above": 0.0}, None),
        ({"measure": "ramp", "during": [0.2, "end"], "above": 0.0}, None),
        ({"measure": "ramp", "during": "all", "stat": "max", "above": 0.1}, None),
    ],
)
def test_of_a_run_that_ended_early(expect, ok):
    """`ok` is for a run that someone stopped; for one that failed by itself, what is open is missed."""
    stopped, failed = judge(STOPPED, **expect), judge(DIVERGED, **expect)
    assert stopped.ok is ok, stopped.why
    assert failed.ok is bool(ok), failed.why
    if ok is None:
        assert "the run ended at 0.6 s" in failed.why


@pytest.mark.parametrize(
    ("expect", "wanted", "why"),
    [
        (
            {"event": "hit", "within": [0.1, 0.3]},
            "`hit` happens first from 0.1 s to 0.3 s",
            "first happened at 0.2 s, 2 times in all",
        ),
        ({"event": "miss", "never": True}, "`miss` never happens", "never happened"),
        (
            {"event": "hit", "count": [1, 3], "before": "late"},
            "`hit` happens 1 to 3 times, before `late`",
            "happened 2 times, first at 0.2 s; `late` at 0.9 s",
        ),
        ({"measure": "ramp", "at": 0.5, "above": 2}, "`ramp` above 2 m at 0.5 s", "5 m at 0.5 s"),
        (
            {"measure": "ramp", "at": "end", "equals": 3, "tolerance": 0.1},
            "`ramp` within 0.1 m of 3 m at the end",
            "10 m at 1 s",
        ),
        (
            {"measure": "hat", "during": "all", "stat": "mean", "below": 1},
            "mean of `hat` below 1 m all the time",
            "mean was 0.75 m",
        ),
        (
            {"measure": "hat", "during": [0.2, 0.4], "above": 1},
            "`hat` above 1 m from 0.2 s to 0.4 s",
            "at worst 0.7 m at 0.2 s",
        ),
        (
            {"measure": "ramp", "on": "hit", "at": 0.3, "above": 2},
            "`ramp` above 2 m at 0.3 s after `hit`",
            "5 m at 0.5 s; `hit` at 0.2 s",
        ),
        (
            {"measure": "ramp", "on": "hit", "during": [0.1, "end"], "above": 2},
            "`ramp` above 2 m from 0.1 s after `hit` to the end",
            "at worst 3 m at 0.3 s; `hit` at 0.2 s",
        ),
        (
            {"event": "late", "on": "miss", "within": [0, 0.5]},
            "`late` happens first from 0 s to 0.5 s after `miss`",
            "`miss` never happened",
        ),
    ],
)
def test_findings_are_said_in_words(expect, wanted, why):
    finding = judge(**expect)
    assert (finding.wanted, finding.why) == (wanted, why)


def test_a_finished_run_ends_on_its_last_whole_step():
    ending = Ending(0.99, 1.0, finished=True, stopped=False)
    assert judge(ending, measure="ramp", at=1.0, above=9.0).ok is True
    assert judge(ending, measure="ramp", during="all", above=-1.0).ok is True
