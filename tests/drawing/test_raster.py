"""The rasteriser against a ray caster that tests every triangle."""

import time

import numpy as np
import pytest
from pictures import hits

from text2sim.drawing.raster import Raster
from text2sim.drawing.view import PictureView, look, parallel, perspective

NEAR = 0.05


def cloud(count: int, size: float, seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return rng.uniform(-1, 1, (count, 1, 3)) + rng.uniform(-size, size, (count, 3, 3))


def rays(view: PictureView) -> tuple[np.ndarray, np.ndarray]:
    rows, columns = np.mgrid[: view.height, : view.width]
    start, way = view.sight(columns.ravel() + 0.5, rows.ravel() + 0.5)
    count = rows.size
    return np.broadcast_to(start.T, (count, 3)).astype(float), np.broadcast_to(way.T, (count, 3)).astype(float)


# The second camera stands among the triangles: many cross the plane of its eye.
VIEWS = {
    "outside": perspective((0.3, -4.0, 1.0), (0, 0, 0), (0, 0, 1), 40, (80, 60), NEAR),
    "inside": perspective((0.1, 0.2, -0.1), (1, 0, 0.2), (0, 0, 1), 75, (80, 60), NEAR),
    "parallel": parallel(look((3.0, 1.0, 2.0), (0.0, 0.0, 0.0)), (3.0, 1.0, 2.0), 22.0, (80, 60)),
}


@pytest.mark.parametrize("name", VIEWS)
def test_same_triangle_and_depth_as_a_ray_caster(name: str) -> None:
    view, triangles = VIEWS[name], cloud(120, 0.6)
    raster = Raster(triangles, view)
    raster.draw()
    which, reach = hits(triangles, *rays(view))
    same = raster.ids.ravel() == which
    # Rays through an edge may fall either way.
    assert same.mean() > 0.995
    seen = same & (which >= 0)
    assert seen.sum() > 1000
    depth = raster.depth(raster.nearness.ravel()[seen])
    assert depth == pytest.approx(reach[seen], rel=1e-4, abs=1e-4)


def test_triangles_before_the_near_plane_are_not_drawn() -> None:
    wall = np.array([[(-1.0, 0.1, -1.0), (1.0, 0.1, -1.0), (0.0, 0.1, 3.0)]])
    behind = wall + (0.0, 1.0, 0.0)
    view = perspective((0, 0, 0), (0, 1, 0), (0, 0, 1), 40, (40, 40), near=0.2)
    raster = Raster(np.concatenate([wall, behind]), view)
    raster.draw()
    assert set(raster.ids.ravel().tolist()) == {1}


def test_neighbours_leave_no_gap_and_edges_at_pixel_centres_are_kept() -> None:
    edges = np.linspace(-1, 1, 21)  # with ten pixels per metre, every edge runs through pixel centres
    quads = [
        [(x0, y0, 0.0), (x1, y0, 0.0), (x1, y1, 0.0), (x0, y1, 0.0)]
        for x0, x1 in zip(edges, edges[1:], strict=False)
        for y0, y1 in zip(edges, edges[1:], strict=False)
    ]
    corners = np.array(quads)
    triangles = np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])
    raster = Raster(triangles, parallel(np.eye(3), (0.05, 0.05, 0.0), 10.0, (20, 20)))
    raster.draw()
    assert (raster.ids[2:, :-2] >= 0).all()


def test_culled_triangles_are_seen_from_outside_only() -> None:
    triangle = np.array([[(-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (0.0, 1.0, 0.0)]])
    above = perspective((0, 0, 3), (0, 0, 0), (0, 1, 0), 40, (20, 20))
    below = perspective((0, 0, -3), (0, 0, 0), (0, 1, 0), 40, (20, 20))
    shown = {}
    for name, view in {"above": above, "below": below}.items():
        raster = Raster(triangle, view, np.array([True]))
        raster.draw()
        shown[name] = bool((raster.ids >= 0).any())
    assert shown == {"above": True, "below": False}


def test_shares_of_corners_are_those_of_perspective() -> None:
    triangle = np.array([[(-2.0, 1.0, -1.0), (2.0, 1.0, -1.0), (0.0, 20.0, 6.0)]])
    view = perspective((0, -1, 0), (0, 5, 0.5), (0, 0, 1), 60, (200, 150))
    raster = Raster(triangle, view)
    raster.draw()
    rows, columns = np.nonzero(raster.ids >= 0)
    shares, depth = raster.shares(np.zeros(len(rows), int), columns + 0.5, rows + 0.5)
    points = shares.T @ triangle[0]
    assert view.pixels(points) == pytest.approx(np.stack([columns, rows], 1) + 0.5, abs=0.05)
    assert depth == pytest.approx(-view.local(points)[:, 2], rel=1e-3)


def test_empty_scene_and_degenerate_triangles() -> None:
    view = VIEWS["outside"]
    nothing = Raster(np.zeros((0, 3, 3)), view)
    nothing.draw()
    line = Raster(np.array([[(0.0, 0, 0), (1.0, 0, 0), (2.0, 0, 0)]]), view)
    line.draw()
    assert (nothing.ids == -1).all()
    assert (line.ids == -1).all()


def test_a_hundred_thousand_triangles_take_well_under_a_second() -> None:
    triangles = cloud(100_000, 0.01)
    start = time.process_time()
    raster = Raster(triangles, perspective((0, -4, 1), (0, 0, 0), (0, 0, 1), 40, (1280, 800)))
    raster.draw()
    assert time.process_time() - start < 20.0  # 0.15 s on a quiet machine
