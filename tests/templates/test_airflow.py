"""Gusts that the air carries along."""

from types import ModuleType, SimpleNamespace
from typing import Any
from unittest.mock import MagicMock

import numpy as np
import pytest
from program_modules import load_module


@pytest.fixture(scope="module")
def airflow() -> ModuleType:
    """The module as a program has it, without the engine."""
    points = SimpleNamespace(Points=None, each_substep=None, tensor=None)
    quadrants = MagicMock(kernel=lambda f: f, func=lambda f: f)
    return load_module("airflow", points=points, genesis=MagicMock(), torch=MagicMock(), quadrants=quadrants)


def flow(airflow: ModuleType, **more: Any) -> Any:
    made = airflow.Airflow.__new__(airflow.Airflow)
    made.waves, made.sways, made.phases = airflow.frozen_gusts(1.5, np.random.default_rng(3))
    vars(made).update({"gusts": 0.2, "now": np.array([5.0, 0, 0]), "carried": np.zeros(3)} | more)
    return made


PLACES = np.random.default_rng(1).uniform(-40, 40, (20_000, 3))


def test_gusts_are_as_strong_as_asked(airflow: ModuleType) -> None:
    gusts = flow(airflow).air(PLACES) - (5, 0, 0)
    # Waves of random phase are independent: over many wavelengths their mean is 0 within rms / sqrt(n).
    assert np.abs(gusts.mean(axis=0)).max() < 0.03
    assert np.sqrt(np.square(gusts).sum(axis=1).mean() / 3) == pytest.approx(0.2 * 5, rel=0.02)
    assert flow(airflow, gusts=0.0).air(PLACES).tolist() == [5, 0, 0]
    assert not flow(airflow, now=np.zeros(3)).air(PLACES).any()


def test_they_do_not_diverge_and_travel_with_the_air(airflow: ModuleType) -> None:
    one, step = flow(airflow), 1e-4
    along = [(one.air(PLACES[:50] + step * e) - one.air(PLACES[:50] - step * e))[:, k] for k, e in enumerate(np.eye(3))]
    steepest = np.abs(along).max() / (2 * step)
    assert np.abs(sum(along)).max() / (2 * step) < 1e-5 * steepest
    later = flow(airflow, carried=np.array([2.5, 0, 0]))
    np.testing.assert_allclose(later.air(PLACES + (2.5, 0, 0)), one.air(PLACES), atol=1e-9)
    longest = 2 * np.pi / np.linalg.norm(one.waves, axis=1)
    assert (longest.max(), longest.min()) == (pytest.approx(1.5), pytest.approx(1.5 / 4))
