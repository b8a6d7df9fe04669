"""Forces of springs and their work, from recordings whose every number is known."""

import json

import numpy as np
import pytest

from text2sim.evidence.diagnostics import energy_account
from text2sim.evidence.measures import evaluate
from text2sim.evidence.recorded_case import RecordedCase

K, C, LENGTH = 50.0, 2.0, 0.5


@pytest.fixture
def swung(new_run, make_case):
    """A ball that swings about x = 0.6 by 0.2 m, on a spring from the origin."""

    def one(form="coil", start=0.0, end=1e9, length=LENGTH):
        run = new_run(duration=1.0, dt=0.001)
        x, v = 0.6 + 0.2 * np.cos(8 * run.time), -1.6 * np.sin(8 * run.time)
        run.add_link("floor", fixed=True, mass=1e9)
        run.add_link("ball", mass=2.0, pos=np.outer(x, [1, 0, 0]), vel=np.outer(v, [1, 0, 0]))
        layout = run.write() / "states" / "layout.json"
        row = {"control": "pull", "links": [1, 0], "points": [[0, 0, 0], [0, 0, 0]], "stiffness": K, "damping": C}
        row |= {"length": length, "pulls_only": form == "cord", "start": start, "end": end}
        layout.write_text(json.dumps(json.loads(layout.read_text()) | {"springs": [row]}))
        control = {"kind": "spring", "form": form, "body": "ball", "to": "floor", "stiffness": K}
        case = make_case(controls={"pull": control}, measures={"force": {"kind": "spring_force", "spring": "pull"}})
        return RecordedCase.load(run.folder, case), x, v

    return one


def test_a_coil_pulls_and_pushes(swung):
    recording, x, v = swung()
    series = evaluate(recording)["force"]
    assert series.unit == "N"
    np.testing.assert_allclose(series.values, K * (x - LENGTH) + C * v, atol=1e-4)
    assert series.values.min() < 0


def test_a_cord_only_pulls(swung):
    recording, x, v = swung(form="cord")
    pull = np.maximum(K * (x - LENGTH) + C * v, 0.0)
    np.testing.assert_allclose(evaluate(recording)["force"].values, np.where(x > LENGTH, pull, 0.0), atol=1e-4)


def test_a_spring_acts_in_its_span_and_its_length_is_that_as_it_begins(swung):
    recording, x, v = swung(start=0.3, end=0.6, length=None)
    values, time = evaluate(recording)["force"].values, recording.states.time
    acting = (time >= 0.3) & (time < 0.6)
    np.testing.assert_allclose(values[acting], (K * (x - x[300]) + C * v)[acting], atol=1e-4)
    assert not values[~acting].any()


def test_its_work_is_what_it_stored_less_what_its_damping_took(swung):
    """K (x0 - L)^2 / 2 - k (x1 - L)^2 / 2 - c integral of v^2, which is (1.6)^2 (t / 2 - sin(16 t) / 32)."""
    recording, x, _ = swung()
    stored = 0.5 * K * (x[[0, -1]] - LENGTH) ** 2
    lost = C * 1.6**2 * (0.5 - np.sin(16.0) / 32)
    assert energy_account(recording)["works"]["controls"]["pull"] == pytest.approx(
        stored[0] - stored[1] - lost, rel=1e-3
    )
