"""Tiny cases, compiled by our compiler, run by the programs it writes, and judged from the states they record."""

import itertools
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from warm_engine import WarmEngine

from text2sim.compiler.build import compile_case
from text2sim.evidence.measures import evaluate
from text2sim.evidence.recorded_case import RecordedCase
from text2sim.evidence.selection import RecordedTarget
from text2sim.recording.states import Array, LinkRecord, RunStates
from text2sim.recording.vectors import rotate
from text2sim.spec_schema.load import load_case
from text2sim.spec_schema.models.case import Case


@dataclass(frozen=True)
class Trial:
    """A recorded case. Arrays over frames are float64, shape (F, 3) unless said otherwise; names are selectors."""

    folder: Path
    """Of the run: `program/`, `states/`, `geometry/`."""
    case: Case

    @cached_property
    def recording(self) -> RecordedCase:
        return RecordedCase.load(self.folder, self.case)

    @property
    def states(self) -> RunStates:
        return self.recording.states

    @property
    def time(self) -> Array:
        """Times of the frames [s], shape (F,)."""
        return self.states.time

    def _target(self, name: str) -> RecordedTarget:
        (target,) = self.recording.names.select(name)
        return target

    def link(self, name: str) -> LinkRecord:
        """Mass, centre and inertia of the (first) link of a body."""
        return self.states.links[self._target(name).root]

    def pos(self, name: str) -> Array:
        """Origin [m]."""
        return self.states.pos[:, self._target(name).root].astype(float)

    def com(self, name: str) -> Array:
        """Centre of mass of the (first) link [m]."""
        return self.pos(name) + rotate(self.quat(name), np.array(self.link(name).com))

    def quat(self, name: str) -> Array:
        """Orientation (w, x, y, z), shape (F, 4)."""
        return self.states.quat[:, self._target(name).root].astype(float)

    def turn(self, name: str) -> Array:
        """Rotation matrices, from the body's frame to the world's, shape (F, 3, 3)."""
        quat = self.quat(name)
        return np.stack([rotate(quat, axis) for axis in np.eye(3)], axis=-1)

    def vel(self, name: str) -> Array:
        """Velocity of the centre of mass of the (first) link [m/s]."""
        return self.states.vel[:, self._target(name).root].astype(float)

    def ang(self, name: str) -> Array:
        """Angular velocity [rad/s]."""
        return self.states.ang[:, self._target(name).root].astype(float)

    def spin(self, name: str) -> Array:
        """Angular momentum about the centre of mass of the (first) link [kg m2/s]: R I R' w."""
        turn, inertia = self.turn(name), np.array(self.link(name).inertia)
        return np.einsum("fij,jk,flk,fl->fi", turn, inertia, turn, self.ang(name))

    def joint(self, name: str) -> tuple[Array, Array, Array]:
        """Position, velocity and motor force of a hinge or slider, each of shape (F,)."""
        ((_, joint),) = self.recording.names.select_joints(name)
        columns = (
            self.states.qpos[:, joint.q[0]],
            *(rows[:, joint.dof[0]] for rows in (self.states.dofs_velocity, self.states.dofs_force)),
        )
        q, dq, force = (column.astype(float) for column in columns)
        return q, dq, force

    def contact(self, a: str, b: str) -> tuple[Array, Array, Array]:
        """Steps (n,), forces on `a` (n, 3) [N] and depths (n,) [m] of the contacts of two bodies, over all steps."""
        log = self.states
        first, second = (list(self._target(name).links) for name in (a, b))
        links = log.contact("links")
        forth = np.isin(links[:, 0], first) & np.isin(links[:, 1], second)
        back = np.isin(links[:, 1], first) & np.isin(links[:, 0], second)
        rows = forth | back
        sign = np.where(back, 1.0, -1.0)[rows, None]
        return log.contact("step")[rows], sign * log.contact("force")[rows], log.contact("penetration")[rows]

    def measure(self, name: str) -> Array:
        """A measure of the case, shape (F,)."""
        series = evaluate(self.recording)[name]
        assert not series.problem, series.problem
        return series.values


Simulate = Callable[..., Trial]
Agree = Callable[..., None]
LEDGER = pytest.StashKey[list[tuple[str, ...]]]()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Those that need another process for the engine come last."""
    items.sort(key=lambda item: item.path == Path(__file__).with_name("test_determinism.py"))


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """With -v, print every comparison that was made."""
    rows = config.stash.get(LEDGER, [])
    if rows and terminalreporter.verbosity > 0:
        terminalreporter.section("physics: measured against theory")
        head = ("check", "theory", "measured", "difference", "tolerance")
        widths = [max(len(row[k]) for row in [head, *rows]) for k in range(len(head))]
        for row in [head, *rows]:
            terminalreporter.line("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)))


@pytest.fixture
def agree(request: pytest.FixtureRequest) -> Agree:
    """Return a function that compares a measured value with theory; what it compared is in the summary of `-v`.

    It takes what is compared, the measured value, the value of theory (numbers or arrays of one shape), and the
    tolerance as an absolute difference.
    """
    rows = request.config.stash.setdefault(LEDGER, [])

    def compare(what: str, measured: Any, theory: Any, *, within: float) -> None:
        measured, theory = np.broadcast_arrays(np.asarray(measured, float), np.asarray(theory, float))
        assert np.isfinite(measured).all(), f"{what}: not finite"
        gaps = np.abs(measured - theory)
        worst = np.unravel_index(gaps.argmax(), gaps.shape)
        numbers = (theory[worst], measured[worst], gaps[worst], within)
        rows.append((what, *(f"{number:.6g}" if k < 2 else f"{number:.2g}" for k, number in enumerate(numbers))))
        where = f" at {tuple(map(int, worst))}" if gaps.ndim else ""
        assert gaps[worst] <= within, (
            f"{what}: measured {measured[worst]:.9g}, theory {theory[worst]:.9g}{where}, "
            f"difference {gaps[worst]:.3g} > {within:.3g}"
        )

    return compare


@pytest.fixture(scope="session")
def simulate(warm_engine: WarmEngine, tmp_path_factory: pytest.TempPathFactory) -> Simulate:
    """Return a function that simulates a case.

    It takes the text below `name`, the contents of files of the case by their paths, and values for the names that the
    text uses in `${...}`.
    """
    count = itertools.count()

    def run(text: str, files: Mapping[str, str] | None = None, **params: Any) -> Trial:
        folder = tmp_path_factory.mktemp(f"trial_{next(count)}_", numbered=False)
        for path, content in (files or {}).items():
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            (folder / path).write_text(content)
        head = {"text2sim": 1, "name": "trial", "params": params}
        lines = [f"{key}: {json.dumps(value)}" for key, value in head.items()]
        (folder / "case.yaml").write_text("\n".join(lines) + "\n" + text)
        loaded = load_case(folder)
        compile_case(loaded, folder / "program")
        warm_engine.run(folder / "program", folder)
        return Trial(folder, loaded.case)

    return run


def rows(states, body):
    """Points of a deformable body over time, (F, n, 3), and the velocity of its centre of mass, (F, 3)."""
    index = next(k for k, one in enumerate(states.deformables) if one.body == body)
    return states.deformables[index].points.astype(float), states.soft_velocity[:, index].astype(float)
