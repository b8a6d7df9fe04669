"""Patterns run along ropes, from link to link."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

from text2sim.recording.film_record import SurfaceLook, WornMesh
from text2sim.rendering.decorating import decorated, run_on
from text2sim.rendering.meshes import presentable
from text2sim.rendering.strands import is_strand, numbers_in_rows
from text2sim.templates.patterns import Decoration

OWN = (0.9, 0.9, 0.9)
LONG, RADIUS = 0.05, 0.02
LINK = WornMesh("rope", 3, Path("capsule.npz"), (0.0, 0.0, -LONG / 2), (1.0, 0.0, 0.0, 0.0), SurfaceLook(OWN))


def capsule(long=LONG):
    made = trimesh.creation.capsule(height=long, radius=RADIUS, count=(24, 24))
    return presentable(np.asarray(made.vertices), np.asarray(made.faces))


def test_links_in_a_row_are_numbered():
    rope = [replace(LINK, link=k) for k in (3, 4, 5)]
    alone = replace(LINK, body="pill", link=6)
    assert numbers_in_rows([*rope, alone, replace(alone, link=8)]) == {0: 0, 1: 1, 2: 2}


def test_links_of_ropes_begin_at_their_joints():
    assert is_strand(capsule(), LINK)
    assert not is_strand(capsule(0.03), LINK), "of a chain: their round ends do not overlap"
    assert not is_strand(capsule(), replace(LINK, pos=(0.0, 0.0, 0.0))), "a pill"


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("turn", [np.eye(3), np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]]), np.diag([1.0, -1, -1])])
def test_a_pattern_is_the_same_on_both_sides_of_a_joint(turned, turn):
    mesh, size = capsule(), 0.012  # no whole number of stripes on a link
    mesh = replace(mesh, vertices=mesh.vertices @ turn, normals=mesh.normals @ turn)
    plain, layer, _ = decorated(mesh, Decoration("checker", size, turned=turned), OWN, turn, strand=True)
    middle = np.array(LINK.pos)
    before, after = (run_on(plain, number * 2 * middle, turn, turned=turned) for number in (4, 5))
    standing = plain.vertices @ turn.T

    def around(made, z):
        rows = np.abs(standing[:, 2] - z) < 1e-9
        angle = np.arctan2(standing[rows, 1], standing[rows, 0])
        order = np.lexsort(np.column_stack([made.uvs[rows], np.round(angle, 6)]).T)
        return made.uvs[rows][order] / layer.period

    assert around(before, -LONG / 2) == pytest.approx(around(after, LONG / 2))
    along = around(before, -LONG / 2)[:, 0 if turned else 1] * (2 * size)
    assert np.ptp(along) < 1e-9
    cap = standing[:, 2] < -LONG / 2
    on_cap = plain.uvs[cap, 0 if turned else 1]
    assert np.ptp(on_cap) < 0.02 * RADIUS, "what shows of a round end at a bend has the colour of the joint"
