"""Placements do what their words say, for any convex shapes in any orientation."""

import json
import math

import pytest
import yaml
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from text2sim.compiler.placing.placement import Copy, place_all
from text2sim.compiler.shapes.extents import extents
from text2sim.compiler.shapes.geometry import pieces
from text2sim.compiler.shapes.rotation import quat_conjugate, quat_multiply, quat_rotate
from text2sim.compiler.shapes.solid import solids
from text2sim.compiler.shapes.sweep import least_distance
from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.models.shapes import SolidShape
from text2sim.spec_schema.published.language_reference import load_examples, section_kinds

MICROMETRE = 1e-6
place = st.floats(-3, 3).map(lambda x: round(x, 9))
size = st.floats(0.02, 1.0).map(lambda x: round(x, 3))
angle = st.integers(-180, 180)
gap = st.sampled_from([0.0, 0.0, 1e-3, 0.037, 0.4])
turn = st.one_of(st.just([0, 0, 0]), st.tuples(angle, angle, angle).map(list), angle.map(lambda a: [0, 0, a]))
shape = st.one_of(
    st.builds(lambda *s: {"kind": "box", "size": list(s)}, size, size, size),
    st.builds(lambda r: {"kind": "sphere", "radius": r}, size),
    st.builds(lambda r, h: {"kind": "cylinder", "radius": r, "height": h}, size, size),
    st.builds(lambda r, h: {"kind": "capsule", "radius": r, "length": h}, size, size),
    st.builds(lambda r, h: {"kind": "cone", "radius": r, "height": h}, size, size),
    st.builds(
        lambda x, y, z: {"kind": "polyhedron", "points": [[0, 0, 0], [x, 0, 0], [0, y, 0], [0, 0, z], [x, y, 0]]},
        size,
        size,
        size,
    ),
    st.builds(lambda *r: {"kind": "ellipsoid", "radii": list(r)}, size, size, size),
)
way = st.tuples(*[st.integers(-5, 5)] * 3).filter(any).map(list)
quickly = settings(max_examples=60, deadline=None)


def start(**bodies) -> tuple[dict[str, Copy], list]:
    """Where bodies start: each is given by its shape and where it is."""
    full = {name: {"kind": "rigid", **body} for name, body in bodies.items()}
    case = {"text2sim": 1, "name": "any", "scene": {"duration": 1}, "bodies": full}
    copies, problems = place_all(load_text(json.dumps(case)))
    return {copy.name: copy for group in copies.values() for copy in group}, problems


def placed(**bodies) -> dict[str, Copy]:
    copies, problems = start(**bodies)
    assert problems == []
    return copies


def apart(a: Copy, b: Copy) -> float:
    """Distance of two copies; 0 if they overlap."""
    mine, theirs = (solids(pieces(copy.shape, None), copy.pos, copy.quat) for copy in (a, b))
    return least_distance(mine, theirs)


def bounds(copy: Copy, frame=(1.0, 0.0, 0.0, 0.0)):
    back = quat_conjugate(frame)
    low, high = extents(copy.shape, quat_multiply(back, copy.quat), None)
    pos = quat_rotate(back, copy.pos)
    return [p + x for p, x in zip(pos, low, strict=True)], [p + x for p, x in zip(pos, high, strict=True)]


def base(shape, turn):
    return {"shape": shape, "pose": {"pos": [1, -2, 3], "euler_deg": turn}}


@quickly
@given(shape, turn, shape, turn, gap)
def test_on_leaves_the_clearance_and_no_more(below, its_turn, above, turn, gap):
    copies = placed(
        a=base(below, its_turn), b={"shape": above, "place": {"on": "a", "clearance": gap, "euler_deg": turn}}
    )
    assert apart(copies["a"], copies["b"]) == pytest.approx(gap, abs=MICROMETRE)
    (low, high), (bottom, top) = bounds(copies["a"]), bounds(copies["b"])
    for k in (0, 1):
        assert bottom[k] + top[k] == pytest.approx(low[k] + high[k], abs=1e-9)


@quickly
@given(shape, turn, shape, turn, gap, way)
def test_touching_leaves_the_clearance_and_no_more(one, its_turn, other, turn, gap, way):
    place = {"touching": "a", "direction": way, "clearance": gap, "euler_deg": turn}
    copies = placed(a=base(one, its_turn), b={"shape": other, "place": place})
    assert apart(copies["a"], copies["b"]) == pytest.approx(gap, abs=MICROMETRE)


RELATIONS = {
    "above": (2, 1),
    "below": (2, -1),
    "left_of": (0, -1),
    "right_of": (0, 1),
    "in_front_of": (1, -1),
    "behind": (1, 1),
}


@quickly
@given(
    shape,
    turn,
    shape,
    turn,
    gap,
    st.sampled_from(list(RELATIONS)),
    st.tuples(*[st.sampled_from(["min", "center", "max", None])] * 3),
)
def test_sides_are_apart_and_the_rest_lines_up(one, its_turn, other, turn, gap, relation, ends):
    axis, sign = RELATIONS[relation]
    align = {name: end for k, (name, end) in enumerate(zip("xyz", ends, strict=True)) if end and k != axis}
    if axis == 2:
        align.pop("z", None)
    place = {relation: "a", "clearance": gap, "euler_deg": turn} | ({"align": align} if align else {})
    copies = placed(a=base(one, its_turn), b={"shape": other, "place": place})
    (low, high), (bottom, top) = bounds(copies["a"]), bounds(copies["b"])
    between = bottom[axis] - high[axis] if sign > 0 else low[axis] - top[axis]
    assert between == pytest.approx(gap, abs=1e-9)
    assert apart(copies["a"], copies["b"]) >= gap - MICROMETRE
    for k, name in enumerate("xyz"):
        if k == axis:
            continue
        end = align.get(name, "min" if k == 2 else "center")
        mine, its = {"min": (bottom, low), "max": (top, high)}.get(end, (None, None))
        if mine is None or its is None:
            assert bottom[k] + top[k] == pytest.approx(low[k] + high[k], abs=1e-9)
        else:
            assert mine[k] == pytest.approx(its[k], abs=1e-9)


@quickly
@given(shape, turn, shape, turn, gap, way)
def test_beside_is_apart_along_its_direction_and_stands_on_the_same_level(one, its_turn, other, turn, gap, way):
    assume(way[0] or way[1])
    place = {"beside": "a", "direction": [*way[:2], 0], "clearance": gap, "euler_deg": turn}
    copies = placed(a=base(one, its_turn), b={"shape": other, "place": place})
    half = math.atan2(way[1], way[0]) / 2
    frame = (math.cos(half), 0.0, 0.0, math.sin(half))
    (low, high), (bottom, top) = bounds(copies["a"], frame), bounds(copies["b"], frame)
    assert bottom[0] - high[0] == pytest.approx(gap, abs=1e-9)
    assert bottom[1] + top[1] == pytest.approx(low[1] + high[1], abs=1e-9)
    assert bottom[2] == pytest.approx(low[2], abs=1e-9)
    assert apart(copies["a"], copies["b"]) >= gap - MICROMETRE


@quickly
@given(st.lists(st.tuples(shape, turn), min_size=3, max_size=5))
def test_a_chain_of_things_stands_on_each_other(things):
    bodies = {"b0": base(*things[0])}
    for k, (shape, turn) in enumerate(things[1:], start=1):
        bodies[f"b{k}"] = {"shape": shape, "place": {"on": f"b{k - 1}", "euler_deg": turn}}
    copies = placed(**bodies)
    for k in range(1, len(things)):
        assert 0 <= apart(copies[f"b{k - 1}"], copies[f"b{k}"]) < MICROMETRE
        assert copies[f"b{k}"].pos[2] > copies[f"b{k - 1}"].pos[2] - 2.0


@quickly
@given(
    size,
    size,
    st.integers(-180, 180),
    shape,
    turn,
    st.sampled_from([0.0, 0.013]),
    st.sampled_from(["left", "right"]),
    st.sampled_from(["front", "back"]),
)
def test_a_corner_is_the_targets_own(length, width, yaw, thing, turn, inset, side, end):
    table = {
        "shape": {"kind": "box", "size": [1 + length, 1 + width, 0.1]},
        "pose": {"pos": [1, 2, 0.7], "euler_deg": [0, 0, yaw]},
    }
    place = {"on": "table", "at": {"corner": [side, end]}, "inset": inset, "euler_deg": turn}
    copies = placed(table=table, b={"shape": thing, "place": place})
    frame = copies["table"].quat
    (low, high), (bottom, top) = bounds(copies["table"], frame), bounds(copies["b"], frame)
    assert (bottom[0] - low[0] if side == "left" else high[0] - top[0]) == pytest.approx(inset, abs=1e-9)
    assert (bottom[1] - low[1] if end == "front" else high[1] - top[1]) == pytest.approx(inset, abs=1e-9)
    assert apart(copies["table"], copies["b"]) < MICROMETRE


@quickly
@given(st.integers(-40, 40), st.integers(-180, 180), st.sampled_from(["left", "right", "front", "back"]), shape)
def test_an_edge_of_a_slope_is_met_along_the_slope(tilt, yaw, side, thing):
    slope = {"shape": {"kind": "box", "size": [3, 3, 0.2]}, "pose": {"pos": [0, 0, 3], "euler_deg": [0, tilt, yaw]}}
    place = {"on": "slope", "at": {"edge": side}, "inset": 0.5}
    copies = placed(slope=slope, b={"shape": thing, "place": place})
    assert apart(copies["slope"], copies["b"]) < MICROMETRE
    (low, high), (bottom, top) = (bounds(copies[name], copies["slope"].quat) for name in ("slope", "b"))
    k = 0 if side in ("left", "right") else 1
    off = bottom[k] - low[k] if side in ("left", "front") else high[k] - top[k]
    assert off == pytest.approx(0.5, abs=1e-6)


@settings(max_examples=25, deadline=None)
@given(st.floats(0.02, 0.2), st.floats(0.001, 0.1), turn, st.sampled_from([0.3, 0.9, 1.1]))
def test_a_tube_goes_around_a_rod_if_there_is_room(radius, room, turn, share):
    rod = base({"kind": "cylinder", "radius": radius, "height": 1.0}, turn)
    tube = {"kind": "tube", "inner_radius": radius + room, "outer_radius": radius + room + 0.01, "height": 0.3}
    clearance = share * room
    assume(abs(clearance - room) > 2 * MICROMETRE)
    copies, problems = start(rod=rod, tube={"shape": tube, "place": {"around": "rod", "clearance": clearance}})
    assert [p.path for p in problems] == (["/bodies/tube/place/clearance"] if share > 1 else [])
    if share < 1:
        assert apart(copies["rod"], copies["tube"]) == pytest.approx(room, abs=MICROMETRE)
        axes = [quat_rotate(copies[name].quat, (0.0, 0.0, 1.0)) for name in ("rod", "tube")]
        assert abs(sum(a * b for a, b in zip(*axes, strict=True))) == pytest.approx(1.0, abs=1e-9)


@quickly
@given(shape, turn, place, place, st.sampled_from(["right_of", "beside", "on"]))
@example({"kind": "cylinder", "radius": 0.219, "height": 1.0}, [-60, 1, 0], 2.375, -2.015625, "right_of")
def test_facing_points_the_x_axis_at_a_point(thing, turn, x, y, relation):
    target = base({"kind": "box", "size": [2, 2, 1]}, [0, 0, 0])
    copies, problems = start(
        a=target, b={"shape": thing, "place": {relation: "a", "facing": [x, y, 0], "euler_deg": turn}}
    )
    assert not any("never comes" in problem.message for problem in problems)
    assume(not problems)  # an x axis that points straight up faces nothing
    there = copies["b"].pos
    assume(math.hypot(x - there[0], y - there[1]) > 1e-3)
    ahead = quat_rotate(copies["b"].quat, (1.0, 0.0, 0.0))
    assume(math.hypot(*ahead[:2]) > 1e-3)
    off = math.atan2(y - there[1], x - there[0]) - math.atan2(ahead[1], ahead[0])
    assert math.remainder(off, 2 * math.pi) == pytest.approx(0.0, abs=1e-6)  # what `arrange` accepts


number = st.one_of(st.floats(-3, 3).map(lambda x: round(x, 3)), st.sampled_from([0, 1e-9, 1e6, -1e9]))
vector = st.lists(number, min_size=3, max_size=3)
side = st.sampled_from(["left", "right", "front", "back", "top", "bottom"])
body_region = st.one_of(
    st.fixed_dictionaries({"edge": side}),
    st.fixed_dictionaries({"face": side}),
    st.fixed_dictionaries({"corner": st.lists(side, min_size=2, max_size=3)}),
    st.fixed_dictionaries({"nearest": vector}),
    st.fixed_dictionaries({"sphere": st.fixed_dictionaries({"center": vector, "radius": size})}),
)
words = st.fixed_dictionaries(
    {},
    optional={
        "at": st.one_of(vector.map(lambda v: v[:2]), body_region),
        "inset": st.floats(0, 1).map(lambda x: round(x, 3)),
        "direction": st.one_of(st.sampled_from("xyz"), vector),
        "align": st.sampled_from(["top", "bottom", {"x": "min"}, {"y": "center", "z": "max"}]),
        "clearance": st.sampled_from([0, 0.01, 1e6]),
        "offset": vector,
        "facing": st.one_of(vector, st.sampled_from(["a", "b", "b[*]"])),
        "euler_deg": turn,
    },
)
relation = st.sampled_from(
    ["on", "above", "below", "inside", "left_of", "behind", "beside", "around", "touching"]
)  # fmt: skip
EXAMPLES = [yaml.safe_load(load_examples()["shapes"][kind])["shape"] for kind in section_kinds(SolidShape)]
any_shape = st.one_of(
    shape,
    st.builds(lambda h: {"kind": "cup", "radius": 1, "height": h + 0.2, "thickness": 0.1, "segments": 7}, size),
    st.builds(lambda h: {"kind": "tube", "outer_radius": 1, "inner_radius": 0.8, "height": h}, size),
    st.builds(lambda r: {"kind": "torus", "radius": 1, "bar_radius": r}, st.floats(0.01, 0.9)),
    st.sampled_from([one for one in EXAMPLES if "file" not in one]),
)
pattern = st.sampled_from(
    [
        None,
        {"kind": "line", "count": 3, "step": [0.5, 0, 0]},
        {"kind": "ring", "count": 4, "radius": 2},
        {"kind": "stack", "count": 2},
    ]
)


@settings(max_examples=150, deadline=None)
@given(
    any_shape,
    turn,
    st.lists(
        st.tuples(any_shape, relation, st.sampled_from(["a", "b", "b[*]", "b[0]"]), words, pattern),
        min_size=2,
        max_size=2,
    ),
)
def test_whatever_is_said_there_is_a_place_or_a_reason(first, its_turn, others):
    bodies = {"a": base(first, its_turn)}
    for name, (shape, relation, target, more, pattern) in zip("bc", others, strict=True):
        bodies[name] = {"shape": shape, "place": {relation: "a" if name == "b" else target, **more}}
        bodies[name] |= {"repeat": pattern} if pattern else {}
    copies, problems = {}, []
    try:
        copies, problems = start(**bodies)
    except SpecError as error:
        problems = error.problems
    assert all("/place" in problem.path for problem in problems)
    assert all(math.isfinite(x) for copy in copies.values() for x in (*copy.pos, *copy.quat))
