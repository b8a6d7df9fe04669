"""Triangles of a case at its start: the compiler's shapes and the colours of the case."""

import time

import numpy as np
import pytest
from pictures import resolved, volume

from text2sim.compiler.build import Resolution
from text2sim.compiler.shapes.extents import body_extents
from text2sim.compiler.shapes.geometry import volume as exact_volume
from text2sim.compiler.trees.tree import tree_bounds
from text2sim.drawing.stage import stage

WELL = 1_000_000
"""Triangles, so many that round things are round."""


def test_every_body_fills_its_exact_bounds(zoo: Resolution) -> None:
    props = stage(zoo, WELL)
    for copies in zoo.placed.values():
        for copy in copies:
            mine = [prop.triangles.reshape(-1, 3) for prop in props if prop.name == copy.name and not prop.plane]
            if not mine:
                assert copy.shape.kind == "plane"
                continue
            tree = zoo.lowering.trees.get(copy.name)
            low, high = (
                tree_bounds(tree, copy.quat)
                if tree is not None and copy.shape is None
                else body_extents(copy.model, copy.quat, zoo.lowering.folder)
            )
            found = np.concatenate(mine)
            size = max(b - a for a, b in zip(low, high, strict=True))
            assert found.min(axis=0) == pytest.approx(np.add(low, copy.pos), abs=0.01 * size), copy.name
            assert found.max(axis=0) == pytest.approx(np.add(high, copy.pos), abs=0.01 * size), copy.name


@pytest.mark.parametrize(
    "name", ["ball", "pill", "cone", "egg", "ring", "tube", "mug", "funnel", "wheel", "lift", "bauble[2]", "slab"]
)
def test_surfaces_are_closed_and_face_outwards(zoo: Resolution, name: str) -> None:
    props = stage(zoo, WELL)
    copy = next(copy for group in zoo.placed.values() for copy in group if copy.name == name)
    mine = np.concatenate([prop.triangles for prop in props if prop.name == name])
    assert volume(mine - np.array(copy.pos)) == pytest.approx(exact_volume(copy.shape, zoo.lowering.folder), rel=0.01)


def test_normals_face_outwards(zoo: Resolution) -> None:
    props = stage(zoo)
    a, b, c = props.triangles.transpose(1, 0, 2)
    flat = np.cross(b - a, c - a)
    assert (np.einsum("nk,nk->n", flat, props.normals.mean(axis=1)) > 0).all()
    assert np.linalg.norm(props.normals, axis=2) == pytest.approx(1.0, abs=1e-4)


def test_colours_and_who_moves(zoo: Resolution) -> None:
    props = {(prop.name, prop.rgb): prop for prop in stage(zoo)}
    by_name = {name: prop for (name, _), prop in props.items()}
    assert by_name["ball"].rgb == pytest.approx((220 / 255, 20 / 255, 60 / 255), abs=1e-3)
    assert len([1 for name, _ in props if name == "hammer"]) == 2, "its head is of steel, its handle of oak"
    assert [by_name[f"bauble[{i}]"].rgb[1] > 0.5 for i in range(5)] == [False, True, False, True, False]
    assert by_name["bauble[0]"].opacity == 0.5
    assert {name: by_name[name].moves for name in ("ball", "funnel", "slab", "wheel", "rope", "doll")} == {
        "ball": True,
        "funnel": False,
        "slab": False,
        "wheel": True,
        "rope": True,
        "doll": True,
    }
    assert by_name["ramp"].plane
    assert not by_name["slab"].plane


def test_invisible_bodies_are_not_drawn() -> None:
    case = resolved(
        "ghost: {kind: rigid, shape: {kind: box, size: [1, 1, 1]}, look: {visible: false}}",
        "cup: {kind: rigid, shape: {kind: cup, radius: 1, height: 1, thickness: 0.1}, look: {visible: false}}",
        "ball: {kind: rigid, shape: {kind: sphere, radius: 1}, pose: {pos: [5, 0, 1]}}",
    )
    assert {prop.body for prop in stage(case)} == {"floor", "ball"}


def test_joints_stand_where_they_start() -> None:
    case = resolved(
        "arm: {kind: articulated, base: fixed, initial: {lower: 1.5707963267948966}, links: {"
        "upper: {shape: {kind: box, size: [0.1, 0.1, 0.1]}}, "
        "lower: {parent: upper, shape: {kind: box, size: [1, 0.1, 0.1]}, pose: {pos: [0.5, 0, 0]}, "
        "joint: {kind: hinge, axis: y, anchor: [-0.5, 0, 0]}}}}"
    )
    points = np.concatenate([prop.triangles.reshape(-1, 3) for prop in stage(case) if prop.body == "arm"])
    assert points[:, 2].min() == pytest.approx(-1.0, abs=1e-6), "a quarter turn about y points it downwards"


def test_two_thousand_bodies_are_made_at_once() -> None:
    case = resolved(
        "pebble: {kind: rigid, shape: {kind: sphere, radius: 0.04}, repeat: {kind: grid, counts: [20, 20, 5], spacing: 0.1}}"
    )
    stage(case)
    start = time.process_time()
    props = stage(case)
    took = time.process_time() - start
    assert len(props) == 2001
    assert 50_000 < len(props.triangles) < 200_000
    assert took < 20.0  # 0.1 s on a quiet machine
    last = next(prop for prop in props if prop.name == "pebble[1999]")
    middle = last.triangles.reshape(-1, 3).mean(axis=0)
    assert middle == pytest.approx(case.placed["pebble"][1999].pos, abs=1e-6)
