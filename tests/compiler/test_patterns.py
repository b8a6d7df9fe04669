import math

import numpy as np
import pytest
from pydantic import TypeAdapter

from text2sim.compiler.placing.packing import PackingError, grain_of, pack
from text2sim.compiler.placing.patterns import bond_slots, copy_count, copy_variables, pattern_slots
from text2sim.compiler.shapes.extents import extents
from text2sim.compiler.shapes.geometry import pieces
from text2sim.compiler.shapes.gjk import distance
from text2sim.compiler.shapes.rotation import IDENTITY, quat_rotate
from text2sim.compiler.shapes.solid import solids
from text2sim.spec_schema.models.repeat import Repeat
from text2sim.spec_schema.models.shapes import Box, Cylinder, Sphere


def make(kind, **fields):
    return TypeAdapter(Repeat).validate_python({"kind": kind, **fields})


def offsets(repeat):
    return np.array([slot.offset for slot in pattern_slots(repeat)])


class TestPatterns:
    def test_a_line_steps(self):
        np.testing.assert_allclose(
            offsets(make("line", count=3, step=(0.1, 0, 0.2))), [(0, 0, 0), (0.1, 0, 0.2), (0.2, 0, 0.4)]
        )

    def test_a_grid_is_centred_and_rises(self):
        grid = make("grid", counts=(2, 3, 2), spacing=(1.0, 2.0, 3.0))
        found = offsets(grid)
        assert len(found) == copy_count(grid) == 12
        assert tuple(found[0]) == (-0.5, -2, 0)
        assert tuple(found[1]) == (0.5, -2, 0)
        assert tuple(found[-1]) == (0.5, 2, 3)
        variables = copy_variables(grid)
        assert variables[-1] == {"i": 11, "n": 12, "u": 1.0, "row": 2, "column": 1, "layer": 1}
        assert [v["column"] for v in variables[:4]] == [0, 1, 0, 1]

    def test_a_whole_ring_does_not_repeat_its_first_copy(self):
        ring = pattern_slots(make("ring", count=4, radius=2.0, start_deg=90.0))
        assert [tuple(np.round(s.offset, 12)) for s in ring] == [(0, 2, 0), (-2, 0, 0), (0, -2, 0), (2, 0, 0)]
        assert quat_rotate(ring[0].turn, (1, 0, 0)) == pytest.approx((0, 1, 0))

    def test_an_arc_ends_with_a_copy(self):
        arc = pattern_slots(make("ring", count=3, radius=1.0, arc_deg=180.0, turn=False))
        assert arc[-1].offset == pytest.approx((-1, 0, 0))
        assert arc[-1].turn == IDENTITY

    def test_a_spiral_is_evenly_spaced_and_turned_along_itself(self):
        spiral = make("spiral", count=40, inner_radius=0.14, spacing=0.05, pitch=0.1)
        slots = pattern_slots(spiral)
        found = np.array([s.offset for s in slots])
        radii = np.linalg.norm(found, axis=1)
        angles = np.unwrap(np.arctan2(found[:, 1], found[:, 0]))
        assert radii[0] == pytest.approx(0.14)
        np.testing.assert_allclose(radii, 0.14 + 0.1 * angles / (2 * math.pi))
        # Along the curve, by a fine polygon.
        fine = np.linspace(0, angles[-1], 200_001)
        r = 0.14 + 0.1 * fine / (2 * math.pi)
        steps = np.hypot(*np.diff([r * np.cos(fine), r * np.sin(fine)], axis=1))
        lengths = np.interp(angles, fine, np.concatenate([[0], np.cumsum(steps)]))
        np.testing.assert_allclose(np.diff(lengths), 0.05, rtol=1e-6)
        chord = (found[21] - found[19]) / np.linalg.norm(found[21] - found[19])
        assert np.dot(quat_rotate(slots[20].turn, (0, 1, 0)), chord) > 0.999
        inward = pattern_slots(spiral.model_copy(update={"outward": False}))
        assert [s.offset for s in inward] == [s.offset for s in slots[::-1]]
        turned = pattern_slots(spiral.model_copy(update={"start_deg": 90.0}))
        np.testing.assert_allclose([s.offset for s in turned], found @ [[0, 1, 0], [-1, 0, 0], [0, 0, 1]], atol=1e-12)


class TestRunningBond:
    BRICK = Box(kind="box", size=(0.24, 0.11, 0.07))

    def test_half_boxes_close_every_second_row(self):
        wall = make("running_bond", rows=3, columns=3, gap=0.01)
        slots = bond_slots(wall, self.BRICK)
        assert len(slots) == len(copy_variables(wall)) == copy_count(wall) == 10
        rows = [slots[:3], slots[3:7], slots[7:]]
        for k, row in enumerate(rows):
            edges = [
                (
                    s.offset[0] - (s.size or self.BRICK.size)[0] / 2,
                    s.offset[0] + (s.size or self.BRICK.size)[0] / 2,
                )
                for s in row
            ]
            assert edges[0][0] == pytest.approx(-0.37)
            assert edges[-1][1] == pytest.approx(0.37)
            assert [b[0] - a[1] for a, b in zip(edges, edges[1:], strict=False)] == pytest.approx(
                [0.01] * (len(row) - 1)
            )
            assert {round(s.offset[2], 12) for s in row} == {round(0.07 * k, 12)}
        assert rows[1][0].size == pytest.approx((0.115, 0.11, 0.07))
        # A joint of the lowest row is under the middle of a brick.
        assert rows[1][1].offset[0] == pytest.approx((rows[0][0].offset[0] + rows[0][1].offset[0]) / 2)
        assert [v["column"] for v in copy_variables(wall)[3:7]] == [0, 1, 2, 3]

    def test_open_ends_are_toothed(self):
        slots = bond_slots(make("running_bond", rows=2, columns=2, ends="open"), self.BRICK)
        assert [s.offset[0] for s in slots] == pytest.approx([-0.18, 0.06, -0.06, 0.18])
        assert not any(s.size for s in slots)

    def test_a_gap_that_eats_the_half_box_is_refused(self):
        with pytest.raises(ValueError, match="smaller than the box's length"):
            bond_slots(make("running_bond", rows=2, columns=2, gap=0.3), self.BRICK)


DRUM = {"kind": "cylinder", "center": (0, 0, 1), "radius": 0.4, "height": 0.48, "axis": "y"}
CUBE = Box(kind="box", size=(0.05, 0.05, 0.05))


def packed(shape, count, region, **fields):
    packing = make("packing", count=count, region=region, **fields)
    grain = grain_of(shape.kind, extents(shape, IDENTITY, None))
    return pack(packing, [grain] * count, [IDENTITY] * count)


def least_distance(shape, spots):
    """Over all pairs that could be near."""
    centers = np.array([pos for pos, _ in spots])
    placed = [solids(pieces(shape, None), *spot)[0] for spot in spots]
    apart = np.linalg.norm(centers[:, None] - centers[None], axis=-1)
    near = np.argwhere(np.triu(apart < 2 * placed[0].ball + 0.01, 1))
    return min(distance(placed[i], placed[j]) for i, j in near)


class TestPacking:
    @pytest.mark.parametrize("count", [250, 350])
    def test_cubes_fill_a_drum_loosely(self, count):
        spots = packed(CUBE, count, DRUM)
        assert least_distance(CUBE, spots) >= 0.001 - 1e-9
        cube = [(x, y, z) for x in (-0.025, 0.025) for y in (-0.025, 0.025) for z in (-0.025, 0.025)]
        corners = np.array([[np.add(pos, quat_rotate(quat, v)) for v in cube] for pos, quat in spots])
        assert np.hypot(corners[..., 0], corners[..., 2] - 1).max() <= 0.4
        assert np.abs(corners[..., 1]).max() <= 0.24
        # The whole drum is in use: the middle is where the drum's is, within a tenth of its size.
        np.testing.assert_allclose(np.mean([pos for pos, _ in spots], axis=0), (0, 0, 1), atol=0.04)

    def test_the_seed_decides(self):
        assert packed(CUBE, 50, DRUM, seed=3) == packed(CUBE, 50, DRUM, seed=3)
        assert packed(CUBE, 50, DRUM, seed=3) != packed(CUBE, 50, DRUM, seed=4)

    def test_spheres_and_upright_cylinders(self):
        box = {"kind": "box", "min": (0, 0, 0), "max": (1, 1, 0.5)}
        balls = packed(Sphere(kind="sphere", radius=0.04), 300, box, gap=0.005)
        centers = np.array([pos for pos, _ in balls])
        apart = np.linalg.norm(centers[:, None] - centers[None], axis=-1) + np.eye(300)
        assert apart.min() >= 0.085
        assert centers.min() >= 0.04
        assert (centers.max(0) <= (0.96, 0.96, 0.46)).all()
        cans = Cylinder(kind="cylinder", radius=0.05, height=0.12)
        spots = packed(cans, 60, box, turn="yaw")
        assert all(quat_rotate(quat, (0, 0, 1)) == pytest.approx((0, 0, 1)) for _, quat in spots)
        assert least_distance(cans, spots) >= 0.001 - 1e-9

    def test_a_tight_box_is_filled_on_a_lattice(self):
        room = {"kind": "box", "min": (0, 0, 0), "max": (0.204, 0.204, 0.204)}
        spots = packed(CUBE, 64, room)
        assert least_distance(CUBE, spots) >= 0.001 - 1e-9
        with pytest.raises(PackingError, match="about 64 of 65"):
            packed(CUBE, 65, room)

    def test_more_volume_than_room_is_refused_at_once(self):
        with pytest.raises(PackingError, match=r"0.25 m3, the region 0.241 m3"):
            packed(CUBE, 2000, DRUM)
