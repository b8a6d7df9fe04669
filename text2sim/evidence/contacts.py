"""Contacts: which bodies touched when, and the momentum that they exchanged.

A recorded force is the mean over the substeps of a step, so force times dt is the momentum exchanged.
"""

from dataclasses import dataclass, fields
from functools import cached_property
from typing import TypeVar

import numpy as np

from text2sim.compiler.soft.solvers import contact_model
from text2sim.evidence.selection import RecordedNames
from text2sim.recording.states import Array, RunStates

MODELS_WITHOUT_CONTACTS = ("sap", "ipc")
"""Contact models for which the engine reports no contacts."""
MAX_GAP_STEPS = 2
"""Steps without contact that do not end an episode: touches flicker in a discrete simulation."""
IMPACT_SPAN = 0.05
"""Span [s] at the beginning of an episode over which the impulse of the impact is taken."""


@dataclass(frozen=True)
class Touches:
    """Touches of pairs of things, one row per pair and time step, sorted by pair, then step."""

    pair: Array
    """Numbers (first, second) of the pair, shape (n, 2)."""
    step: Array
    """(n,)"""
    force: Array
    """On the first of the pair [N], world, shape (n, 3)."""
    normal: Array
    """Sum of the normal forces [N], (n,)."""
    depth: Array
    """Deepest overlap [m], (n,)."""
    pos: Array
    """Where the largest force acts [m], (n, 3)."""


@dataclass(frozen=True)
class Episodes:
    """Spans of time during which pairs of things touched, one row each, sorted by pair, then start."""

    pair: Array
    """Numbers (first, second) of the pair, shape (n, 2)."""
    start: Array
    """Time of the first touch [s], (n,)."""
    end: Array
    """Time of the last touch [s], (n,)."""
    ongoing: Array
    """Whether they still touched when the recording ended, (n,)."""
    pos: Array
    """Where they first touched [m], (n, 3)."""
    impulse: Array
    """Given to the first by the second [N s], world, (n, 3)."""
    normal_impulse: Array
    """Integral of the normal force [N s], (n,)."""
    impact_impulse: Array
    """Size of the momentum given in the first 50 ms [N s], (n,)."""
    peak_force: Array
    """Largest normal force in a step [N], (n,)."""
    depth: Array
    """Deepest overlap [m], (n,)."""


Rows = TypeVar("Rows", Touches, Episodes)


def choose(rows: Rows, chosen: Array) -> Rows:
    """Return the rows selected by a mask or by indices."""
    return type(rows)(*(getattr(rows, column.name)[chosen] for column in fields(rows)))


@dataclass(frozen=True)
class ContactLog:
    """The recorded contacts of a run, one row per pair of surfaces and time step.

    A surface is a link, or a part of a link that is a compound; see `RunStates.surface_links`.
    """

    states: RunStates
    why_not: str = ""
    """Why there are none, if the case did not ask for them, or its contact model does not report them."""
    last_step: int = 0
    """Last step that was recorded."""

    @classmethod
    def of(cls, names: RecordedNames) -> "ContactLog":
        """Return the contacts of a recording."""
        states, case = names.states, names.case
        model = contact_model(case.bodies.values(), case.scene)
        why_not = (
            f"contact model {model} does not report the contacts of rigid bodies"
            if model in MODELS_WITHOUT_CONTACTS
            else ""
        )
        if not case.scene.record.contacts:
            why_not = "no contacts were recorded (scene.record.contacts is false)"
        return cls(states, why_not, int(states.steps[-1]) if states.frames else 0)

    @property
    def recorded(self) -> bool:
        """Whether contacts were recorded at all, even if nothing touched."""
        return not self.why_not

    @cached_property
    def step(self) -> Array:
        """Number of completed steps when the pair touched, 1 after the first, shape (n,)."""
        return self.states.contact("step").astype(np.int64)

    @cached_property
    def links(self) -> Array:
        """Indices of the two links of each row, (n, 2)."""
        return self.states.contact("links").astype(np.int64)

    @cached_property
    def force(self) -> Array:
        """Force on the first link of each row [N], shape (n, 3); the recording holds that on the second."""
        return -self.states.contact("force").astype(float)

    @cached_property
    def depth(self) -> Array:
        """Deepest overlap of each row [m], (n,)."""
        return self.states.contact("penetration").astype(float)

    @cached_property
    def normal(self) -> Array:
        """Normal force [N], (n,)."""
        return self.states.contact("normal_force").astype(float)

    @cached_property
    def pos(self) -> Array:
        """Contact point of each row [m], world, shape (n, 3)."""
        return self.states.contact("pos").astype(float)

    @cached_property
    def frame(self) -> Array:
        """Index of the first frame after the step of each row, shape (n,); F where there is none."""
        return np.searchsorted(self.states.steps, self.step, side="left")

    def between(self, first: Array, second: Array) -> Touches:
        """Return the touches between groups of surfaces, given the group number of each surface (-1 for none).

        Contacts within a group are ignored. A pair named by both sides is listed once, lower number first.
        """
        a, b = self.states.contact_surfaces.T
        forward = (first[a] >= 0) & (second[b] >= 0)
        backward = (first[b] >= 0) & (second[a] >= 0) & ~forward
        rows = np.flatnonzero(forward | backward)
        flip = backward[rows]
        ends = np.where(flip, first[b[rows]], first[a[rows]]), np.where(flip, second[a[rows]], second[b[rows]])
        pair = np.stack(ends, 1)
        if first is second:
            swap = pair[:, 0] > pair[:, 1]
            pair[swap] = pair[swap][:, ::-1]
            flip = flip ^ swap
            apart = pair[:, 0] != pair[:, 1]
            rows, pair, flip = rows[apart], pair[apart], flip[apart]
        return self._merge(rows, pair, np.where(flip, -1.0, 1.0))

    def _merge(self, rows: Array, pair: Array, sign: Array) -> Touches:
        normal = self.normal[rows]
        step = self.step[rows]
        # Within a pair and step the strongest contact comes first: its position represents all.
        order = np.lexsort((-normal, step, pair[:, 1], pair[:, 0]))
        rows, pair, step, normal, sign = rows[order], pair[order], step[order], normal[order], sign[order]
        begins = np.flatnonzero(_changes(pair[:, 0], pair[:, 1], step))
        if not len(begins):
            return Touches(pair[:0], step[:0], np.zeros((0, 3)), normal[:0], normal[:0], np.zeros((0, 3)))
        return Touches(
            pair[begins],
            step[begins],
            np.add.reduceat(self.force[rows] * sign[:, None], begins),
            np.add.reduceat(normal, begins),
            np.maximum.reduceat(self.depth[rows], begins),
            self.pos[rows[begins]],
        )

    def count_episodes(self, touches: Touches) -> int:
        """Return the number of episodes without constructing them."""
        return len(_begins(touches))

    def episodes(self, touches: Touches) -> Episodes:
        """Join touches of consecutive steps into episodes."""
        dt = self.states.dt
        begins = _begins(touches)
        if not len(begins):
            none = np.zeros(0)
            return Episodes(touches.pair, none, none, none, touches.force, touches.force, none, none, none, none)
        ends = np.append(begins[1:], len(touches.step)) - 1
        since = touches.step - np.repeat(touches.step[begins], ends - begins + 1)
        early = (since * dt < IMPACT_SPAN - 1e-9)[:, None]
        return Episodes(
            pair=touches.pair[begins],
            start=touches.step[begins] * dt,
            end=touches.step[ends] * dt,
            ongoing=touches.step[ends] >= self.last_step - MAX_GAP_STEPS,
            pos=touches.pos[begins],
            impulse=np.add.reduceat(touches.force, begins) * dt,
            normal_impulse=np.add.reduceat(touches.normal, begins) * dt,
            impact_impulse=np.linalg.norm(np.add.reduceat(touches.force * early, begins), axis=1) * dt,
            peak_force=np.maximum.reduceat(touches.normal, begins),
            depth=np.maximum.reduceat(touches.depth, begins),
        )


def _begins(touches: Touches) -> Array:
    new = _changes(touches.pair[:, 0], touches.pair[:, 1])
    new[1:] |= np.diff(touches.step) > MAX_GAP_STEPS + 1
    return np.flatnonzero(new)


def _changes(*columns: Array) -> Array:
    """Return a mask of the rows that differ from the previous one in any column; true for the first."""
    new = np.ones(len(columns[0]), dtype=bool)
    if len(new):
        new[1:] = np.logical_or.reduce([column[1:] != column[:-1] for column in columns])
    return new
