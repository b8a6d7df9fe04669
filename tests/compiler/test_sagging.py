"""Sheets that hang between two edges."""

from pathlib import Path

import numpy as np
import pytest

from text2sim.compiler.shapes.extents import extents
from text2sim.compiler.shapes.rotation import IDENTITY
from text2sim.compiler.shapes.softmesh import soft_surface
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.models.shapes import Sheet


@pytest.mark.parametrize("sag", [0.05, 0.4, 0.9])
def test_a_sheet_that_sags_is_as_long_as_ever(sag):
    sheet = Sheet(kind="sheet", size=(2.0, 0.8), sag=sag)
    net = soft_surface(sheet, Path(), 0.02)
    line = net.vertices[np.isclose(net.vertices[:, 1], -0.4)]
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    assert steps.sum() == pytest.approx(2.0, rel=1e-3)  # chords of a parabola
    assert steps == pytest.approx(steps.mean(), rel=0.02)
    assert line[:, 2].min() == pytest.approx(-sag, abs=1e-3)
    assert line[0, 2] == line[-1, 2] == 0.0
    if sag <= 0.4:  # as the language says of the edges
        assert line[-1, 0] - line[0, 0] == pytest.approx(2.0 - 8 / 3 * sag**2 / 2.0, rel=0.01)
    low, high = extents(sheet, IDENTITY, Path())
    assert low == pytest.approx(net.vertices.min(axis=0), abs=0.03)
    assert high == pytest.approx(net.vertices.max(axis=0), abs=0.03)


def test_a_sheet_hangs_no_deeper_than_it_is_long():
    text = "scene: {duration: 1, dt: 0.01}\nbodies: {s: {kind: cloth, shape: {kind: sheet, size: [1, 1], sag: 0.5}}}\n"
    with pytest.raises(Exception, match="sags by 0.45 m at most"):
        load_text("text2sim: 2\nname: s\n" + text)
