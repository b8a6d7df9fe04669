"""Measures that never change and events that cannot happen, from `measure_bounds` and `event_bounds`."""

from collections.abc import Iterator

from text2sim.lint.facts import Facts
from text2sim.lint.rule import Rule
from text2sim.lint.script.event_bounds import bounds_of
from text2sim.lint.script.measure_bounds import subjects, values_of
from text2sim.lint.script.outcomes import count_bounds
from text2sim.spec_schema.errors import Problem

STATIC_MEASURES = ("position", "extent")
"""Measures that statics may have, as a reference."""


def _dead_measures(facts: Facts) -> Iterator[Problem]:
    actions = facts.case.actions
    for name, measure in actions.measures.items():
        values = values_of(facts, name)
        if not values.frozen:
            continue
        if measure.kind in STATIC_MEASURES and all(facts.mount(t.copy) == "static" for t in subjects(facts, measure)):
            continue
        users = [f"`{key}`" for key, expect in actions.expect.items() if expect.measure == name]
        users += [f"`{key}`" for key, event in actions.events.items() if getattr(event, "measure", None) == name]
        then = f", so {', '.join(users[:3])} would test nothing" if users else ""
        always = f" (it stays {values.start:.4g}{f' {values.unit}'.rstrip()})" if values.start is not None else ""
        text = f"`{name}` never changes{always}: {values.frozen}{then}; measure something that moves"
        key = "between" if measure.kind == "distance" else "of"
        yield facts.problem("dead-measure", ("actions", "measures", name, key), text)


def _dead_events(facts: Facts) -> Iterator[Problem]:
    actions = facts.case.actions
    for name, event in actions.events.items():
        why = bounds_of(facts, name).never
        measure = getattr(event, "measure", None)
        if not why or (measure in actions.measures and values_of(facts, str(measure)).frozen):
            continue  # `dead-measure` reports the measure
        waits = [
            key
            for key, expect in actions.expect.items()
            if name in (expect.event, expect.before, expect.on) and count_bounds(expect)[1] > 0
        ]
        quiet = [key for key, expect in actions.expect.items() if expect.event == name and key not in waits]
        then = f"; `{waits[0]}` cannot hold" if waits else f"; `{quiet[0]}` cannot fail" if quiet else ""
        severity = "error" if waits else "warning"
        text = f"`{name}` cannot happen: {why}{then}"
        yield facts.problem("dead-event", ("actions", "events", name), text, key=True, severity=severity)


_ARM = """\
bodies:
  arm:
    kind: articulated
    pose: {pos: [0, 0, 0.5]}
    links:
      stand: {shape: {kind: box, size: [0.1, 0.1, 0.1]}}
      beam:
        parent: stand
        shape: {kind: box, size: [0.4, 0.04, 0.04]}
        pose: {pos: [0.25, 0, 0.1]}
        joint: {kind: hinge, axis: y, anchor: [-0.2, 0, 0], actuator: {stiffness: 2000, damping: 60}}
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.05}, pose: {pos: [2, 0, 0.05]}}
actions:
  controls:
    lift: {kind: drive, joint: arm.beam, position: {kind: ramp, to: -1, start: 0, end: 1}}
"""
_TIP = "  measures:\n    rise: {kind: displacement, of: %s, axis: z}\n"
_HIT = "  events:\n    hit: {kind: contact, between: [arm.beam, post]}\n  expect:\n    hits: {event: hit}\n"
_POST = "scene: {statics: {post: {shape: {kind: box, size: [0.1, 0.1, 1]}, pose: {pos: [%s, 0, 0.5]}}}}\n"

RULES = (
    Rule(
        id="dead-measure",
        title="A measure never changes.",
        reason="""\
Position, displacement, tilt and rotation of a body are those of its root link. For an articulated body with a fixed
base they never change, nor does any measure of a fixed body. A joint's force is that of its motor, which is zero
without a drive.""",
        remedy="Measure a link that moves (`arm.hand`), or another body.",
        example=_ARM + _TIP % "arm",
        fix=_ARM + _TIP % "arm.beam",
        run=_dead_measures,
    ),
    Rule(
        id="dead-event",
        severity="error",
        title="An event can never happen.",
        reason="""\
Two bodies that their joints keep apart never touch, links of one body do not collide unless `self_collision` is true,
and a measure never crosses a threshold outside its possible values. It is an error if an expectation requires such an
event, and a warning otherwise.""",
        remedy="Check the selectors, the positions of the bodies, and the bound.",
        example=_POST % 3 + _ARM + _HIT,
        fix=_POST % 0.4 + _ARM + _HIT,
        run=_dead_events,
    ),
)
