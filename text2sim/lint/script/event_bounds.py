"""Bounds on events: which can never happen, and how early others can (`evidence/events.py`).

A contact needs two bodies that can meet: links of one tree do not collide unless `self_collision` is true, and bodies
that the world holds have a limited reach. A threshold has to be crossed: a measure beyond it from the start does not
cross it. A rest and a separation last for their `for`, within the run. The case gives the time of a release.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from text2sim.lint.facts import Facts
from text2sim.lint.motion.reach import LinkReach, never_meet
from text2sim.lint.script.measure_bounds import values_of
from text2sim.lint.script.start_values import depth_inside
from text2sim.lint.script.targets import StartTarget, Targets
from text2sim.spec_schema.models.bodies import Articulated
from text2sim.spec_schema.models.controls import Release, Remove


@dataclass(frozen=True)
class EventBounds:
    """Bounds on an event before the run."""

    never: str = ""
    """Why it cannot happen; empty if it can."""
    earliest: float = 0.0
    """Earliest time [s]."""
    at: tuple[float, ...] | None = None
    """Its times [s], if the case gives them."""


class _Known(dict[str, EventBounds]):
    def __init__(self, facts: Facts) -> None:
        self.facts = facts

    def __missing__(self, name: str) -> EventBounds:
        event = self.facts.case.actions.events[name]
        found = _BOUNDS_BY_KIND[event.kind](self.facts, event) if event.kind in _BOUNDS_BY_KIND else EventBounds()
        if event.after is not None and not found.never:
            first = self[event.after]  # references have no cycles
            if first.never:
                found = EventBounds(f"it comes after `{event.after}`, which cannot happen: {first.never}")
            else:
                times = None
                if found.at is not None and first.at is not None:
                    times = tuple(time for time in found.at if time > first.at[0])
                found = EventBounds("", max(found.earliest, first.earliest), times)
        self[name] = found
        return found


def bounds_of(facts: Facts, name: str) -> EventBounds:
    """Return the bounds on an event of the case."""
    return facts.once(_Known)[name]


def _contact(facts: Facts, event: Any) -> EventBounds:
    if event.kind == "separation" and event.for_ > facts.case.scene.duration:
        duration = facts.case.scene.duration
        return EventBounds(f"it needs {event.for_:g} s without contact, and the run takes {duration:g} s")
    reach, why = facts.once(LinkReach), ""
    for a, b in facts.once(Targets).pairs(event.between) or ():
        why = _why_no_contact(a, b)
        if not why and never_meet(reach.body(a.copy, a.link), reach.body(b.copy, b.link)):
            why = f"their joints and mounts keep `{a.label}` and `{b.label}` apart"
        if not why:
            return EventBounds()
    return EventBounds(why)


def _why_no_contact(a: StartTarget, b: StartTarget) -> str:
    """Return why two links do not collide even where they meet; empty if they do."""
    model = a.copy.model
    if a.copy.name == b.copy.name and isinstance(model, Articulated) and model.links is not None:
        if not model.self_collision:
            return f"links of `{a.copy.body}` pass through each other; set `self_collision: true`"
    elif not (a.moves or b.moves):
        return f"neither `{a.label}` nor `{b.label}` can move"
    return ""


def _threshold(facts: Facts, event: Any) -> EventBounds:
    values = values_of(facts, event.measure)
    if values.frozen:
        return EventBounds(f"`{event.measure}` never changes: {values.frozen}")
    bound = event.above if event.above is not None else event.below
    which, unit = "above" if event.above is not None else "below", f" {values.unit}".rstrip()
    low, high = values.low, values.high
    if event.above is not None and high < bound or event.below is not None and low > bound:
        return EventBounds(f"`{event.measure}` is never {which} {bound:g}{unit}: {values.why}")
    if event.above is not None and low >= bound or event.below is not None and high <= bound:
        return EventBounds(f"`{event.measure}` is always {which} {bound:g}{unit} and never crosses it: {values.why}")
    return EventBounds()


def _rest_bounds(facts: Facts, event: Any) -> EventBounds:
    duration = facts.case.scene.duration
    if event.for_ > duration:
        return EventBounds(f"it needs {event.for_:g} s of rest, and the run takes {duration:g} s")
    return EventBounds()


def _region(facts: Facts, event: Any) -> EventBounds:
    reach = facts.once(LinkReach)
    region = facts.case.scene.domain if event.kind == "left_domain" else event.region
    if region is None or getattr(region, "moves_with", None) is not None:
        return EventBounds()
    for target in facts.once(Targets).select(event.of):
        ball = reach.origin(target.copy, target.link) if target.known and not target.driven else None
        if ball is None:
            return EventBounds()
        depth = depth_inside(region, ball[0])
        outside, inside = depth < -ball[1], depth > ball[1]
        starts_outside = event.kind == "left_domain" and depth_inside(region, target.origin) <= 0.0
        if starts_outside or not (inside or (outside and event.kind != "left_domain")):
            return EventBounds()
    selected = facts.once(Targets).select(event.of)
    if not selected:
        return EventBounds()
    where = "the domain" if event.kind == "left_domain" else "the region"
    return EventBounds(f"the joints or the mount of `{selected[0].label}` let it neither enter nor leave {where}")


def _released(facts: Facts, event: Any) -> EventBounds:
    controls, duration = facts.case.actions.controls.values(), facts.case.scene.duration
    releases = [c for c in controls if isinstance(c, Release) and c.attach == event.attach]
    if any(c.at is None for c in releases):  # when something happens
        return EventBounds()
    return _at_times([c.at for c in releases if c.at is not None], duration, f"`{event.attach}` is released")


def _removed(facts: Facts, event: Any) -> EventBounds:
    control, duration = facts.case.actions.controls.get(event.remove), facts.case.scene.duration
    if not isinstance(control, Remove) or control.on is not None:
        return EventBounds()
    times = [r.at for r in facts.rows.removals if r.control == event.remove and r.at is not None]
    return _at_times(times, duration, f"`{event.remove}` comes")


def _at_times(times: list[float], duration: float, what: str) -> EventBounds:
    """Return the bounds of an event that happens at some times [s] of a run of some duration [s]."""
    during = sorted(time for time in times if time <= duration)
    if not during:
        return EventBounds(f"{what} after the end of the run ({duration:g} s)")
    return EventBounds("", during[0], tuple(during))


_BOUNDS_BY_KIND: dict[str, Callable[[Facts, Any], EventBounds]] = {
    "contact": _contact,
    "separation": _contact,
    "threshold": _threshold,
    "rest": _rest_bounds,
    "enters": _region,
    "leaves": _region,
    "left_domain": _region,
    "released": _released,
    "removed": _removed,
}
