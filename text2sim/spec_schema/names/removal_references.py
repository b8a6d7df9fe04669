"""Checks of removed bodies, and of later references to them."""

from typing import Any

from text2sim.spec_schema.models.base import span_of
from text2sim.spec_schema.models.controls import Remove
from text2sim.spec_schema.models.scene import Scene
from text2sim.spec_schema.names.measure_references import measured_sides
from text2sim.spec_schema.names.name_table import NameTable
from text2sim.spec_schema.names.selectors import WORLD, parse_selector
from text2sim.spec_schema.text.document import Path

LATE = "after-removal"
"""Rule of a reference to a body after its removal."""


def check_removals(table: NameTable) -> None:
    """Check every control that removes a body, and later references to it."""
    actions, scene = table.loaded.case.actions, table.loaded.case.scene
    for name, control in actions.controls.items():
        if not isinstance(control, Remove):
            continue
        where: Path = ("actions", "controls", name)
        table.check_known((*where, "on"), "event", control.on, actions.events)
        member = table.find(control.body, (*where, "body"), parts=False)
        if member is None:
            continue
        if member.deforms:
            message = f"`{member.name}` deforms; only rigid and driven bodies, trees and statics can be removed"
            table.report((*where, "body"), message, "not-removable")
        elif why := fixed_because(
            scene, "bodies that rest on it would stay asleep in the air", "cannot remove a body during a run"
        ):
            table.report((*where, "kind"), f"nothing can be removed from this scene: {why}", "not-removable")
        elif control.at is not None and not table.loaded.varies(where):
            _check_controls(table, name, control)
            _check_expectations(table, name, control)


def fixed_because(scene: Scene, asleep: str, lacking: str) -> str | None:
    """Return why bodies of a scene can be neither bonded nor removed; None if they can.

    Args:
        scene: The scene.
        asleep: What would go wrong with bodies that sleep.
        lacking: What its contact model does not do.
    """
    if scene.solver.hibernation:
        return f"with `hibernation`, {asleep}"
    return f"contact model {scene.contact.model} {lacking}" if scene.contact.model in ("sap", "ipc") else None


def _check_controls(table: NameTable, name: str, removal: Remove) -> None:
    """Report controls of a removed body."""
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
    """Report expectations on measures of removed bodies."""
    actions, duration = table.loaded.case.actions, table.loaded.case.scene.duration
    for key, expect in actions.expect.items():
        measure = actions.measures.get(expect.measure or "")
        if measure is None or removal.at is None or expect.on is not None or measure.kind in ("count_in", "threaded"):
            continue
        # A measure has values as long as one body is left, on each side of a distance or gap.
        sides = (side for side in measured_sides(table, measure) if side)
        gone = next((side for side in sides if all(_covers(removal.body, member.text) for member in side)), None)
        if gone is None:
            continue
        window = expect.during if isinstance(expect.during, tuple) else None
        last = span_of(window, duration)[1] if expect.at is None else duration if expect.at == "end" else expect.at
        if isinstance(last, float | int) and last > removal.at + 1e-9:
            field = "at" if expect.at is not None else "during"
            _report(table, ("actions", "expect", key, field), gone[0].text, name, removal.at)


def _report(table: NameTable, where: Path, selector: str, name: str, at: float) -> None:
    message = f"`{selector}` is no longer in the scene: `{name}` removes it at {at:g} s"
    table.report(where, message, LATE, key=True)


def _start(control: Any) -> float | None:
    """Return when [s] a control begins to act; None if it begins at an event."""
    if getattr(control, "on", None) is not None or control.kind == "release":
        return None
    during = getattr(control, "during", None)
    return during[0] if during is not None else getattr(control, "at", 0.0)


def _covers(removed: str, selector: str) -> bool:
    """Return whether a selector removes all copies of another."""
    gone, other = parse_selector(removed), parse_selector(selector)
    if gone.body != other.body:
        return False
    if gone.first is None or gone.last is None:
        return True
    if other.first is None or other.last is None:
        return False
    return gone.first <= other.first and other.last <= gone.last
