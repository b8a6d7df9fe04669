"""The benchmark of rendering: what it says of noise agrees with how errors fall."""

import re

import pytest
from filmed import MakeRun

from benchmarks.rendering import equal
from text2sim.recording.film_record import read_recording
from text2sim.rendering.film import Filming


@pytest.mark.usefixtures("tracer")
def test_equal_pictures_are_told_from_noisy_ones(make_run: MakeRun) -> None:
    run = make_run(
        {"slab": {"half": (3, 3, 0.05), "pos": (0, 0, 0)}, "box": {"half": (0.3, 0.3, 0.3), "pos": (0, 0, 0.4)}}
    )
    filming = Filming(read_recording(run), "draft", size=(64, 36))
    told = equal(filming, filming.reels()[0].frames[0])
    figures = re.findall(r"off by ([\d.]+)|would need (\d+) samples", told)
    bare, whole, samples = float(figures[0][0]), float(figures[1][0]), float(figures[2][1])
    assert 0 < whole < bare < 30
    # The error of n samples is proportional to 1 / sqrt(n); the printed errors are rounded to 0.05.
    least, most = (8 * ((bare + d) / (whole - d)) ** 2 for d in (-0.05, 0.05))
    assert least - 1 <= samples <= most + 1
