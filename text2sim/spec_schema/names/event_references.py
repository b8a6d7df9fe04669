"""Checks of the bodies, measures and controls of events."""

from collections.abc import Sequence

from text2sim.spec_schema.errors import Severity, nearest
from text2sim.spec_schema.models import events, measures
from text2sim.spec_schema.models.controls import Attach, Bond, Release, Remove
from text2sim.spec_schema.names.control_references import check_joint
from text2sim.spec_schema.names.measure_references import (
    CONTACT_KINDS,
    check_carrier,
    check_contacts_recorded,
    measured,
)
from text2sim.spec_schema.names.name_table import Member, NameTable
from text2sim.spec_schema.names.reference_cycles import find_cycles
from text2sim.spec_schema.names.soft_measure_references import check_parts_touched
from text2sim.spec_schema.text.document import Path

NEVER = "never-released"
"""Rule of an event that waits for a release that no control makes."""


def check_events(table: NameTable) -> None:
    """Check every event."""
    script = table.loaded.case.actions
    for name, event in script.events.items():
        where: Path = ("actions", "events", name)
        table.check_known((*where, "after"), "event", event.after, script.events)
        check_carrier(table, where, event)
        if isinstance(event, events.ContactEvent | events.SeparationEvent):
            _check_pair(table, where, event)
        elif isinstance(event, events.ThresholdEvent):
            check_tested_measure(table, (*where, "measure"), event.measure)
        elif isinstance(event, events.ReleasedEvent):
            _check_released(table, where, event)
        elif isinstance(event, events.RemovedEvent):
            removals = [key for key, control in script.controls.items() if isinstance(control, Remove)]
            _check_named(table, where, "remove", event.remove, removals)
        elif isinstance(event, events.BrokenEvent):
            _check_bond(table, where, event.bond)
        else:
            _check_subject(table, where, event)
    following = {name: event.after for name, event in script.events.items() if event.after is not None}
    for cycle in find_cycles(following):
        message = f"waits for itself: {' -> '.join([*cycle, cycle[0]])}"
        table.report(("actions", "events", cycle[0], "after"), message, "circular-after")


def _check_pair(table: NameTable, where: Path, event: events.ContactEvent | events.SeparationEvent) -> None:
    found = [
        table.find(selector, (*where, "between", index), many=True, touching=True)
        for index, selector in enumerate(event.between)
    ]
    first, second = found
    check_parts_touched(table, [member for member in found if member is not None])
    if any(member is not None and member.deforms for member in found):
        if isinstance(event, events.ContactEvent) and event.min_impulse > 0:
            message = "the engine reports no forces on deformable bodies, so contacts cannot be filtered by impulse"
            table.report((*where, "min_impulse"), message, "contacts-not-recorded", key=True)
    else:
        check_contacts_recorded(table, where)
    if first is None or second is None:
        return
    if first.text == second.text and first.count == 1:
        table.report((*where, "between", 1), f"`{first.text}` cannot touch itself", "itself")
    elif not first.dynamic and not second.dynamic:
        why = f"{first.why_not_dynamic}, and {second.why_not_dynamic}"
        table.report((*where, "between"), f"physics moves neither body: {why}", "driven-subject")


def check_tested_measure(table: NameTable, where: Path, name: str, severity: Severity = "error") -> None:
    """Report a measure that does not exist, or that only repeats prescribed motion.

    Args:
        table: The table; problems are added to it.
        where: Path of the measure's name.
        name: The name.
        severity: Severity of a measure of prescribed motion.
    """
    known = table.loaded.case.actions.measures
    if table.check_known(where, "measure", name, known) and _is_prescribed(table, known[name]):
        message = f"`{name}` measures a body with prescribed motion, which tests nothing"
        table.report(where, message, "driven-subject", severity=severity)


def _is_prescribed(table: NameTable, measure: measures.Measure) -> bool:
    """Return whether a measure only repeats the motion that the case prescribes."""
    members = measured(table, measure)
    moved_by_the_case = bool(members) and not any(member.dynamic for member in members)
    return measure.kind not in CONTACT_KINDS and moved_by_the_case and any(member.driven for member in members)


def _check_released(table: NameTable, where: Path, event: events.ReleasedEvent) -> None:
    controls = table.loaded.case.actions.controls
    attaches = [name for name, control in controls.items() if isinstance(control, Attach)]
    if not table.check_known((*where, "attach"), "attach", event.attach, attaches):
        return
    released = [control.attach for control in controls.values() if isinstance(control, Release)]
    # A release with an unknown `attach` is reported itself, and may be meant for this one.
    if event.attach not in released and all(name in attaches for name in released):
        table.report((*where, "attach"), f"no control releases `{event.attach}`", NEVER)


def _check_bond(table: NameTable, where: Path, name: str) -> None:
    controls = table.loaded.case.actions.controls
    attach = controls.get(name)
    if isinstance(attach, Attach) and attach.strength is None:
        message = f"`{name}` is an attach without a `strength`, which never breaks; a `release` is `kind: released`"
        table.report((*where, "bond"), message, NEVER)
        return
    breaking = [key for key, one in controls.items() if isinstance(one, Bond | Attach) and one.strength is not None]
    _check_named(table, where, "bond", name, breaking, ", or attach with a `strength`")


def _check_named(table: NameTable, where: Path, kind: str, name: str, known: Sequence[str], more: str = "") -> None:
    """Report a control of a kind that does not exist."""
    if name not in known:
        message = f"there is no control `{name}` of kind {kind}{more}"
        table.report((*where, kind), message, f"unknown-{kind}", nearest(name, known))


def _check_subject(
    table: NameTable,
    where: Path,
    event: events.RestEvent | events.LeftDomainEvent | events.RegionEvent | events.JointLimitEvent,
) -> None:
    if isinstance(event, events.LeftDomainEvent) and table.loaded.case.scene.domain is None:
        table.report(where, "this event needs `scene.domain`, which is missing", "no-domain", key=True)
    for member in table.find_all(event.of, (*where, "of"), joint=isinstance(event, events.JointLimitEvent)):
        _check_member(table, event, member)


def _check_member(table: NameTable, event: events.Event, member: Member) -> None:
    if isinstance(event, events.JointLimitEvent):
        joint = check_joint(table, member.where, member, "measure")
        if joint is not None and getattr(joint, "range_deg", None) is None and getattr(joint, "range", None) is None:
            table.report(member.where, f"the joint of `{member.text}` has no limits", "no-limit")
    elif not member.dynamic:
        message = f"{member.why_not_dynamic}, so this event would test nothing"
        table.report(member.where, message, "driven-subject" if member.driven else "not-dynamic")
