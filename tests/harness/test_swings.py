"""Reversals, period and decrement of motion back and forth, against a damped sine."""

from typing import Any

import numpy as np
import pytest

from text2sim.evidence.events import EventLog
from text2sim.evidence.expectations import Ending, Finding, judge_expectations
from text2sim.evidence.measures import Series
from text2sim.evidence.swings import turning_points
from text2sim.spec_schema.models.expectations import Expect

PERIOD, DECREMENT, FRAME = 1.2, 0.3, 0.01
TIME = np.arange(0, 6.0 + FRAME / 2, FRAME)
DAMPED = 0.4 * np.exp(-DECREMENT * TIME / PERIOD) * np.cos(2 * np.pi * TIME / PERIOD)
"""Five periods from the largest deflection [rad]: it turns back every half of one, but not at the start."""


def judge(values: np.ndarray = DAMPED, **expect: Any) -> Finding:
    row = Expect.model_validate({"measure": "angle", "during": "all", "equals": 0, "tolerance": 9, **expect})
    ending = Ending(TIME[-1], TIME[-1], finished=True, stopped=False)
    return judge_expectations({"e": row}, TIME, {"angle": Series("angle", "rad", values)}, EventLog(), ending)[0]


def test_reversals_of_a_damped_sine() -> None:
    # It turns back at 0.492 T + k T / 2, where tan(2 pi t / T) = -decrement / 2 pi; after the tenth, at 4.992 T, it does
    # not change by a swing again.
    assert judge(stat="reversals", swing=0.05).value == 9
    assert judge(stat="reversals", swing=0.05, during=[0, 1.3]).value == 1
    # With the amplitude a = 0.345 then, and r = exp(-decrement / 2), it changes by 0.4 + a = 0.745, then by
    # (1 + r) a r^k = 0.642, 0.553, 0.476.
    assert judge(stat="reversals", swing=0.56).value == 1
    assert judge(stat="reversals", swing=0.54).value == 2


def test_period_and_decrement_of_a_damped_sine() -> None:
    found = judge(stat="period", swing=0.05, equals=PERIOD, tolerance=0.06)
    assert (found.ok, found.unit, found.at) == (True, "s", None)
    assert found.value == pytest.approx(PERIOD, abs=FRAME / 7)  # two turning points, each to half a frame, over 7 spans
    # A frame beside the extreme is lower by (pi dt / T)^2 / 2 of it at most.
    assert judge(stat="decrement", swing=0.05).value == pytest.approx(DECREMENT, abs=0.001)
    assert judge(DAMPED[::-1], stat="decrement", swing=0.05).value == pytest.approx(-DECREMENT, abs=0.001)
    assert judge(np.cos(TIME * 9), stat="decrement", swing=0.05).value == pytest.approx(0, abs=0.001)


def test_what_jitters_does_not_swing() -> None:
    noise = np.random.default_rng(1).uniform(-0.01, 0.01, len(TIME))
    assert judge(noise, stat="reversals", swing=0.05).value == 0
    assert judge(DAMPED + noise, stat="reversals", swing=0.05).value == 9
    assert judge(TIME, stat="reversals", swing=0.05).value == 0


def test_turning_points_of_a_zigzag() -> None:
    # Up to 3, down to 1, up by less than the swing, down to 0, up: it turns at 3 and at 0, and the ends do not count.
    assert turning_points(np.array([0.0, 3, 1, 1.5, 0, 2]), 1.0) == [1, 4]
    assert turning_points(np.array([0.0, 3, 1, 1.5, 0, 2]), 0.5) == [1, 2, 3, 4]
    assert turning_points(np.array([]), 1.0) == []


def test_too_few_swings_decide_nothing_but_are_said() -> None:
    found = judge(TIME, stat="period", swing=0.05)
    assert (found.ok, found.value, found.why) == (False, None, "it turned back 0 times, and a period needs 3")
    found = judge(np.where(TIME > 3, np.nan, DAMPED), stat="reversals", swing=0.05)
    assert (found.ok, found.why) == (False, "it has no value at some time")


def test_findings_are_said_in_words_with_the_unit_of_each() -> None:
    found = judge(stat="period", swing=0.05, equals=1.0, tolerance=0.1)
    assert found.wanted == "period of `angle` by swings of at least 0.05 rad within 0.1 s of 1 s all the time"
    assert found.why == "period was 1.2 s; it turned back 9 times"
    assert judge(stat="reversals", swing=0.05).wanted.endswith("at least 0.05 rad within 9 of 0 all the time")


@pytest.mark.parametrize("fields", [{"stat": "period"}, {"stat": "max", "swing": 0.1}, {"swing": 0.1}])
def test_swings_need_to_be_told_from_jitter(fields: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="swing, the smallest change that counts"):
        judge(**fields)
