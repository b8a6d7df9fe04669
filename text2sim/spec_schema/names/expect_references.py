"""Checks of the events, measures and times of expectations."""

from text2sim.spec_schema.models.base import span_of
from text2sim.spec_schema.models.expectations import Expect
from text2sim.spec_schema.names.event_references import check_tested_measure
from text2sim.spec_schema.names.name_table import NameTable
from text2sim.spec_schema.text.document import Path


def check_expectations(table: NameTable) -> None:
    """Check every expectation."""
    for name, expect in table.loaded.case.actions.expect.items():
        where: Path = ("actions", "expect", name)
        events = table.loaded.case.actions.events
        for field in ("event", "before", "on"):
            table.check_known((*where, field), "event", getattr(expect, field), events)
        if expect.event is not None:
            _check_event(table, where, expect)
        elif expect.measure is not None:
            check_tested_measure(table, (*where, "measure"), expect.measure, "warning")
            _check_values(table, where, expect)


def _check_event(table: NameTable, where: Path, expect: Expect) -> None:
    duration = table.loaded.case.scene.duration
    if expect.before is not None and expect.before == expect.event:
        table.report((*where, "before"), "an event cannot come before itself", "impossible")
    if expect.within is not None and expect.within[0] > duration:
        table.report((*where, "within"), f"starts after the end of the run ({duration:g} s)", "after-end")
    if isinstance(expect.count, tuple) and expect.count[1] < expect.count[0]:
        table.report((*where, "count"), "the second number must not be smaller than the first", "impossible")
    least = expect.count[1] if isinstance(expect.count, tuple) else expect.count
    if least is not None and least < 0:
        table.report((*where, "count"), "an event cannot happen less than 0 times", "impossible")


def _check_values(table: NameTable, where: Path, expect: Expect) -> None:
    """Check the times and bounds of the values of a measure."""
    duration = table.loaded.case.scene.duration
    if isinstance(expect.at, float) and expect.at > duration:
        table.report((*where, "at"), f"is after the end of the run ({duration:g} s)", "after-end")
    window = expect.during if isinstance(expect.during, tuple) else None
    if max(span_of(window, duration)) > duration:
        table.report((*where, "during"), f"lasts beyond the end of the run ({duration:g} s)", "after-end")
    low, high = _bounds(expect)
    if low >= high:
        table.report(where, f"no value is above {low:g} and below {high:g}", "impossible", key=True)


def _bounds(expect: Expect) -> tuple[float, float]:
    """Return the open interval of allowed values."""
    low = expect.above if expect.above is not None else float("-inf")
    high = expect.below if expect.below is not None else float("inf")
    if expect.equals is not None and expect.tolerance is not None:
        low, high = max(low, expect.equals - expect.tolerance), min(high, expect.equals + expect.tolerance)
    return low, high
