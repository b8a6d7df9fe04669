"""Patterns and writing: where they lie on a body, and what is in them."""

from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from text2sim.compiler.shapes import geometry
from text2sim.compiler.shapes.extents import extents
from text2sim.rendering.decorating import decorated, shifted, toned
from text2sim.rendering.meshes import presentable
from text2sim.spec_schema.models.shapes import Compound
from text2sim.templates.painting import painted, places
from text2sim.templates.patterns import TILES, Decoration, decoration_in, tile
from text2sim.templates.unfolding import unfold

OWN = (0.7, 0.55, 0.35)
CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float) / 2
FACES = np.array([
    [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4],
    [1, 5, 7], [1, 7, 3],
])  # fmt: skip


def box(size):
    return presentable(CORNERS * size, FACES)


def cylinder(radius, height):
    turn = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    ring = np.stack([radius * np.cos(turn), radius * np.sin(turn)], axis=1)
    points = np.concatenate([np.column_stack([ring, np.full(48, z)]) for z in (-height / 2, height / 2)])
    k = np.arange(48)
    sides = np.concatenate(
        [np.stack([k, (k + 1) % 48, k + 48], 1), np.stack([(k + 1) % 48, (k + 1) % 48 + 48, k + 48], 1)]
    )
    return presentable(points, sides)


def picked(layer, uv):
    """The colour of a layer over a body's at a place in metres."""
    h, w = layer.picture.shape[:2]
    u, v = uv[0] / layer.period[0] % 1, uv[1] / layer.period[1] % 1
    *color, alpha = layer.picture[min(int(v * h), h - 1), min(int(u * w), w - 1)]
    return alpha * np.array(color) + (1 - alpha) * np.array(OWN)


def at(mesh, place):
    """The texture coordinates of the vertex that is nearest to a place."""
    return mesh.uvs[np.linalg.norm(mesh.vertices - place, axis=1).argmin()]


def test_tape_runs_over_the_middle_of_the_top_of_any_carton():
    for size in ((0.4, 0.2, 0.1), (0.2, 0.4, 0.1), (0.3, 0.3, 0.5)):
        mesh = box(np.array(size))
        flat = unfold(mesh.vertices, mesh.faces, mesh.normals, upright=True)
        picture = painted(Decoration("carton"), flat.sheets, OWN)
        left, (width, _) = places(flat.sheets)
        top = flat.sheets[4]
        scale = picture.shape[1] / width
        first, many, high = round(left[4] * scale), round(top.width * scale), round(top.height * scale)
        sheet = picture[-high:, first : first + many]
        along_x = size[0] >= size[1]
        middle = sheet[high // 2] if along_x else sheet[:, many // 2]
        assert (middle[5:-5, 3] > 0.7).all(), "tape, from edge to edge"
        rim = sheet[high // 8, many // 4 : -many // 4] if along_x else sheet[high // 4 : -high // 4, many // 8]
        assert (rim[:, 3] < 0.1).all(), "and board beside it"


def test_the_corner_of_each_face_has_its_own_place_in_metres():
    size = np.array([0.6, 0.4, 0.2])
    mesh, layer, _ = decorated(box(size), Decoration("carton"), OWN, np.eye(3))
    assert np.allclose(layer.period[0], 2 * (0.4 + 0.6 + 0.6) + 5 * 0.02 * 0.6)
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    looks = np.cross(b - a, c - a)
    flat = np.abs(looks).max(axis=1) > 0.999 * np.linalg.norm(looks, axis=1)
    ab, ac = b - a, c - a
    lengths = np.linalg.norm(np.stack([ab, ac]), axis=2)[:, flat]
    p, q, r = np.moveaxis(mesh.uvs[mesh.faces], 1, 0)
    laid = np.linalg.norm(np.stack([q - p, r - p]), axis=2)[:, flat]
    assert np.allclose(laid, lengths, atol=1e-4), "lengths stay what they are"
    (ux, uy), (vx, vy) = (q - p)[flat].T, (r - p)[flat].T
    assert (ux * vy - uy * vx > 0).all(), "and nothing is mirrored"


def test_a_turned_mesh_of_a_part_is_dressed_as_its_link_stands():
    upright = box(np.array([0.3, 0.2, 0.1]))
    turn = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])  # from the mesh's frame to the link's
    lying = presentable((CORNERS * (0.3, 0.2, 0.1)) @ turn, FACES)
    a, layer_a, _ = decorated(upright, Decoration("carton"), OWN, np.eye(3))
    b, layer_b, _ = decorated(lying, Decoration("carton"), OWN, turn)
    assert layer_a is layer_b, "equal bodies share their pictures"
    place = np.array([0.15, 0.1, 0.05])
    assert np.allclose(picked(layer_a, at(a, place)), picked(layer_b, at(b, place @ turn)))


def test_staves_close_around_what_is_round():
    for turn in (np.eye(3), np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])):
        made = cylinder(0.2, 0.5)
        mesh, layer, _ = decorated(
            type(made)(made.vertices @ turn, made.faces, made.normals @ turn), Decoration("planks"), OWN, np.eye(3)
        )
        assert mesh.uvs is not None
        assert layer.unit is not None
        side = np.abs((mesh.normals @ turn.T)[:, 2]) < 0.5
        staves = np.ptp(mesh.uvs[side][:, 0]) / layer.unit
        assert abs(staves - round(staves)) < 1e-6
        assert staves > 10


def test_ends_of_a_flat_cylinder_are_flat_although_its_corners_lie_on_a_ball():
    turn = 2 * np.pi * np.arange(48) / 48
    ring = np.stack([0.3 * np.cos(turn), 0.3 * np.sin(turn)], axis=1)
    points = np.concatenate([np.column_stack([ring, np.full(48, z)]) for z in (-0.02, 0.02)])
    k = np.arange(48)
    sides = [np.stack([k, (k + 1) % 48, k + 48], 1), np.stack([(k + 1) % 48, (k + 1) % 48 + 48, k + 48], 1)]
    fan = np.stack([np.zeros(46, int), k[1:-1], k[2:]], 1)
    mesh = presentable(points, np.concatenate([*sides, fan[:, ::-1], fan + 48]))
    flat = unfold(mesh.vertices, mesh.faces, mesh.normals, upright=False)
    assert [sheet.name for sheet in flat.sheets] == ["side", "top", "bottom"]
    on_top = flat.sheet == 1
    assert flat.uvs[on_top] == pytest.approx(mesh.vertices[flat.vertices[on_top], :2] + 0.3)


def test_every_tile_is_seen():
    for kind in TILES:
        made = tile(kind, None, OWN)
        alpha = made.picture[..., 3]
        assert np.ptp(alpha) > 0.3, f"{kind} is seen"
        assert made.picture.min() >= 0.0
        assert made.picture.max() <= 1.0


def test_writing_is_seen_and_read_from_left_to_right():
    mesh = box(np.array([0.2, 0.2, 0.2]))
    flat = unfold(mesh.vertices, mesh.faces, mesh.normals, upright=True)
    picture = painted(Decoration(text="L", ink=(0.0, 0.0, 0.0)), flat.sheets, OWN)
    left, (width, _) = places(flat.sheets)
    scale = picture.shape[1] / width
    first, many = round(left[3] * scale), round(0.2 * scale)
    front = picture[:, first : first + many, 3]
    rows, columns = np.nonzero(front > 0.5)
    assert len(rows), "it is written on the front"
    stem = columns < columns.min() + 0.3 * np.ptp(columns)
    foot = rows > rows.max() - 0.2 * np.ptp(rows)
    assert stem.sum() > 0.5 * len(rows), "the stem of the letter is on the left"
    assert foot.sum() > 0.3 * len(rows), "and its foot below"


def test_copies_differ_a_little_and_always_by_the_same():
    tones = {name: toned(OWN, name, "wood") for name in ("crate[0]", "crate[1]", "crate[2]")}
    assert len(set(tones.values())) == 3
    assert tones == {name: toned(OWN, name, "wood") for name in tones}
    assert all(np.abs(np.array(tone) / OWN - 1).max() <= 0.07 + 1e-9 for tone in tones.values())
    mesh, layer, _ = decorated(box(np.array([0.6, 0.4, 0.2])), Decoration("planks"), OWN, np.eye(3))
    away = shifted(mesh, "crate[1]", layer.unit).uvs - mesh.uvs
    assert np.allclose(away / layer.unit, np.round(away / layer.unit)), "joints stay at edges"


def test_looks_without_pattern_have_no_dress():
    assert decoration_in({"color": [1, 1, 1], "finish": "wood"}) is None
    made = decoration_in({"pattern": {"kind": "dots", "size": None, "color": [1, 0, 0], "turned": False}})
    assert made == Decoration("dots", color=(1, 0, 0))


def test_decor_is_drawn_and_neither_weighs_nor_touches():
    ball, eye = {"kind": "sphere", "radius": 0.1}, {"kind": "sphere", "radius": 0.02}
    parts = {"head": {"shape": ball}, "eye": {"shape": eye, "pose": {"pos": (0.1, 0, 0)}, "decor": True}}
    dressed_up = Compound.model_validate({"kind": "compound", "parts": parts})
    plain = Compound.model_validate({"kind": "compound", "parts": {"head": {"shape": ball}}})
    for ask in (geometry.pieces, geometry.volume):
        assert ask(dressed_up, Path()) == ask(plain, Path())
    assert extents(dressed_up, (1, 0, 0, 0), Path()) == extents(plain, (1, 0, 0, 0), Path())
    (drawn,) = geometry.visual_mesh(dressed_up, Path()) or ()
    assert drawn.part == "eye"
    assert np.allclose(np.linalg.norm(drawn.vertices - (0.1, 0, 0), axis=1), 0.02)
    with pytest.raises(ValidationError, match="at least one must have mass"):
        Compound.model_validate({"kind": "compound", "parts": {"eye": parts["eye"]}})
    with pytest.raises(ValidationError, match="no density"):
        Compound.model_validate({"kind": "compound", "parts": parts | {"eye": parts["eye"] | {"density": 10.0}}})


def test_the_rings_of_timber_are_on_its_sawn_ends_alone():
    mesh = cylinder(0.2, 1.0)
    flat = unfold(mesh.vertices, mesh.faces, mesh.normals, upright=True)
    picture = painted(Decoration("rings", color=(0.9, 0.8, 0.6)), flat.sheets, OWN)
    left, (width, _) = places(flat.sheets)
    start = round(left[1] / width * picture.shape[1])
    assert picture[:, : start - 2, 3].max() == 0, "bark stays on the side"
    end = picture[-round(0.4 / width * picture.shape[1]) :, start : start + round(0.4 / width * picture.shape[1])]
    assert 0.55 < (end[..., 3] > 0.5).mean() < 0.785, "a disc within a rim of bark, in its square"
    inside = end[end[..., 3] > 0.99][:, :3]
    assert inside.mean(axis=0) == pytest.approx((0.8, 0.7, 0.53), abs=0.1)
    assert inside.std(axis=0).min() > 0.02, "with rings"
    crate = box(np.ones(3))
    flat = unfold(crate.vertices, crate.faces, crate.normals, upright=True)
    assert painted(Decoration("rings"), flat.sheets, OWN)[..., 3].max() == 0, "a box has none"
