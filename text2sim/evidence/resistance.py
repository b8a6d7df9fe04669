"""Resistance to joints: whether what a motor pushes against is held by more than the motor."""

from collections import defaultdict
from collections.abc import Iterator

import numpy as np

from text2sim.evidence.recorded_case import RecordedCase
from text2sim.recording.states import Array, JointRecord
from text2sim.recording.vectors import rotate, rotate_back

LEAST_PART = 0.25
"""Part of a motor's force that contacts take up where they block its joint; of two coupled fingers, each takes half."""
MAX_OPPONENTS = 2
"""Most bodies that are named."""
STOP = {"hinge": 0.01, "slider": 1e-3}
"""Distance [rad, m] from the end of a joint's range at which its stop holds it."""


def ancestors(recording: RecordedCase, link: int) -> Iterator[int]:
    """Yield a link and all links between it and the root of its mechanism."""
    while link >= 0:
        yield link
        link = recording.states.links[link].parent


def is_blocked(recording: RecordedCase, joint: JointRecord, sense: float, frames: Array) -> bool:
    """Return whether something blocks a joint against its motor, so that a limited force is all that it can do.

    Its stop does, and so do contacts of the links beyond it that act against the motor, with bodies that are held:
    fixed ones, and loose ones that these or other links of the mechanism touch as well. What only rests on it is a
    load. What a mechanism without a fixed root stands on carries its weight, and blocks nothing. Where contacts are not
    recorded, and in scenes with bodies that deform, nothing can be told, and it counts as blocked.

    Args:
        recording: The recording.
        joint: A hinge or slider.
        sense: Sign of the motor's force.
        frames: Indices of the frames to look at, consecutive.
    """
    states, log = recording.states, recording.contacts
    stop = joint.limits[1] if sense > 0 else joint.limits[0]
    position = float(states.qpos[frames, joint.q[0]].astype(float).mean())
    if stop is not None and sense * (stop - position) < STOP[joint.kind]:
        return True
    if not log.recorded or states.deformables:
        return True
    own, beyond, rows = _links_beyond(recording, joint, frames)
    touching = {frozenset((int(a), int(b))) for a, b in log.links[rows]}
    met = {other for pair in touching if pair & beyond for other in pair - beyond}
    held = {other for other in met if _is_held(recording, joint.body, beyond, other, touching)}
    resistance = 0.0
    for row in rows:
        a, b = (int(link) for link in log.links[row])
        for link, other, sign in ((a, b, 1.0), (b, a, -1.0)):
            if link in beyond and other in held:
                resistance -= sense * _along(recording, joint, int(row), sign * log.force[row])
    steps = int(states.steps[frames[-1]]) - int(states.steps[frames[0]]) + 1
    if resistance / steps >= LEAST_PART * (joint.max_force or 0.0):
        return True
    # In linkages, fingers may be beyond other joints, which constraints couple to this one.
    model = recording.names.model_of(joint.body)
    if not (getattr(model, "file", None) or getattr(model, "loops", None)):
        return False
    aside = own - beyond - set(ancestors(recording, joint.link))
    return any(
        link in aside and other not in own and _is_held(recording, joint.body, {link}, other, touching)
        for pair in touching
        for link, other in (tuple(pair), tuple(pair)[::-1])
    )


def opponents(recording: RecordedCase, joint: JointRecord, sense: float, frames: Array) -> list[str]:
    """Return the bodies, links or parts whose contacts act against the motor of a joint, the strongest first.

    Args:
        recording: The recording; without contacts there are none.
        joint: A hinge or slider.
        sense: Sign of the motor's force.
        frames: Indices of the frames to look at, consecutive.
    """
    states, log = recording.states, recording.contacts
    if not log.recorded:
        return []
    own, beyond, rows = _links_beyond(recording, joint, frames)
    pushes: defaultdict[str, float] = defaultdict(float)
    for row in rows:
        a, b = (int(link) for link in log.links[row])
        for link, other, sign, surface in ((a, b, 1.0, 1), (b, a, -1.0, 0)):
            if link in beyond and other not in own:
                part = int(states.contact_surfaces[row, surface]) - len(states.links)
                name = recording.names.label_of_link(other) + (f".{states.parts[part][1]}" if part >= 0 else "")
                pushes[name] -= sense * _along(recording, joint, int(row), sign * log.force[row])
    strongest = sorted(pushes, key=lambda name: -pushes[name])[:MAX_OPPONENTS]
    return [name for name in strongest if pushes[name] > 0]


def _links_beyond(recording: RecordedCase, joint: JointRecord, frames: Array) -> tuple[set[int], set[int], Array]:
    """Return all links of a joint's body, those that it moves, and the indices of the contacts of some frames."""
    states, log = recording.states, recording.contacts
    rows = np.flatnonzero((log.step >= int(states.steps[frames[0]])) & (log.step <= int(states.steps[frames[-1]])))
    own = set(recording.names.copies[joint.body].links)
    return own, {link for link in own if joint.link in ancestors(recording, link)}, rows


def _along(recording: RecordedCase, joint: JointRecord, row: int, force: Array) -> float:
    """Return the torque [N m] or force [N] about or along a joint of the force [N] of a contact."""
    states, log = recording.states, recording.contacts
    frame = min(int(log.frame[row]), states.frames - 1)
    pos, quat = (rows[:, joint.link].astype(float) for rows in (states.pos, states.quat))
    axis = rotate(quat[frame], rotate_back(quat[0], np.array(joint.axis)))
    if joint.kind == "slider":
        return float(axis @ force)
    anchor = pos[frame] + rotate(quat[frame], rotate_back(quat[0], np.array(joint.anchor) - pos[0]))
    return float(axis @ np.cross(log.pos[row] - anchor, force))


def _is_held(recording: RecordedCase, body: str, moved: set[int], link: int, touching: set[frozenset[int]]) -> bool:
    """Return whether a link is held by more than the links that a joint moves: followed from touch to touch."""
    states, names = recording.states, recording.names
    own = set(names.copies[body].links)
    loose = {joint.body for joint in states.joints if joint.kind == "free"} - set(names.driven)
    seen: set[str] = set()
    waiting = [link]
    while waiting:
        current = waiting.pop()
        if current in own:
            return True
        copy = states.links[current].body
        links = set(names.copies[copy].links)
        if copy not in loose and body not in loose:
            return True
        if copy in loose and copy not in seen:
            seen.add(copy)
            waiting += [other for pair in touching if pair & links for other in pair - links - moved]
    return False
