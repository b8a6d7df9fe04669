"""Schedules: what the compiler computes, and what the program's functions of the same names do."""

import numpy as np
import pytest
from jinja2 import Environment
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

from text2sim.compiler.emit import TEMPLATES
from text2sim.compiler.schedules import constructor, slopes, value_at
from text2sim.spec_schema.models.motion import Piecewise, Sine

TIMES, VALUES = [0.5, 1.0, 2.0, 2.5, 4.0], [0.0, 0.3, 0.4, 1.0, 0.2]


def schedule(ease):
    return Piecewise(kind="piecewise", times=TIMES, values=VALUES, ease=ease)


def test_a_spline_goes_through_every_value_and_beyond_none():
    wanted = PchipInterpolator(TIMES, VALUES).derivative()(TIMES)
    found = slopes(TIMES, VALUES)
    np.testing.assert_allclose(found[1:-1], wanted[1:-1], rtol=1e-12)  # the same formula between the ends
    assert found[0] == found[-1] == 0.0
    assert found[3] == 0.0  # where it turns back
    t = np.linspace(0, 5, 501)
    values = np.array([value_at(schedule("spline"), x) for x in t])
    inside = (t > TIMES[0]) & (t < TIMES[-1])
    np.testing.assert_allclose(values[inside], CubicHermiteSpline(TIMES, VALUES, found)(t[inside]), atol=1e-12)
    assert values.min() >= 0.0
    assert values.max() <= 1.0


def test_smooth_is_at_rest_at_every_value():
    h = 1e-4
    for time in TIMES[1:-1]:
        one = schedule("smooth")
        assert abs(value_at(one, time + h) - value_at(one, time - h)) / (2 * h) < 1e-3


FADING = Sine(kind="sine", amplitude=2, frequency=3, offset=1, phase_deg=30, start=0.5, end=4, fade=1)
BURST = Sine(kind="sine", amplitude=2, frequency=3, start=0.5, end=4)


def test_a_fading_sine_sets_off_and_stops_at_rest():
    h = 1e-4
    for time in (0.5, 4.0):
        assert value_at(FADING, time) == pytest.approx(1.0)
        assert abs(value_at(FADING, time + h) - value_at(FADING, time - h)) / (2 * h) < 0.01
    assert value_at(FADING, 5.0) == value_at(FADING, 0.1) == 1.0
    assert value_at(FADING, 2.0) == value_at(FADING.model_copy(update={"end": None, "fade": 0.0}), 2.0)
    with pytest.raises(ValueError, match="later than start by two `fade`"):
        Sine(kind="sine", amplitude=1, frequency=1, end=1, fade=0.6)


@pytest.mark.parametrize("ease", ["linear", "smooth", "spline", FADING, BURST])
def test_the_program_computes_the_same(ease):
    source = (TEMPLATES / "actions" / "schedules.py.j2").read_text()
    names: dict = {}
    text = Environment(trim_blocks=True).from_string(source).render(splines=True, fading=True)
    exec("import math\nfrom bisect import bisect_right\nimport numpy as np\n" + text, names)
    one = schedule(ease) if isinstance(ease, str) else ease
    made = eval(constructor(one), names)
    for t in np.linspace(0, 5, 97):
        assert made(t) == pytest.approx(value_at(one, t), abs=1e-9)
