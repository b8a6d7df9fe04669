"""Bodies that deform: what is drawn lies where their points are."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from text2sim.recording.film_record import SoftPart, SurfaceLook, read_recording
from text2sim.recording.vectors import rotate
from text2sim.rendering.grains import HEAPED, LOOSE, PAST_SIDE, Grains, flat_sides, heap_surface
from text2sim.rendering.renderer import mitsuba
from text2sim.rendering.soft import LiquidSurface, SoftSurface, hollows, is_clear, liquid_surface
from text2sim.rendering.tears import Tears
from text2sim.templates.patterns import Decoration

pytestmark = pytest.mark.usefixtures("tracer")

SPACING = 0.05
HEAP = np.stack(np.meshgrid(*[np.arange(8) * SPACING] * 3), axis=-1).reshape(-1, 3)


def part(kind: str, **look: Any) -> SoftPart:
    row = {"points": [0, len(HEAP)], "surface": None, "spacing": SPACING}
    return SoftPart("it", kind, row, Path("none"), SurfaceLook((0.3, 0.5, 0.8), **look))


def bounds(shapes: dict[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    box = mitsuba().load_dict({"type": "scene"} | shapes, optimize=False).bbox()
    return np.array(box.min).ravel(), np.array(box.max).ravel()


@pytest.mark.parametrize("kind", ["granular", "snow"])
def test_grains_lie_about_their_particles(kind: str) -> None:
    grains = Grains("soft0", part(kind))
    low, high = bounds(grains.shapes(HEAP + (1, 0, 0)))
    far = SPACING * np.array([1.9, 1.9, 1.1])  # further along the ground, where steps of the solver's cells would show
    assert np.all(np.abs(low - (HEAP.min(axis=0) + (1, 0, 0))) < far)
    assert np.all(np.abs(high - (HEAP.max(axis=0) + (1, 0, 0))) < far)


def test_sand_against_a_wall_has_a_flat_side_and_a_heap_has_none() -> None:
    filled = np.stack(np.meshgrid(*[np.arange(24) * SPACING] * 3), axis=-1).reshape(-1, 3)
    filled = filled + np.random.default_rng(1).uniform(-0.3, 0.3, filled.shape) * SPACING
    sides = flat_sides(filled, SPACING)
    assert [(axis, sign) for axis, sign, _, _ in sides] == [(0, -1.0), (0, 1.0), (1, -1.0), (1, 1.0)]
    ends = {(axis, sign): end for axis, sign, end, _ in sides}
    assert ends[0, 1.0] == pytest.approx((23 + 0.3 + PAST_SIDE) * SPACING, abs=0.1 * SPACING)
    assert min(flat for *_, flat in sides) > 0.9
    heap = filled[np.hypot(*(filled[:, :2] - 11.5 * SPACING).T) < 11.5 * SPACING - filled[:, 2]]
    assert flat_sides(heap, SPACING) == []


def test_no_grain_is_drawn_beyond_a_wall() -> None:
    row = {"points": [0, len(HEAP)], "surface": None, "spacing": SPACING}
    sand = SoftPart("it", "granular", row, Path("none"), SurfaceLook((0.8, 0.6, 0.2)))
    low, high = bounds(Grains("soft0", sand).shapes(HEAP))
    tilted = 0.1 * SPACING  # edges of grains and of the flat bodies that fill the heap
    assert np.all(low[:2] > HEAP.min(axis=0)[:2] - PAST_SIDE * SPACING - tilted)
    assert np.all(high[:2] < HEAP.max(axis=0)[:2] + PAST_SIDE * SPACING + tilted)


def test_grains_lie_in_the_surface_of_their_heap_and_keep_their_place_at_rest() -> None:
    """A cone of sand: its normal leans outwards by the angle of its slope, and does not change by creeping."""
    tall, slope = 0.5, 2.0
    sand = np.stack(np.meshgrid(*[np.arange(-20, 21) * SPACING] * 2, np.arange(11) * SPACING), axis=-1).reshape(-1, 3)
    radius = np.hypot(sand[:, 0], sand[:, 1])
    sand = sand[radius < slope * (tall - sand[:, 2])]
    radius = np.hypot(sand[:, 0], sand[:, 1])
    flank = (np.abs(radius - slope * (tall - sand[:, 2])) < 1.5 * SPACING) & (radius > 0.3) & (sand[:, 2] > 0.15)
    facing, dense = heap_surface(sand, SPACING)
    outward = (facing[:, :2] * sand[:, :2]).sum(axis=1) / np.maximum(radius, 1e-9)
    steep = np.degrees(np.arctan2(outward, facing[:, 2]))[flank]
    assert np.median(steep) == pytest.approx(np.degrees(np.arctan(1 / slope)), abs=6)
    crept, _ = heap_surface(sand + 1e-3 * SPACING * np.sin(np.arange(sand.size)).reshape(sand.shape), SPACING)
    turned = np.degrees(np.arccos(np.clip((facing * crept).sum(axis=1), -1, 1)))
    assert np.quantile(turned[flank], 0.9) < 20
    stray, around = heap_surface(np.concatenate([sand, [[20.0, 0.0, 3.0]]]), SPACING)
    assert stray[-1].tolist() == [0.0, 0.0, 1.0], "what flies alone has no surface"
    assert around[-1] == 0.0
    assert np.median(dense[flank]) > HEAPED, "grains of the heap are flat"
    assert dense[flank].min() > LOOSE > around[-1], "and the stray one is round"
    turned = np.degrees(np.arccos(np.clip((facing * stray[:-1]).sum(axis=1), -1, 1)))
    assert np.quantile(turned[flank], 0.9) < 20, "one stray grain does not change the light on the heap"


def test_a_liquid_keeps_its_volume() -> None:
    vertices, faces = liquid_surface(HEAP, SPACING / 2)
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    volume = float((a * np.cross(b, c)).sum() / 6)
    assert volume == pytest.approx(len(HEAP) * SPACING**3, rel=0.12)
    liquid = LiquidSurface("soft0", part("liquid", opacity=0.5))
    make = liquid.shape(HEAP)
    assert make is not None
    low, _ = bounds({"soft0": make(liquid.bsdf)})
    assert np.all(np.abs(low - HEAP.min(axis=0)) < SPACING)


def test_syrup_takes_on_its_colour_where_it_is_thin() -> None:
    """Light has the colour `1 - opacity (1 - color)` after two edges of a cube of its volume, after a fifth of that at 0.9."""
    water = LiquidSurface("soft0", part("liquid", finish="glass", opacity=0.9))
    syrup = LiquidSurface("soft0", part("liquid", finish="smooth", opacity=0.9))
    half = LiquidSurface("soft0", part("liquid", finish="smooth", opacity=0.5))
    thinner = LiquidSurface("soft0", part("liquid", finish="glass", opacity=0.5))
    assert syrup._shade == pytest.approx(5 * water._shade)
    assert half._shade == pytest.approx(thinner._shade)


@pytest.mark.parametrize("finish", ["rough", "cloth"])
@pytest.mark.parametrize("has_uvs", [True, False])
def test_a_surface_follows_its_vertices(finish: str, *, has_uvs: bool) -> None:
    x, y = np.meshgrid(np.linspace(0, 1, 5), np.linspace(0, 1, 5))
    sheet = np.column_stack([x.ravel(), y.ravel(), np.zeros(25)])
    corner = (np.arange(4)[:, None] * 5 + np.arange(4)).ravel()
    faces = np.concatenate([np.c_[corner, corner + 1, corner + 6], np.c_[corner, corner + 6, corner + 5]])
    arrays = {"faces": faces} | ({"uvs": sheet[:, :2]} if has_uvs else {})
    surface = SoftSurface("soft0", part("cloth", finish=finish), sheet, arrays)
    low, high = bounds(surface.shapes(sheet * (1, 1, 0) + (0, 0, 2), sheet))
    assert np.allclose(low, (0, 0, 2), atol=1e-5)
    assert np.allclose(high, (1, 1, 2), atol=1e-5)


@pytest.mark.parametrize("lying", [True, False])
def test_a_pattern_lies_on_a_cloth_and_bends_with_it(*, lying: bool) -> None:
    """Eight stripes of each colour across a sheet that is twice as long as it is wide, wherever it hangs."""
    x, y = np.meshgrid(np.linspace(0, 2, 9), np.linspace(0, 1, 5))
    flat = np.column_stack([x.ravel(), y.ravel(), np.zeros(45)])
    corner = (np.arange(4)[:, None] * 9 + np.arange(8)).ravel()
    faces = np.concatenate([np.c_[corner, corner + 1, corner + 10], np.c_[corner, corner + 10, corner + 9]])
    start = flat if lying else flat[:, [0, 2, 1]] @ np.array([[0.8, 0.6, 0], [-0.6, 0.8, 0], [0, 0, 1]])
    decoration = Decoration("stripes", 1 / 16, (0.0, 0.0, 0.0))
    arrays = {"faces": faces, "uvs": flat[:, :2] / (2, 1)}
    shape = SoftSurface("soft0", part("cloth", decoration=decoration), start, arrays).shapes(flat, flat)
    seen = {"type": "orthographic", "film": {"type": "hdrfilm", "width": 64, "height": 64, "rfilter": {"type": "box"}}}
    look = mitsuba().ScalarTransform4f().look_at([1, 0.5, 1], [1, 0.5, 0], [0, 1, 0]).scale([0.5, 0.5, 1])
    scene = {"type": "scene", "light": {"type": "constant"}, "integrator": {"type": "direct"}}
    made = mitsuba().load_dict(scene | {"sensor": seen | {"to_world": look}} | shape, optimize=False)
    picture = np.array(mitsuba().render(made, spp=32))[..., 2]
    along = picture.std(axis=0).mean() > picture.std(axis=1).mean()
    row = picture[:, 32] if along else picture[32]
    bright = row > row.mean()
    assert np.abs(np.diff(bright.astype(int))).sum() in (15, 16, 17), "a metre of the sheet, in stripes of 1/16 m"
    assert row.max() > 3 * row.min()


def test_a_pattern_runs_round_a_band_without_a_break() -> None:
    """Its texture coordinates fall to 0 at the seam; no triangle shows the whole pattern squeezed into it."""
    turn = np.arange(16) / 16
    ring = np.column_stack([np.cos(2 * np.pi * turn), np.zeros(16), np.sin(2 * np.pi * turn)])
    band = np.concatenate([ring, ring + (0, 0.5, 0)])
    k, after = np.arange(16), (np.arange(16) + 1) % 16
    faces = np.concatenate([np.c_[k, after, after + 16], np.c_[k, after + 16, k + 16]])
    arrays = {"faces": faces, "uvs": np.column_stack([np.tile(turn, 2), np.repeat([0.0, 1.0], 16)])}
    look = {"decoration": Decoration("checker", 0.1, (0.0, 0.0, 0.0)), "finish": "cloth"}
    surface = SoftSurface("soft0", part("cloth", **look), band, arrays)
    drawn = mitsuba().traverse(surface.shapes(band, band)["soft0_0"])
    corners = np.array(drawn["faces"]).reshape(-1, 3)
    places, uvs = np.array(drawn["vertex_positions"]).reshape(-1, 3), np.array(drawn["vertex_texcoords"]).reshape(-1, 2)
    long, laid = (np.linalg.norm(at[corners] - at[np.roll(corners, 1, axis=1)], axis=2) for at in (places, uvs))
    assert laid.max() < 1.2 * long.max() * (laid / long).min()


def test_a_pattern_runs_round_a_tube_that_leans() -> None:
    """Turned to the axes of the world, its triangles would take the pattern from one side or the other by turns."""
    turn, high = np.meshgrid(2 * np.pi * np.arange(24) / 24, np.arange(9) / 8)
    tube = np.column_stack([0.3 * np.cos(turn.ravel()), 0.3 * np.sin(turn.ravel()), high.ravel()])
    k = (24 * np.arange(8)[:, None] + np.arange(24)).ravel()
    after = (24 * np.arange(8)[:, None] + (np.arange(24) + 1) % 24).ravel()
    faces = np.concatenate([np.c_[k, after, after + 24], np.c_[k, after + 24, k + 24]])
    quat = np.array([np.cos(0.4), np.sin(0.4), 0.0, 0.0])
    leaning = part("cloth", decoration=Decoration("stripes", 0.125, (0.0, 0.0, 0.0)))
    leaning.row["quat"] = quat.tolist()
    surface = SoftSurface("soft0", leaning, rotate(quat, tube), {"faces": faces})
    drawn = mitsuba().traverse(surface.shapes(tube, tube)["soft0_0"])
    places, uvs = np.array(drawn["vertex_positions"]).reshape(-1, 3), np.array(drawn["vertex_texcoords"]).reshape(-1, 2)
    along = np.ptp(places[:, 2]) / np.ptp(uvs, axis=0)
    assert min(np.abs(np.diff((uvs * along)[np.argsort(places[:, 2])], axis=0)).max(axis=0)) < 0.15, "one goes with z"


def test_a_pattern_lies_on_what_deforms_as_on_a_rigid_body() -> None:
    corners = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    faces = np.array([(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
                      (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)])  # fmt: skip
    jelly = part("soft", decoration=Decoration("dots", 0.2))
    jelly.row["solver"] = "mpm"
    surface, longer = SoftSurface("soft0", jelly, corners, {"faces": faces}), corners * (1.1, 1, 1)
    low, high = bounds(surface.shapes(longer, longer))
    assert np.allclose([low, high], [(0, 0, 0), (1.1, 1, 1)], atol=1e-5)


def test_a_torn_body_is_open_and_shows_its_inside() -> None:
    """Skin without particles below it is not drawn, however little it is stretched."""
    import trimesh

    box = trimesh.creation.box((1, 0.35, 0.35)).subdivide_to_size(0.06)
    at_rest, bar = np.array(box.vertices), part("soft")
    bar.row["solver"] = "mpm"
    surface = SoftSurface("soft0", bar, at_rest, {"faces": np.array(box.faces)})
    particles = HEAP - HEAP.mean(axis=0)
    filled = np.concatenate([particles + (x, 0, 0) for x in (-0.34, 0, 0.34)])
    assert surface.whole(at_rest, filled).all()
    assert list(surface.shapes(at_rest, filled)) == ["soft0_0"]
    parted = filled[np.abs(filled[:, 0]) > 0.2]
    drawn = surface.shapes(at_rest, parted)
    assert set(drawn) == {"soft0_0", "soft0_inside"}
    middle = at_rest[box.faces].mean(axis=1)[:, 0]
    whole = surface.whole(at_rest, parted)
    assert not whole[np.abs(middle) < 0.1].any() and whole[np.abs(middle) > 0.3].all()
    thin = SoftSurface("soft0", bar, at_rest, {"faces": np.array(box.faces)}, particles=parted)
    assert thin.whole(at_rest, parted).all(), "skin that was far from its particles at the start has not torn"
    paint = LiquidSurface("soft0", part("liquid", finish="smooth"))
    assert not paint.is_clear
    assert "twosided" in str(paint.bsdf).lower(), "else it is black where its surface is turned over"
    assert LiquidSurface("soft0", part("liquid", opacity=0.7, finish="smooth")).is_clear, "water by its opacity"


def test_a_cut_body_is_open_where_its_faces_touch() -> None:
    import trimesh

    box = trimesh.creation.box((1, 0.35, 0.35)).subdivide_to_size(0.06)
    at_rest, bar, particles = np.array(box.vertices), part("soft"), HEAP - HEAP.mean(axis=0)
    bar.row["solver"] = "mpm"
    filled = np.concatenate([particles + (x, 0, 0) for x in (-0.34, 0, 0.34)])
    surface, cut = (
        SoftSurface("soft0", bar, at_rest, {"faces": np.array(box.faces)}, particles=filled),
        filled[:, 0] < 1,
    )
    assert surface.whole(at_rest, filled, ~cut).all()
    cut = np.abs(filled[:, 0]) < 0.1
    middle, whole = np.abs(at_rest[box.faces].mean(axis=1)[:, 0]), surface.whole(at_rest, filled, cut)
    assert not whole[middle < 0.08].any() and whole[middle > 0.4].all()
    assert set(surface.shapes(at_rest, filled, torn=cut)) == {"soft0_0", "soft0_inside"}
    halves = trimesh.Trimesh(*Tears(at_rest, filled, bar.row["spacing"]).inside(filled, cut)).split()
    assert [half.bounds[:, 0].mean() > 0 for half in sorted(halves, key=lambda half: half.bounds[0, 0])] == [
        False,
        True,
    ]


def test_a_clear_body_shows_its_core_and_no_cavity() -> None:
    """A cavity that a core fills would be drawn at the same place as the core."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    box = np.array([half for a, b, c, d in quads for half in ((a, b, c), (a, c, d))])
    both = np.concatenate([corners, corners / 2 + 0.25])
    faces = np.concatenate([box, box[:, ::-1] + 8])
    assert hollows(both, faces).tolist() == [False] * 12 + [True] * 12
    row = part("soft").row | {"solver": "fem"}
    body = SoftPart("it", "soft", row, Path("none"), SurfaceLook((0.9, 0.3, 0.2), opacity=0.4))
    surface = SoftSurface("soft0", body, both, {"faces": faces})
    assert surface.is_clear
    assert not surface.shapes(both, both), "nothing of it hides the core"
    (skin,) = surface.shapes(both, both, clear=True).values()
    assert skin.face_count() == 12


@pytest.mark.parametrize(
    ("kind", "finish", "opacity", "clear"),
    [("soft", "plastic", 0.4, True), ("soft", "plastic", 0.7, False), ("soft", "jelly", 1.0, False),
     ("cloth", "cloth", 0.3, False), ("cloth", "rubber", 0.3, True)],
)  # fmt: skip
def test_which_soft_bodies_are_clear_skins(kind: str, finish: str, opacity: float, *, clear: bool) -> None:
    assert is_clear(kind, SurfaceLook((0.9, 0.3, 0.2), opacity=opacity, finish=finish)) == clear


def test_a_recording_gives_soft_bodies_the_look_of_the_case(make_run):
    """The look, with finish and pattern, is that of the program, not the plain colour of the preview."""
    run = make_run({"crate": {"half": (0.1, 0.1, 0.1), "pos": (0, 0, 0)}})
    layout = json.loads((run / "states" / "layout.json").read_text())
    layout["deformables"] = [{"body": "gel", "kind": "soft", "solver": "mpm", "spacing": 0.01, "points": [0, 1]}]
    (run / "states" / "layout.json").write_text(json.dumps(layout))
    (run / "geometry" / "soft_index.json").write_text(json.dumps([{"body": "gel", "color": [0.0, 1.0, 0.0, 1.0]}]))
    looks = json.loads((run / "program" / "looks.json").read_text())
    pattern = {"kind": "stripes", "size": 0.04, "color": [1.0, 1.0, 1.0], "turned": False}
    looks["gel"] = looks["crate"] | {"color": [0.9, 0.1, 0.4], "finish": "jelly", "pattern": pattern}
    (run / "program" / "looks.json").write_text(json.dumps(looks))
    (gel,) = read_recording(run).soft
    assert gel.look.color == (0.9, 0.1, 0.4)
    assert gel.look.finish == "jelly"
    assert gel.look.decoration is not None
