"""Detection of keyframed motion: recorded positions that no force explains."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from text2sim.evidence.recorded_case import RecordedCase
from text2sim.evidence.selection import RecordedTarget
from text2sim.recording.states import Array
from text2sim.spec_schema.models.case import Case
from text2sim.spec_schema.names.selectors import body_of, strings_in

MAX_REST_DISPLACEMENT = 2e-4
"""Displacement per frame below which something is at rest [m]."""
INTEGRATION_SLACK = 0.05
"""Tolerated integration error, as a fraction of the displacement."""
SOFT_SLACK = 0.5
"""The same for deformable bodies."""
MOTOR_SLACK = 0.5
"""The same for bodies that a drive moves: a target changes once per step, so that the velocity at the end of a step is
the lowest of it. Of a slider of 0.3 kg with a time constant of 15 ms it was 0.80 of the mean, at steps of 10 ms."""
GRAVITY_SLACK = 0.5
"""Tolerated unexplained acceleration, as a fraction of gravity."""
CONTACT_SLACK = 0.2
"""Additional tolerance, as a fraction of the acceleration by contacts."""
REFERENCE_GRAVITY = 9.81
"""Reference acceleration in a scene without gravity [m/s2]."""
MIN_UNEXPLAINED_SHARE, MIN_UNEXPLAINED_FRAMES = 0.2, 3
"""Smallest unexplained fraction of the path of its links, and number of frames, from which a body is keyframed."""
MIN_UNEXPLAINED_PATH = 0.1
"""Path [m] of a link over unexplained frames in a row from which its body is keyframed, however far it falls besides.
Where bodies crowd, unexplained frames are scattered."""
MIN_JUMP = 0.05
"""Displacement in one frame beyond what velocities explain that counts as a jump [m]."""


@dataclass(frozen=True)
class Motion:
    """Keyframed and driven motion of a run."""

    keyframed: dict[str, str]
    """Copies that no force moves, and the evidence."""
    driven: dict[str, float]
    """Bodies with prescribed motion, and their fraction of the total path length."""
    part: float
    """Fraction of the total path length that is keyframed, 0 to 1."""
    looked_at: int
    """Number of copies that were checked."""

    @property
    def mainly_keyframed(self) -> bool:
        """Whether most of the motion is keyframed."""
        return self.part > 0.5

    def rows(self) -> list[str]:
        """Return the summary for a judge, one sentence per row."""
        rows = [f"`{copy}` is moved by no force: {why}" for copy, why in list(self.keyframed.items())[:12]]
        rows += [
            f"`{name}` moves along a prescribed path (`driven`), {100 * part:.0f} % of all paths in the scene"
            for name, part in self.driven.items()
        ]
        if not self.keyframed:
            rows.append(f"of {self.looked_at} bodies that move freely, none has positions that no force explains")
        return rows


def motion_of(recording: RecordedCase) -> Motion:
    """Detect motion that recorded velocities, gravity and contacts do not explain.

    For each link and deformable body, the displacement d of the centre between frames must agree with the velocities at
    both ends: |d - h (v0 + v1) / 2| <= h |v1 - v0| / 2, with a tolerance of 5 % (50 % for deformable bodies and those
    that a drive moves) and 0.2 mm. For each free rigid body, momentum must change by gravity and contacts alone,
    m (v1 - v0) = m g h + sum(F dt), with a tolerance of half of gravity and a fifth of the contact forces. This second
    check is skipped if controls act on the body, if the scene has deformable bodies (their contacts are not recorded),
    or if the contact model does not report forces. A body is keyframed if it jumps, if a fifth of the path of its links
    is unexplained, or 0.1 m of it in a row: where many crowd, some frames of some of them always are. A deformable body
    that is attached must only not jump.
    """
    keyframed: dict[str, str] = {}
    distances: dict[str, float] = {}
    given = _impulses(recording)
    for target in recording.names.loose:
        moved, odd, worst = _unexplained_motion(recording, target, given)
        distances[target.copy] = float(moved.max(axis=1).sum())
        moving = moved > MAX_REST_DISPLACEMENT
        share = float(moved[odd & moving].sum() / moved[moving].sum()) if moving.any() else 0.0
        far = _longest_run(moved, odd & moving)
        if worst[0] > MIN_JUMP:
            keyframed[target.copy] = (
                f"it jumps by {worst[0]:.2g} m more than its velocity explains, at {worst[1]:.3g} s"
            )
        elif (odd & moving).any(axis=1).sum() < MIN_UNEXPLAINED_FRAMES:
            continue
        elif share >= MIN_UNEXPLAINED_SHARE:
            keyframed[target.copy] = f"its positions do not follow from forces in {100 * share:.0f} % of its path"
        elif far > MIN_UNEXPLAINED_PATH:
            keyframed[target.copy] = f"its positions do not follow from forces over {far:.2g} m in a row"
    driven: dict[str, float] = {}
    for copy in recording.names.driven:
        steps = np.diff(recording.origin(recording.names.copies[copy]), axis=0)  # nan after it was removed
        distance = float(np.nansum(np.linalg.norm(steps, axis=1)))
        driven[body_of(copy)] = driven.get(body_of(copy), 0.0) + distance
    whole = sum(distances.values()) + sum(driven.values())
    part = sum(distances[copy] for copy in keyframed) / whole if whole > MAX_REST_DISPLACEMENT else 0.0
    driven = {name: distance / whole if whole > MAX_REST_DISPLACEMENT else 0.0 for name, distance in driven.items()}
    return Motion(keyframed, driven, part, len(distances))


def _longest_run(moved: Array, odd: Array) -> float:
    """Return the longest path [m] of a link over frames in a row that are odd; both arrays are (F-1, L)."""
    best, now = 0.0, np.zeros(moved.shape[1])
    for distance, wrong in zip(moved, odd, strict=True):
        now = np.where(wrong, now + distance, 0.0)
        best = max(best, float(now.max()))
    return best


def _impulses(recording: RecordedCase) -> tuple[Array, Array]:
    """Contact impulses on each link per frame [N s], (F, L, 3), and the sums of their magnitudes, (F, L)."""
    states, log = recording.states, recording.contacts
    shape = states.frames + 1, len(states.links)
    impulse, size = np.zeros((*shape, 3)), np.zeros(shape)
    for side, sign in ((0, 1.0), (1, -1.0)):
        at = log.frame, log.links[:, side]
        np.add.at(impulse, at, sign * states.dt * log.force)
        np.add.at(size, at, states.dt * np.linalg.norm(log.force, axis=1))
    return impulse[:-1], size[:-1]


def _unexplained_motion(
    recording: RecordedCase, target: RecordedTarget, given: tuple[Array, Array]
) -> tuple[Array, Array, tuple[float, float]]:
    """Displacements [m] of links, (F-1, L), a mask of the unexplained ones, the largest jump [m] and its time [s]."""
    states = recording.states
    step = np.diff(states.time)[:, None]
    if target.soft is not None:
        centers = states.deformables[target.soft].center[:, None]
        velocities = states.soft_velocity[:, [target.soft]].astype(float)
    else:
        links = np.array([k for k in target.links if not states.links[k].fixed], dtype=int)
        centers, velocities = recording.centers(links), states.vel[:, links].astype(float)
    there = ~recording.gone(target.copy)
    if centers.shape[0] < 2 or not centers.shape[1]:
        return np.zeros((0, 1)), np.zeros((0, 1), bool), (0.0, 0.0)
    steps = np.diff(centers, axis=0)
    before, after = velocities[:-1], velocities[1:]
    gap = np.linalg.norm(steps - step[..., None] * (before + after) / 2, axis=-1)
    moved = np.linalg.norm(steps, axis=-1)
    controls = {control.kind for control in _controls_on(recording.case, body_of(target.copy))}
    slack = SOFT_SLACK if target.soft is not None else MOTOR_SLACK if "drive" in controls else INTEGRATION_SLACK
    bound = step * np.linalg.norm(after - before, axis=-1) / 2 + slack * moved + MAX_REST_DISPLACEMENT
    present = (there[:-1] & there[1:])[:, None]
    odd = (gap > bound) & present
    beyond = np.where(odd, gap - bound, 0.0).max(axis=1)
    # Fast bodies have large errors; a jump is the displacement of a body whose velocity does not move it.
    fast = step[:, 0] * np.linalg.norm(velocities, axis=-1).max(axis=1)[:-1]
    beyond = np.where(beyond > 2 * fast, beyond, 0.0)
    at = int(beyond.argmax())
    if target.soft is not None and "attach" in controls:
        odd[:] = False  # the pull of its holder is in the velocity of a point, but not yet in its displacement
    if _is_free(recording, target):
        odd[:, 0] |= _without_cause(recording, target, given, before[:, 0], after[:, 0]) & present[:, 0]
    return np.where(present, moved, 0.0), odd, (float(beyond[at]), float(states.time[at + 1]))


def _without_cause(
    recording: RecordedCase, target: RecordedTarget, given: tuple[Array, Array], before: Array, after: Array
) -> Array:
    """Mask of the frames in which momentum changes by more than gravity and contacts explain, shape (F-1,)."""
    states = recording.states
    mass, gravity = states.links[target.root].mass, np.array(states.gravity)
    span = np.diff(states.time)
    impulse, size = (part[1:, target.root] / mass for part in given)
    odd = np.linalg.norm((after - before - impulse) / span[:, None] - gravity, axis=1)
    usual = float(np.linalg.norm(gravity)) or REFERENCE_GRAVITY
    return odd > GRAVITY_SLACK * usual + CONTACT_SLACK * size / span


def _is_free(recording: RecordedCase, target: RecordedTarget) -> bool:
    """Whether all forces on a body are recorded: free and rigid, among rigid bodies, without controls."""
    states, case = recording.states, recording.case
    if target.soft is not None or len(target.links) != 1 or states.links[target.root].mass <= 0:
        return False
    joints = [joint for joint in states.joints if joint.link == target.root and joint.kind != "free"]
    contacts_known = recording.contacts.recorded and not states.deformables
    return contacts_known and not joints and not any(_controls_on(case, body_of(target.copy)))


def _controls_on(case: Case, body: str) -> Iterator[Any]:
    """Yield the controls that may act on a body: those that name it, or have no target, such as wind."""
    for control in case.actions.controls.values():
        if control.kind == "initial_velocity":
            continue
        named = {body_of(word) for word in strings_in(control.model_dump(mode="json"))}
        if body in named or not named & case.bodies.keys():
            yield control
