"""Checks of the bodies that measures are taken of: some need points that move, others a frame or forces."""

from text2sim.spec_schema.models import measures
from text2sim.spec_schema.names.name_table import Member, NameTable
from text2sim.spec_schema.names.soft_control_references import deforms
from text2sim.spec_schema.text.document import Path

KINDS: dict[str, tuple[str, ...]] = {
    "volume": ("soft",),
    "strain": ("soft",),
    "pieces": ("soft",),
    "largest_piece": ("soft",),
    "leaked": ("granular", "liquid", "snow"),
    "stretch": ("soft", "cloth"),
    "folded_area": ("cloth",),
    "wrinkling": ("cloth",),
    "self_penetration": ("cloth",),
    "share_in": ("soft", "cloth", "granular", "liquid", "snow"),
}
"""Kinds of body that have what is measured."""
WAYS = {
    ("volume", "cloth"): "its area stays nearly the same: measure its `stretch`",
    ("pieces", "cloth"): "its threads do not break",
    ("largest_piece", "cloth"): "its threads do not break",
    ("pieces", "grains"): "it is many from the start: measure the `share_in` a region",
    ("largest_piece", "grains"): "it is many from the start: measure the `share_in` a region",
    ("leaked", "soft"): "it does not run out: measure the `gap` to its walls",
    ("leaked", "cloth"): "it does not run out: measure the `gap` to what carries it",
    ("strain", "cloth"): "it is all surface: measure its `stretch`",
    ("volume", "grains"): "it is particles without a surface: measure its `extent`, or the `share_in` a region",
    ("strain", "grains"): "it flows, and has no shape to go back to: measure its `extent`",
    ("stretch", "grains"): "it is particles without edges: measure its `extent`",
}
"""What to measure instead, by measure and kind of body."""
FRAMED = {
    "angular_speed": "measure the `velocity` of a `region` of it",
    "angular_velocity": "measure the `velocity` of a `region` of it",
    "turns": "measure the `position` of two regions of it",
    "bend": "measure the `position` of three regions of it, or the `wrinkling` of a cloth",
    "angular_momentum": "measure its `momentum`",
    "tilt": "measure the `position` of two regions of it",
}
"""Measures of a body's own frame, and the way out."""
FORCES = ("contact_force", "contact_count")
"""Measures of contacts, of which the engine tells those of rigid bodies alone."""


def check_soft_measure(table: NameTable, where: Path, measure: measures.Measure, member: Member) -> bool:
    """Report what is wrong between a measure and the kind of body that it is of; return whether anything was.

    Args:
        table: The bodies of the case.
        where: Where the measure stands.
        measure: The measure.
        member: What its `of` means.
    """
    kind = measure.kind
    if kind in KINDS and (not deforms(member) or member.model.kind not in KINDS[kind]):
        _report_kind(table, where, kind, member)
        return True
    if not deforms(member):
        if getattr(measure, "region", None) is not None and kind != "count_in":
            message = f"a region is for bodies that deform, and `{member.name}` does not: leave it out"
            table.report((*where, "region"), message, "not-soft", key=True)
            return True
        return False
    if kind in FRAMED:
        message = f"`{member.name}` deforms, so that it has no {kind.replace('_', ' ')}; {FRAMED[kind]}"
        table.report((*where, "of"), message, "measure-kind")
        return True
    if kind in FORCES:
        table.report((*where, "of"), _untold(member), "contacts-not-recorded")
        return True
    return False


def check_other_side(table: NameTable, where: Path, measure: measures.Measure, other: Member) -> None:
    """Report a body that deforms where contact forces between rigid bodies are meant (`by`).

    Args:
        table: The table; problems are added to it.
        where: Path of the measure.
        measure: The measure.
        other: What `by` names.
    """
    if measure.kind in FORCES and deforms(other):
        table.report((*where, "by"), _untold(other), "contacts-not-recorded")


def check_gap(table: NameTable, where: Path, gap: measures.Gap) -> None:
    """Check both sides of a gap: one has to deform, and it has to be another than the other.

    Args:
        table: The table; problems are added to it.
        where: Path of the measure.
        gap: The measure.
    """
    first, second = table.find(gap.of, (*where, "of")), table.find(gap.to, (*where, "to"))
    if first is None or second is None:
        return
    if first.text == second.text and first.count == 1:
        table.report((*where, "to"), f"`{first.text}` has no gap to itself", "itself")
    elif not (deforms(first) or deforms(second)):
        message = f"neither `{first.name}` nor `{second.name}` deforms; measure the `distance` of their origins"
        table.report((*where, "of"), message, "measure-kind")


def _report_kind(table: NameTable, where: Path, kind: str, member: Member) -> None:
    words = kind.replace("_", " ")
    own = getattr(member.model, "kind", "static")
    known = WAYS.get((kind, own if own in ("soft", "cloth") else "grains")) if deforms(member) else None
    takes = " or ".join(KINDS[kind]) if len(KINDS[kind]) < 4 else "a body that deforms"
    message = f"`{member.name}` ({'static' if member.static else own}) has no {words}"
    table.report((*where, "of"), f"{message}; {known or f'it is measured of {takes}'}", "measure-kind")


def _untold(member: Member) -> str:
    return (
        f"the engine tells no contacts of bodies that deform, such as `{member.name}`; measure the `gap`, or look for "
        "a `contact` event, which is found by how near they come"
    )
