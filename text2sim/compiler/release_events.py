"""Events on which something is released, as functions of the program, which must detect them while it runs.

`evidence/events.py` finds them in the recording by the same rules, so that both agree.
"""

from collections.abc import Iterable

from text2sim.compiler.action_rows import Watch
from text2sim.compiler.literal import Code, identifier, literal
from text2sim.compiler.placing.placement import Copy
from text2sim.compiler.selection import select
from text2sim.compiler.shapes.regions import RegionError
from text2sim.compiler.shapes.rotation import vector_unit
from text2sim.compiler.soft.controls import SoftControls
from text2sim.compiler.soft.solvers import contact_model, is_soft
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.models import events, measures
from text2sim.spec_schema.models.actions import Actions
from text2sim.spec_schema.models.base import listed
from text2sim.spec_schema.models.controls import Drive, Release, Remove
from text2sim.spec_schema.models.scene import Domain
from text2sim.spec_schema.models.space import BoxRegion, Region, SphereRegion
from text2sim.spec_schema.names.name_table import touching_parts

AXIS = {"x": 0, "y": 1, "z": 2}


class UnseenError(ValueError):
    """An event that the program cannot detect; the message says why."""


def lower_watches(
    loaded: LoadedCase, copies: dict[str, list[Copy]], soft: SoftControls | None
) -> tuple[list[Watch], list[Problem]]:
    """Return the rows for all events that something is released on, each behind the one that it waits for.

    Args:
        loaded: The case.
        copies: Copies by body, statics included.
        soft: Finds regions of deformable bodies; None if there are none.
    """
    watched: dict[str, Watch] = {}
    problems: list[Problem] = []
    writer = _Writer(loaded, copies, soft)
    for name, control in loaded.case.actions.controls.items():
        if not isinstance(control, Release | Drive | Remove) or control.on is None:
            continue
        where = ("actions", "controls", name, "on")
        order: dict[str, None] = {}
        if not _put_in_order(loaded.case.actions, control.on, order, ()):
            text = f"`{control.on}` waits for itself: `after` or a release goes in a circle"
            problems.append(loaded.problem(where, text, rule="unseen-event"))
            continue
        for event in order:
            if event in watched:
                continue
            try:
                watched[event] = writer.watch(event)
            except (UnseenError, RegionError) as error:
                words = "" if event == control.on else f"comes after `{event}`, and "
                problems.append(loaded.problem(where, f"{words}{error}", rule="unseen-event"))
                break
    return list(watched.values()), problems


def _put_in_order(actions: Actions, name: str, order: dict[str, None], waiting: tuple[str, ...]) -> bool:
    """Put an event into an order, behind all that it waits for; return whether it does not wait for itself.

    Args:
        actions: Of the case.
        name: The event.
        order: Receives the names.
        waiting: Events that wait for it.
    """
    if name in waiting:
        return False
    event = actions.events[name]
    before = [when for when in (event.after, *_deeds(actions, event)) if isinstance(when, str)]
    known = all(_put_in_order(actions, one, order, (*waiting, name)) for one in before)
    order[name] = None
    return known


def _deeds(actions: Actions, event: events.Event) -> list[float | str]:
    """Return when the program does what an event tells of, as times [s] and events; nothing for other events."""
    controls = []
    if isinstance(event, events.ReleasedEvent):
        controls = [c for c in actions.controls.values() if isinstance(c, Release) and c.attach == event.attach]
    elif isinstance(event, events.RemovedEvent):
        controls = [c for name, c in actions.controls.items() if isinstance(c, Remove) and name == event.remove]
    return [when for control in controls if (when := control.at if control.on is None else control.on) is not None]


class _Writer:
    """Writes calls of the program's functions, with further calls as their arguments."""

    def __init__(self, loaded: LoadedCase, copies: dict[str, list[Copy]], soft: SoftControls | None) -> None:
        self.loaded, self.copies, self.soft = loaded, copies, soft
        self.scene = loaded.case.scene

    def watch(self, name: str) -> Watch:
        event = self.loaded.case.actions.events[name]
        line = self.loaded.line(("actions", "events", name))
        return Watch(name, self._make(name, event), event.after, line)

    def _make(self, name: str, event: events.Event) -> Code:
        if isinstance(event, events.ContactEvent):
            return self._touch(name, event)
        if isinstance(event, events.RegionEvent):
            if event.region.moves_with is not None:
                raise UnseenError(f"`{name}` watches a region that moves with a body, known only after the run")
            depths = [self._depth(place, event.region) for place in self._places(event.of)]
            if event.kind == "leaves":
                depths = [Code(f"outside({depth})") for depth in depths]
            return _call("Crossing", _list(depths))
        if isinstance(event, events.ThresholdEvent):
            value = self._value(event.measure)
            if event.above is not None:
                return _call("Crossing", _list([_call("above", value, event.above)]))
            return _call("Crossing", _list([_call("below", value, event.below)]))
        if isinstance(event, events.ReleasedEvent | events.RemovedEvent):
            return _call("Deed", _deeds(self.loaded.case.actions, event))
        if isinstance(event, events.RestEvent):
            chosen = self._chosen(event.of)
            if any(is_soft(copy.model) for copy, _ in chosen):
                raise UnseenError(
                    f"`{name}` is about a deformable body, whose rest a program does not see while it runs; use a "
                    "threshold of its speed"
                )
            speeds = [
                Code(f"({literal(copy.name)}, {_call('norm', velocity)})")
                for (copy, _), velocity in zip(chosen, self._velocities(event.of, None), strict=True)
            ]
            removes = any(isinstance(control, Remove) for control in self.loaded.case.actions.controls.values())
            return _call("Rest", _list(speeds), event.speed, event.for_, Code("gone") if removes else None)
        raise UnseenError(
            f"a program cannot see `{name}` ({event.kind}) while it runs; it sees contact between bodies of links, "
            "enters, leaves, threshold, rest of bodies of links, released and removed"
        )

    def _touch(self, name: str, event: events.ContactEvent) -> Code:
        if event.min_impulse > 0.0:
            raise UnseenError(f"`{name}` depends on an impulse, known only after the run; leave out min_impulse")
        if contact_model(self.loaded.case.bodies.values(), self.scene) in ("sap", "ipc"):
            raise UnseenError(f"the engine reports no contacts in this contact model, so `{name}` cannot be seen")
        sets = []
        for selector in event.between:
            chosen = self._chosen(selector)
            if any(is_soft(copy.model) for copy, _ in chosen):
                raise UnseenError(
                    f"`{name}` is about a deformable body, whose contacts the engine does not report; use a "
                    "threshold of a distance or position"
                )
            if any(part is not None and touching_parts(copy.model) for copy, part in chosen):
                raise UnseenError(f"a program sees no parts (`{selector}`) while it runs; name the whole body")
            sets.append(_list([_call("links", _body(copy), part) for copy, part in chosen]))
        return _call("Touch", Code("scene"), *sets)

    def _value(self, name: str) -> Code:
        measure = self.loaded.case.actions.measures[name]
        if measure.so_far is not None:
            raise UnseenError(f"a program cannot see `{name}`, an extreme so far; it sees the value of the moment")
        if measure.change_from is None:
            return self._code_of_measure(name, measure)
        if measure.change_from in ("start", 0.0):
            return _call("since_start", self._code_of_measure(name, measure))
        raise UnseenError(f"a program cannot see `{name}`, a change from a later time; it sees a change from the start")

    def _code_of_measure(self, name: str, measure: measures.Measure) -> Code:
        if isinstance(measure, measures.Distance):
            first, second = (self._named_places(selector) for selector in measure.between)
            pairs = [Code(f"({a}, {b})") for one, a in first for other, b in second if one != other]
            return _call("distance", _list(pairs))
        if not isinstance(
            measure,
            measures.Position | measures.Displacement | measures.Velocity | measures.Speed | measures.JointPosition,
        ):
            raise UnseenError(
                f"a program cannot see `{name}` ({measure.kind}) while it runs; it sees position, displacement, "
                "velocity, speed, distance and joint_position"
            )
        if isinstance(measure, measures.Displacement) and measure.frame is not None:
            raise UnseenError(f"a program cannot see `{name}` in the frame of `{measure.frame}` while it runs")
        if isinstance(measure, measures.JointPosition):
            values = self._joints(measure.of)
        elif isinstance(measure, measures.Velocity | measures.Speed):
            speeds = self._velocities(measure.of, measure.region)
            values = [
                _call("coordinate", one, AXIS[measure.axis])
                if isinstance(measure, measures.Velocity)
                else _call("norm", one)
                for one in speeds
            ]
        else:
            places = self._places(measure.of, measure.region)
            function = "coordinate" if isinstance(measure, measures.Position) else "displacement"
            axis = AXIS[measure.axis] if measure.axis is not None else None
            values = [_call(function, place, axis) for place in places]
        if measure.stat is None:
            return values[0]
        if measure.stat == "count":
            raise UnseenError(f"a program cannot see the count of `{name}`; use another stat")
        return _call("reduce", measure.stat, _list(values))

    def _chosen(self, selectors: str | list[str]) -> list[tuple[Copy, str | None]]:
        """Return the copies that selectors name, each once, with the link or joint."""
        found: dict[tuple[str, str | None], tuple[Copy, str | None]] = {}
        for selector in listed(selectors):
            chosen, part = select(selector, self.copies)
            if part is not None and "*" in part:
                raise UnseenError(f"a program looks at one link or joint at a time, and `{selector}` may mean several")
            found |= {(copy.name, part): (copy, part) for copy in chosen}
        return list(found.values())

    def _joints(self, selectors: str | list[str]) -> list[Code]:
        chosen = self._chosen(selectors)
        return [_call("joint", Code("scene"), _body(copy), part or copy.body) for copy, part in chosen]

    def _places(self, selectors: str | list[str], region: object = None) -> list[Code]:
        return [code for _, code in self._named_places(selectors, region)]

    def _named_places(self, selectors: str | list[str], region: object = None) -> list[tuple[str, Code]]:
        chosen = self._chosen(selectors)
        return [(copy.name, self._call_for_copy(copy, part, region, "origin", "center")) for copy, part in chosen]

    def _velocities(self, selectors: str | list[str], region: object) -> list[Code]:
        chosen = self._chosen(selectors)
        return [self._call_for_copy(copy, part, region, "velocity", "center_velocity") for copy, part in chosen]

    def _call_for_copy(self, copy: Copy, part: str | None, region: object, rigid: str, deformable: str) -> Code:
        if not is_soft(copy.model):
            return _call(rigid, Code("scene"), _body(copy), part)
        assert self.soft is not None
        if region is None:
            return _call(deformable, _body(copy))
        finder = self.soft.finder(copy, region)  # type: ignore[arg-type]
        return _call(deformable, _body(copy), (copy.pos, copy.quat), finder)

    def _depth(self, place: Code, region: Region | Domain) -> Code:
        if isinstance(region, BoxRegion | Domain):
            return _call("in_box", place, tuple(region.min), tuple(region.max))
        if isinstance(region, SphereRegion):
            return _call("in_ball", place, tuple(region.center), region.radius)
        axis = vector_unit(region.axis)
        return _call("in_cylinder", place, tuple(region.center), axis, region.radius, region.height)


def _body(copy: Copy) -> Code:
    return Code(f"bodies[{literal(copy.name)}]")


def _list(items: Iterable[Code]) -> Code:
    return Code(f"[{', '.join(items)}]")


def _call(function: str, *arguments: object) -> Code:
    """Return the source of a call, without arguments at its end that are None."""
    given = list(arguments)
    while given and given[-1] is None:
        given.pop()
    return Code(f"{identifier(function)}({', '.join(literal(value) for value in given)})")
