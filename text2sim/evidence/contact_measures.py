"""Measures of contacts: forces, pairs and depths. Each function states its formula.

Contacts are recorded at every time step, measures at frames: a frame covers the steps since the previous one. The
first frame shows the contacts of the first step.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from text2sim.evidence import soft_measures
from text2sim.evidence.recorded_case import RecordedCase
from text2sim.evidence.selection import RecordedTarget
from text2sim.recording.states import Array
from text2sim.spec_schema.models import measures

MeasureError = soft_measures.SoftMeasureError
Targets = list[RecordedTarget]


def _sides(recording: RecordedCase, measure: Any) -> tuple[Targets, Targets | None]:
    """Return the targets of `of`, and those of `by`; None for any."""
    select = recording.names.select_touching
    return select(measure.of), None if measure.by is None else select(measure.by)


def _contact_rows(recording: RecordedCase, of: Targets, by: Targets | None) -> tuple[Array, Array]:
    """Return the contacts of `of` with `by` (or anything), and +1 where the first of the two is in `of`."""
    log = recording.contacts
    if not log.recorded:
        raise MeasureError(log.why_not)
    soft = [target.label for target in (*of, *(by or ())) if target.soft is not None]
    if soft:
        raise MeasureError(f"the engine reports no contacts of deformable bodies ({soft[0]}): measure the `gap`")
    ours = recording.names.groups(of) >= 0
    theirs = np.ones(len(ours), dtype=bool) if by is None else recording.names.groups(by) >= 0
    first, second = recording.states.contact_surfaces.T
    forward, backward = ours[first] & theirs[second], ours[second] & theirs[first]
    rows = np.flatnonzero((forward | backward) & (log.frame < recording.states.frames))
    # Forces between two bodies of `of` cancel.
    return rows, forward[rows].astype(float) - backward[rows]


def _contact_force(recording: RecordedCase, measure: measures.ContactForce) -> Array:
    """|sum of F dt| / T over the steps of a frame: the mean force, as a scale would show it, or a component of it."""
    rows, sign = _contact_rows(recording, *_sides(recording, measure))
    states, log = recording.states, recording.contacts
    total = np.zeros((states.frames, 3))
    np.add.at(total, log.frame[rows], log.force[rows] * sign[:, None])
    total[1:] /= np.maximum(np.diff(states.steps), 1)[:, None]
    if states.frames:
        begin = rows[log.step[rows] == states.steps[0] + 1]
        total[0] = (log.force[begin] * sign[np.isin(rows, begin)][:, None]).sum(axis=0)
    return np.linalg.norm(total, axis=1) if measure.axis is None else total[:, "xyz".index(measure.axis)]


def _contact_count(recording: RecordedCase, measure: measures.ContactCount) -> Array:
    """Number of distinct pairs that touch in any step of a frame: of bodies, and of the links that are named."""
    of, by = _sides(recording, measure)
    rows, _ = _contact_rows(recording, of, by)
    frame, owner = _frames_with_first(recording, rows)
    links, names = recording.contacts.links[owner], recording.names
    pairs = names.copy_of_link[links]
    named = np.isin(links, [link for target in (*of, *(by or ())) if target.link is not None for link in target.links])
    # Links of one body touch each other at their joints: that counts only where both sides name links.
    within = by is not None and all(target.link is not None for target in (*of, *by))
    apart = (pairs[:, 0] != pairs[:, 1]) | (within & (links[:, 0] != links[:, 1]))
    pairs = np.sort(np.where(named, len(names.copies) + links, pairs), axis=1)  # numbers after those of the copies
    n = len(names.copies) + len(names.copy_of_link)
    # One integer per pair and frame, because sorting rows is slow.
    found = np.unique(((frame * n + pairs[:, 0]) * n + pairs[:, 1])[apart]) // (n * n)
    return np.bincount(found, minlength=recording.states.frames)


def _penetration(recording: RecordedCase, measure: measures.Penetration) -> Array:
    """Deepest penetration in any step of a frame; 0 without contact.

    For deformable bodies, the depth of their points in rigid solids, at the frames only. Of both, the deeper one.
    """
    sides = targets, others = _sides(recording, measure)
    soft = soft_measures.depth(recording, targets, others)
    rigid = [side and [target for target in side if target.soft is None] for side in sides]
    if [] in rigid:
        return soft
    rows, _ = _contact_rows(recording, rigid[0] or [], rigid[1])
    frame, owner = _frames_with_first(recording, rows)
    np.maximum.at(soft, frame, recording.contacts.depth[owner])
    return soft


def _frames_with_first(recording: RecordedCase, rows: Array) -> tuple[Array, Array]:
    """Return (frame, row) of contacts; those of the first step are repeated for the first frame."""
    log, states = recording.contacts, recording.states
    begin = rows[log.step[rows] == states.steps[0] + 1] if states.frames else rows[:0]
    return np.concatenate([np.zeros(len(begin), dtype=np.int64), log.frame[rows]]), np.concatenate([begin, rows])


MEASURES: dict[str, Callable[[RecordedCase, Any], Array]] = {
    "contact_force": _contact_force,
    "contact_count": _contact_count,
    "penetration": _penetration,
}
"""Measures by kind; values are over frames, (F,)."""
