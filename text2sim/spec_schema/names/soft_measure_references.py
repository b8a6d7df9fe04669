"""Checks of measures against the kind of body: rigid or deformable."""

from text2sim.spec_schema.models import measures
from text2sim.spec_schema.models.base import listed
from text2sim.spec_schema.models.controls import Bond
from text2sim.spec_schema.models.soft_bodies import FLOWING
from text2sim.spec_schema.names.name_table import Member, NameTable, touching_parts
from text2sim.spec_schema.names.selectors import body_of
from text2sim.spec_schema.text.document import Path

MEASURED_OF: dict[str, tuple[str, ...]] = {
    "volume": ("soft",),
    "strain": ("soft",),
    "pieces": ("soft", "snow"),
    "largest_piece": ("soft", "snow"),
    "leaked": FLOWING,
    "surface_level": FLOWING,
    "stretch": ("soft", "cloth"),
    "folded_area": ("cloth",),
    "folds": ("cloth",),
    "wrinkling": ("cloth",),
    "self_penetration": ("cloth",),
    "share_in": ("soft", "cloth", *FLOWING),
}
"""Kinds of body that each measure supports."""
BONDED_KINDS = ("pieces", "largest_piece")
"""Those that bonded rigid bodies have as well."""
INSTEAD = {
    ("volume", "cloth"): "its area stays nearly constant: measure its `stretch`",
    ("pieces", "cloth"): "cloth does not tear",
    ("largest_piece", "cloth"): "cloth does not tear",
    ("pieces", "grains"): "it consists of many from the start: measure the `share_in` a region",
    ("largest_piece", "grains"): "it consists of many from the start: measure the `share_in` a region",
    ("leaked", "soft"): "it does not flow: measure the `gap` to its walls",
    ("leaked", "cloth"): "it does not flow: measure the `gap` to its support",
    ("surface_level", "soft"): "it does not flow: measure its `extent`",
    ("surface_level", "cloth"): "it does not flow: measure its `extent`",
    ("strain", "cloth"): "it has no inside: measure its `stretch`",
    ("volume", "grains"): "its particles have no surface: measure its `extent`, or the `share_in` a region",
    ("strain", "grains"): "it flows and has no rest shape: measure its `extent`",
    ("stretch", "grains"): "its particles have no edges: measure its `extent`",
}
"""What to measure instead, by measure and kind of body."""
FORCES = ("contact_force", "contact_count")
"""Measures of contacts, which the engine reports only for rigid bodies."""


def check_soft_measure(table: NameTable, where: Path, measure: measures.Measure, member: Member) -> bool:
    """Report a measure that its kind of body does not support; return whether there was a problem.

    Args:
        table: The bodies of the case.
        where: Path of the measure.
        measure: The measure.
        member: Its body.
    """
    kind = measure.kind
    if kind in BONDED_KINDS and not member.deforms:
        return _check_bonded(table, kind, member)
    if kind in MEASURED_OF and (not member.deforms or member.model.kind not in MEASURED_OF[kind]):
        _report_kind(table, kind, member)
        return True
    if not member.deforms:
        if getattr(measure, "region", None) is not None and kind != "count_in":
            message = f"a region is for deformable bodies, and `{member.name}` is rigid: leave it out"
            table.report((*where, "region"), message, "not-soft", key=True)
            return True
        return False
    if measure.traits.instead:
        message = f"`{member.name}` deforms, so that it has no {kind.replace('_', ' ')}; {measure.traits.instead}"
        table.report(member.where, message, "measure-kind")
        return True
    if kind in FORCES:
        table.report(member.where, _unreported(member), "contacts-not-recorded")
        return True
    return False


def check_other_side(table: NameTable, measure: measures.Measure, others: list[Member]) -> None:
    """Report deformable bodies in `by` of a measure of contact forces.

    Args:
        table: The table; problems are added to it.
        measure: The measure.
        others: The bodies in `by`.
    """
    for other in others if measure.kind in FORCES else ():
        if other.deforms:
            table.report(other.where, _unreported(other), "contacts-not-recorded")


def check_parts_touched(table: NameTable, members: list[Member]) -> None:
    """Report parts of compounds in contact with deformable bodies, which is found by distances of whole bodies."""
    soft = next((member.name for member in members if member.deforms), None)
    for member in members:
        if soft is not None and member.part is not None and touching_parts(member.model):
            message = f"contact with `{soft}`, which deforms, is found for whole bodies only: name `{member.name}`"
            table.report(member.where, message, "part", member.name)


def check_gap(table: NameTable, where: Path, gap: measures.Gap) -> None:
    """Check both sides of a gap: they have to be different, and all bodies of one have to deform.

    Args:
        table: The table; problems are added to it.
        where: Path of the measure.
        gap: The measure.
    """
    first, second = table.find_all(gap.of, (*where, "of")), table.find_all(gap.to, (*where, "to"))
    rigid, other = ([member for member in side if not member.deforms] for side in (first, second))
    texts = {member.text for member in (*first, *second)}
    if not first or not second:
        return
    if len(texts) == 1 and first[0].count == 1:
        table.report((*where, "to"), f"`{first[0].text}` has no gap to itself", "itself")
    elif rigid and other:
        message = f"neither `{rigid[0].name}` nor `{other[0].name}` deforms; measure the `distance` of their origins"
        if len(rigid) < len(first) or len(other) < len(second):
            message = f"neither `{rigid[0].name}` nor `{other[0].name}` deforms; all bodies of one side have to"
        table.report(rigid[0].where, message, "measure-kind")


def check_submerging(table: NameTable, where: Path, measure: measures.Submerged) -> None:
    """Report bodies in `by` of `submerged` that do not flow.

    Args:
        table: The table; problems are added to it.
        where: Path of the measure.
        measure: The measure.
    """
    for member in table.find_all(measure.by, (*where, "by"), many=True):
        if not member.deforms or member.model.kind not in FLOWING:
            message = f"`{member.name}` does not flow; it needs {' or '.join(FLOWING)}"
            table.report(member.where, message, "measure-kind")


def _check_bonded(table: NameTable, kind: str, member: Member) -> bool:
    """Report a rigid body that no control bonds, so that it cannot come apart; return whether it is one."""
    bonds = (c for c in table.loaded.case.actions.controls.values() if isinstance(c, Bond))
    if any(body_of(selector) == member.name for bond in bonds for selector in listed(bond.of)):
        return False
    message = f"`{member.name}` has no {kind.replace('_', ' ')}: it is rigid, and no control of kind `bond` joins it"
    table.report(member.where, f"{message}; it needs soft, or bonded copies", "not-bonded")
    return True


def _report_kind(table: NameTable, kind: str, member: Member) -> None:
    words = kind.replace("_", " ")
    own = getattr(member.model, "kind", "static")
    known = INSTEAD.get((kind, own if own in ("soft", "cloth") else "grains")) if member.deforms else None
    takes = " or ".join(MEASURED_OF[kind]) if len(MEASURED_OF[kind]) < 4 else "a deformable body"
    message = f"`{member.name}` ({'static' if member.static else own}) has no {words}"
    table.report(member.where, f"{message}; {known or f'it needs {takes}'}", "measure-kind")


def _unreported(member: Member) -> str:
    return (
        f"the engine reports no contacts of deformable bodies such as `{member.name}`; measure the `gap`, or use a "
        "`contact` event, which is found by distance"
    )
