"""Expectations: evaluation of each against measures and events."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from text2sim.evidence.events import EventLog
from text2sim.evidence.measures import Series
from text2sim.evidence.swings import judge_swings
from text2sim.recording.states import Array
from text2sim.spec_schema.models.base import span_of
from text2sim.spec_schema.models.expectations import CHANGE, SWINGS, Expect

ROUNDING = 1e-9
"""Times [s] nearer than this are equal: a frame's time is a sum of steps."""


@dataclass(frozen=True)
class Ending:
    """End of a run, as far as expectations depend on it."""

    end: float
    """Last recorded time [s]."""
    duration: float
    """Time [s] that the case asks for."""
    finished: bool
    """Whether it ran to its end."""
    stopped: bool
    """Whether someone stopped it: what it did not reach is open, not false."""

    def reached(self, time: float) -> bool:
        """Whether a time was recorded. A finished run ends on the last whole step before its duration."""
        return time <= self.end + ROUNDING or (self.finished and time <= self.duration + ROUNDING)


@dataclass(frozen=True)
class Finding:
    """Result of an expectation."""

    name: str
    ok: bool | None
    """None if the run was stopped before this was decided."""
    value: float | None
    """What was found: a time [s] or a number of times of an event, or a value of a measure."""
    unit: str
    wanted: str
    """What was asked for, in words."""
    why: str
    """What was found, in words."""
    at: float | None = None
    """When it was decided [s]: the event's first time, the time asked for, or that of the worst value or extreme."""


def judge_expectations(
    expect: Mapping[str, Expect], time: Array, series: Mapping[str, Series], events: EventLog, ending: Ending
) -> list[Finding]:
    """Judge every expectation, in the order of the case.

    Args:
        expect: By name.
        time: Of the frames [s], shape (F,).
        series: Measures by name.
        events: What happened.
        ending: How the run ended.
    """
    judge = _Judge(time, series, events, ending)
    return [judge.judge(name, row) for name, row in expect.items()]


@dataclass(frozen=True)
class _Judge:
    time: Array
    series: Mapping[str, Series]
    events: EventLog
    ending: Ending

    def judge(self, name: str, expect: Expect) -> Finding:
        if expect.on is None:
            return self._judge_from_start(name, expect)
        start = self.events.first(expect.on)
        series = self.series.get(expect.measure or "")
        own = series.unit if series is not None else ""
        unit = "s" if expect.event is not None else unit_of(expect, own)
        wanted = wanted_of_event(expect) if expect.event is not None else wanted_of_measure(expect, own)
        if start is None:
            ok, why = False, f"`{expect.on}` {self._never(expect.on)}"
            if not self.ending.finished:
                ok, _, why = self._unreached(f"and `{expect.on}` had not happened")
            return Finding(name, ok, None, unit, wanted, why)
        found = self._judge_from_start(name, shifted_to(expect, start))
        return replace(found, wanted=wanted, why=f"{found.why}; `{expect.on}` at {start:.4g} s")

    def _judge_from_start(self, name: str, expect: Expect) -> Finding:
        if expect.event is not None:
            wanted, unit = wanted_of_event(expect), "s" if expect.count is None and not expect.never else ""
            if expect.event not in self.events.occurrences:
                return Finding(name, False, None, unit, wanted, f"there is no event `{expect.event}`")
            if expect.event in self.events.problems:
                return Finding(name, False, None, unit, wanted, self.events.problems[expect.event])
            ok, value, why = self._judge_never(expect) if expect.never else self._judge_event(expect)
            return Finding(name, ok, value, unit, wanted, why, self.events.first(expect.event))
        series = self.series.get(expect.measure or "")
        own = series.unit if series else ""
        unit, wanted = unit_of(expect, own), wanted_of_measure(expect, own)
        if series is None or series.problem:
            why = series.problem if series else f"there is no measure `{expect.measure}`"
            return Finding(name, False, None, unit, wanted, why)
        ok, value, why = self._judge_at(expect, series) if expect.at is not None else self._judge_during(expect, series)
        at = None if value is None else self._decisive_time(expect, series)
        why += f" at {at:.4g} s" if at is not None and expect.stat in ("max", "min") else ""
        return Finding(name, ok, value, unit, wanted, why, at)

    def _decisive_time(self, expect: Expect, series: Series) -> float | None:
        """Return the time [s] of the decisive value; None if no single one decides."""
        if expect.at is not None:
            return moment(expect.at, self.time)
        if expect.stat in ("mean", "std", *SWINGS):
            return None
        time, values = self._clipped(*span_of(_given_window(expect), self.ending.duration), series.values)
        if expect.stat == CHANGE:
            return float(time[-1])
        worst, least = -_margin(expect, values), -values
        scores = {None: [worst], "min": [least], "range": [values, least]}.get(expect.stat, [values])
        return max(float(time[np.argmax(np.where(np.isnan(score), -np.inf, score))]) for score in scores)

    def _unreached(self, what: str) -> tuple[bool | None, None, str]:
        why = f"not reached: the run ended at {self.ending.end:.4g} s, {what}"
        return None if self.ending.stopped else False, None, why

    # --- events ---

    def _judge_never(self, expect: Expect) -> tuple[bool | None, float | None, str]:
        first, last = span_of(expect.within, self.ending.duration)
        times = [row["time"] for row in self.events.occurrences[expect.event or ""]]
        inside = [t for t in times if first - ROUNDING <= t <= last + ROUNDING or (expect.within is None)]
        if inside:
            return False, float(len(inside)), f"happened at {inside[0]:.4g} s{_times_in_all(inside)}"
        if not self.ending.finished and not self.ending.reached(last):
            return self._unreached("and it could still have happened")
        outside = expect.within is not None and times
        return True, 0.0, f"happened only outside, first at {times[0]:.4g} s" if outside else "never happened"

    def _judge_event(self, expect: Expect) -> tuple[bool | None, float | None, str]:
        times = [row["time"] for row in self.events.occurrences[expect.event or ""]]
        first = times[0] if times else None
        value = float(len(times)) if expect.count is not None else first
        finding = self._never(expect.event)
        if first is not None:
            finding = f"first happened at {first:.4g} s{_times_in_all(times)}"
        open_end = not self.ending.finished
        if first is None and (expect.count is None or _count_range(expect.count)[0] > 0):
            _, until = span_of(expect.within, self.ending.duration)
            if open_end and not self.ending.reached(until):
                return self._unreached("and it had not happened")
            return False, value, finding
        if (
            expect.within is not None
            and first is not None
            and not self._inside(first, span_of(expect.within, self.ending.duration))
        ):
            return False, value, finding
        if expect.count is not None:
            low, high = _count_range(expect.count)
            finding = f"happened {len(times)} times" + (f", first at {first:.4g} s" if first is not None else "")
            if len(times) > high:
                return False, value, finding
            if open_end and (len(times) < low or high < float("inf")):
                finding = f"{finding}; the run ended at {self.ending.end:.4g} s"
                return None if self.ending.stopped else False, value, finding
            if len(times) < low:
                return False, value, finding
        if expect.before is not None:
            other = self.events.first(expect.before)
            if other is None:
                if open_end:
                    return self._unreached(f"and `{expect.before}` had not happened")
                return False, value, f"{finding}; `{expect.before}` {self._never(expect.before)}"
            finding = f"{finding}; `{expect.before}` at {other:.4g} s"
            return first is not None and first < other, value, finding
        return True, value, finding

    def _never(self, event: str | None) -> str:
        near = self.events.nearest.get(event or "")
        return f"never happened ({near})" if near else "never happened"

    @staticmethod
    def _inside(time: float, window: tuple[float, float]) -> bool:
        return window[0] - ROUNDING <= time <= window[1] + ROUNDING

    # --- measures ---

    def _judge_at(self, expect: Expect, series: Series) -> tuple[bool | None, float | None, str]:
        if not len(self.time):
            return self._unreached("before its first frame")
        if expect.at == "end" and not self.ending.finished:
            return self._unreached("before its end")
        at = moment(expect.at, self.time)
        if not self.ending.reached(at):
            return self._unreached(f"before {at:.4g} s")
        value = float(np.interp(at, self.time, series.values))
        return _in_bounds(expect, value), _finite(value), f"{_quantity(value, series.unit)} at {at:.4g} s"

    def _judge_during(self, expect: Expect, series: Series) -> tuple[bool | None, float | None, str]:
        first, last = span_of(_given_window(expect), self.ending.duration)
        if not len(self.time) or first > self.ending.end + ROUNDING and not self.ending.finished:
            return self._unreached(f"before {first:.4g} s")
        time, values = self._clipped(first, last, series.values)
        whole = self.ending.reached(last)
        if expect.stat is not None:
            if not whole:
                return self._unreached(f"before {last:.4g} s")
            if expect.swing is not None:
                value, why = judge_swings(expect.stat, time, values, expect.swing)
                return _in_bounds(expect, value), _finite(value), why
            value = _statistic(expect.stat, time, values)
            return _in_bounds(expect, value), _finite(value), f"{expect.stat} was {_quantity(value, series.unit)}"
        margins = _margin(expect, values)
        worst = int(np.argmin(np.where(np.isnan(margins), -np.inf, margins)))
        value = float(values[worst])
        finding = f"at worst {_quantity(value, series.unit)} at {time[worst]:.4g} s"
        if not _in_bounds(expect, value):
            return False, _finite(value), finding
        if not whole:
            finding = f"{finding}; the run ended at {self.ending.end:.4g} s"
            return None if self.ending.stopped else False, _finite(value), finding
        return True, _finite(value), finding

    def _clipped(self, first: float, last: float, values: Array) -> tuple[Array, Array]:
        """Return the frames of a span, with its two ends interpolated."""
        first, last = max(first, float(self.time[0])), min(last, float(self.time[-1]))
        first = min(first, last)
        inner = (self.time > first + ROUNDING) & (self.time < last - ROUNDING)
        ends = np.array([first, last])
        left, right = np.interp(ends, self.time, values)
        return np.concatenate([[first], self.time[inner], [last]]), np.concatenate([[left], values[inner], [right]])


def shifted_to(expect: Expect, start: float) -> Expect:
    """Return an expectation with `on`, which happened at `start` [s], with times from the start of the run."""

    def later(window: tuple[float, float | str]) -> tuple[float, float | str]:
        return window[0] + start, window[1] if isinstance(window[1], str) else window[1] + start

    update: dict[str, Any] = {"on": None}
    if expect.within is not None:
        update["within"] = later(expect.within)
    if isinstance(expect.at, float):
        update["at"] = expect.at + start
    if isinstance(expect.during, tuple):
        update["during"] = later(expect.during)
    return expect.model_copy(update=update)


def moment(at: float | str | None, time: Array) -> float:
    """Return the time [s] of `at`: a number, or the `start` or `end` of the recording."""
    if isinstance(at, str):
        return float(time[0] if at == "start" else time[-1])
    return at or 0.0


def _statistic(stat: str, time: Array, values: Array) -> float:
    if stat == "mean":
        span = time[-1] - time[0]
        return float(np.trapezoid(values, time) / span) if span > 0 else float(values.mean())
    if stat == CHANGE:
        return float(values[-1] - values[0])
    if stat == "std":
        return float(np.sqrt(_statistic("mean", time, (values - _statistic("mean", time, values)) ** 2)))
    return float({"max": values.max, "min": values.min, "range": lambda: values.max() - values.min()}[stat]())


def _margin(expect: Expect, values: Array) -> Array:
    """Return the margin of values to the nearest bound; negative where one is violated."""
    margin = np.full(np.shape(values), np.inf)
    if expect.above is not None:
        margin = np.minimum(margin, values - expect.above)
    if expect.below is not None:
        margin = np.minimum(margin, expect.below - values)
    if expect.equals is not None and expect.tolerance is not None:
        margin = np.minimum(margin, expect.tolerance - np.abs(values - expect.equals))
    return margin


def _in_bounds(expect: Expect, value: float) -> bool:
    return bool(
        np.isfinite(value)
        and (expect.above is None or value > expect.above)
        and (expect.below is None or value < expect.below)
        and (expect.equals is None or abs(value - expect.equals) <= (expect.tolerance or 0.0))
    )


def _count_range(count: tuple[int, int] | int) -> tuple[int, float]:
    return (count, count) if isinstance(count, int) else count


def unit_of(expect: Expect, unit: str) -> str:
    """Return the unit of what an expectation bounds, for a measure in `unit`."""
    return "s" if expect.stat == "period" else "" if expect.stat in SWINGS else unit


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def _quantity(value: float, unit: str) -> str:
    return f"{value:.4g} {unit}".rstrip() if np.isfinite(value) else "not a finite number"


def _times_in_all(times: list[float]) -> str:
    return f", {len(times)} times in all" if len(times) > 1 else ""


def _given_window(expect: Expect) -> tuple[float, float | str] | None:
    return expect.during if isinstance(expect.during, tuple) else None


def _span_text(window: tuple[float, float | str], on: str | None) -> str:
    first, last = window
    after = "" if on is None else f" after `{on}`"
    return f"from {first:g} s{after} to the end" if isinstance(last, str) else f"from {first:g} s to {last:g} s{after}"


def wanted_of_event(expect: Expect) -> str:
    """Describe what is expected of an event."""
    span = _span_text(expect.within, expect.on) if expect.within else ""
    if expect.never:
        return f"`{expect.event}` never happens {span}".rstrip()
    words = [f"`{expect.event}` happens"]
    if expect.count is not None:
        low, high = _count_range(expect.count)
        words.append(f"{low} times" if low == high else f"{low} to {high:g} times")
    if span:
        words.append(f"first {span}")
    if expect.before is not None:
        words.append(f"before `{expect.before}`")
    return f"{words[0]} {', '.join(words[1:])}".rstrip()


def wanted_of_measure(expect: Expect, unit: str) -> str:
    """Describe what is expected of a measure."""
    own = unit_of(expect, unit)
    bounds = [
        f"{word} {_quantity(v, own)}" for word, v in (("above", expect.above), ("below", expect.below)) if v is not None
    ]
    if expect.equals is not None:
        bounds.append(f"within {_quantity(expect.tolerance or 0.0, own)} of {_quantity(expect.equals, own)}")
    subject = f"`{expect.measure}`" if expect.stat is None else f"{expect.stat} of `{expect.measure}`"
    subject += f" by swings of at least {_quantity(expect.swing, unit)}" if expect.swing is not None else ""
    if expect.at is not None:
        when = f"at the {expect.at}" if isinstance(expect.at, str) else f"at {expect.at:g} s"
        when += f" after `{expect.on}`" if expect.on is not None else ""
    else:
        span = _given_window(expect)
        when = _span_text(span, expect.on) if span else "all the time"
    return f"{subject} {' and '.join(bounds)} {when}"
