"""Checks that what leaves the scene can leave it, and that nothing is asked of it afterwards."""

from typing import Any

from text2sim.spec_schema.errors import nearest
from text2sim.spec_schema.models.base import span_of
from text2sim.spec_schema.models.controls import Remove
from text2sim.spec_schema.names.measure_references import measured
from text2sim.spec_schema.names.name_table import NameTable
from text2sim.spec_schema.names.selectors import parse_selector
from text2sim.spec_schema.names.soft_control_references import WORLD, deforms
from text2sim.spec_schema.text.document import Path

LATE = "after-removal"
"""Id of what is wrong where something is asked of a body that has left."""


def check_removals(table: NameTable) -> None:
    """Check every control that removes something, and what comes after it."""
    actions, scene = table.loaded.case.actions, table.loaded.case.scene
    for name, control in actions.controls.items():
        if not isinstance(control, Remove):
            continue
        where: Path = ("actions", "controls", name)
        if control.on is not None and control.on not in actions.events:
            message = f"there is no event `{control.on}`"
            table.report((*where, "on"), message, "unknown-event", nearest(control.on, actions.events))
        member = table.find(control.body, (*where, "body"), parts=False)
        if member is None:
            continue
        if deforms(member):
            message = (
                f"`{member.name}` deforms, and only bodies of links, driven bodies and statics can leave the scene"
            )
            table.report((*where, "body"), message, "not-removable")
        elif scene.contact.model in ("sap", "ipc") or scene.solver.hibernation:
            why = "with `hibernation` what rests on it would sleep on in the air"
            if not scene.solver.hibernation:
                why = f"contact model {scene.contact.model} cannot let go of a body in the middle of a run"
            table.report((*where, "kind"), f"nothing can leave this scene: {why}", "not-removable")
        elif control.at is not None and not table.loaded.varies(where):
            _check_controls(table, name, control)
            _check_expectations(table, name, control)


def _check_controls(table: NameTable, name: str, removal: Remove) -> None:
    """Report what is to act on a body that has left."""
    for other, control in table.loaded.case.actions.controls.items():
        where: Path = ("actions", "controls", other)
        start = _start(control)
        if other == name or start is None or removal.at is None or start < removal.at:
            continue
        for field in ("body", "joint", "to"):
            selector = getattr(control, field, None)
            if selector is not None and selector != WORLD and _covers(removal.body, selector):
                _report(table, (*where, field), selector, name, removal.at)


def _check_expectations(table: NameTable, name: str, removal: Remove) -> None:
    """Report what is to be measured of bodies all of which have left."""
    actions, duration = table.loaded.case.actions, table.loaded.case.scene.duration
    for key, expect in actions.expect.items():
        measure = actions.measures.get(expect.measure or "")
        if measure is None or removal.at is None or expect.on is not None or measure.kind == "count_in":
            continue
        members = measured(table, measure)
        gone = [member for member in members if _covers(removal.body, member.text)]
        either = measure.kind in ("distance", "gap")
        if not gone or (len(gone) < len(members) and not either):
            continue
        window = expect.during if isinstance(expect.during, tuple) else None
        last = span_of(window, duration)[1] if expect.at is None else duration if expect.at == "end" else expect.at
        if isinstance(last, float | int) and last > removal.at + 1e-9:
            field = "at" if expect.at is not None else "during"
            _report(table, ("actions", "expect", key, field), gone[0].text, name, removal.at)


def _report(table: NameTable, where: Path, selector: str, name: str, at: float) -> None:
    message = f"`{selector}` has left the scene by then: `{name}` removes it at {at:g} s"
    table.report(where, message, LATE, key=True)


def _start(control: Any) -> float | None:
    """When [s] a control begins to act, if that is known; None for what comes at an event."""
    if getattr(control, "on", None) is not None or control.kind == "release":
        return None
    during = getattr(control, "during", None)
    return during[0] if during is not None else getattr(control, "at", 0.0)


def _covers(removed: str, selector: str) -> bool:
    """Whether all that a selector means is removed with another."""
    gone, other = parse_selector(removed), parse_selector(selector)
    if gone.body != other.body:
        return False
    if gone.first is None or gone.last is None:
        return True
    if other.first is None or other.last is None:
        return False
    return gone.first <= other.first and other.last <= gone.last
