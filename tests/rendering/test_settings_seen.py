"""Places: floors, walls, posts below what hangs in the air, and how bright a picture is."""

import numpy as np
import pytest
import trimesh
from filmed import MakeRun

from text2sim.compiler.build import plan_case
from text2sim.recording.film_record import read_recording
from text2sim.rendering import tone
from text2sim.rendering.backdrop import backdrop_mesh, blocks_light, edge_rays, wall_mesh
from text2sim.rendering.film import Filming
from text2sim.rendering.floors import SURFACES, texture
from text2sim.rendering.supports import StaticBody, posts, sights, supports
from text2sim.spec_schema.load import load_text
from text2sim.templates.cameras import View

CASE = """
text2sim: 2
name: drop
scene: {duration: 0.4, statics: {floor: {shape: {kind: plane}LOOK}}}
bodies: {box: {kind: rigid, shape: {kind: box, size: [0.6, 0.6, 0.6]}, pose: {pos: [0, 0, 0.5]}}}
render: RENDER
"""
BACKDROP = {"kind": "wall", "level": 0.0, "center": (0.0, 0.0, 0.5), "radius": 8.0}
CORNERS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
QUADS = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))


def film(render="{}", look=""):
    return plan_case(load_text(CASE.replace("RENDER", render).replace("LOOK", look))).render


def box(half, pos, tilt=0.0):
    c, s = np.cos(tilt), np.sin(tilt)
    placed = CORNERS * half @ np.array([(c, 0, s), (0, 1, 0), (-s, 0, c)]).T + pos
    return StaticBody(np.array([placed[list(q)] for a, b, c, d in QUADS for q in ((a, b, c), (a, c, d))]))


def test_a_place_is_chosen_where_nothing_is_said_of_light_or_backdrop():
    assert film()["backdrop"]["floor"]["pattern"] == "slabs"
    assert film("{cameras: {a: {kind: still, from: [0, -3, 1], look_at: box}}}")["backdrop"]["kind"] == "wall"
    assert "floor" not in film("{lighting: overcast}")["backdrop"]
    assert film("{setting: street}")["backdrop"]["sky"] != film("{setting: street}")["background"]
    oak = ", look: {color: oak, finish: wood}"
    assert film(look=oak)["backdrop"]["floor"]["pattern"] == "boards", "the ground of a case keeps its finish"
    assert film("{setting: street}", oak)["backdrop"]["floor"]["pattern"] == "asphalt", "unless a place is named"
    assert film("{setting: meadow, background: red}")["background"] == (1, 0, 0)


def test_a_hedge_or_a_tree_puts_a_place_that_nobody_named_out_of_doors():
    hedge = ", hedge: {shape: {kind: box, size: [SIZE, 0.3, 0.5]}, pose: {pos: [0, 1, 0.25]}, look: {finish: foliage}}"

    def behind(size, render="{}"):
        text = CASE.replace("RENDER", render).replace("LOOK}}}", "}" + hedge.replace("SIZE", size) + "}}")
        return plan_case(load_text(text)).render["backdrop"]

    outside = behind("3")
    assert (outside["kind"], outside["skyline"], outside["floor"]["pattern"]) == ("horizon", "wood", "slabs")
    assert behind("0.1")["kind"] == "wall", "a potted plant"
    assert behind("3", "{setting: room}")["kind"] == "wall"


def test_shadows_of_a_place_that_nobody_named_are_deep():
    lights = film()["lights"]
    shade = sum(lights[name]["strength"] for name in ("front", "fill"))
    assert shade < 0.06 * lights["key"]["strength"], "of what does not come from a lamp"


def test_a_dark_floor_makes_the_picture_brighter():
    assert film(look=", look: {color: black}")["gain"] > film()["gain"] > film(look=", look: {color: white}")["gain"]


def test_lights_of_the_case_are_exposed_as_those_of_its_place():
    own = "key: {kind: softbox, direction: [0.5, 1, -0.6], strength: 3.8, color: '#fff4e6'}"
    fill = "fill: {kind: environment, strength: 0.03, color: '#f0f4fb'}"
    for place in ("workshop", "studio"):
        same = film(f"{{setting: {place}, lights: {{{own}, {fill}}}}}")["gain"]
        assert same == pytest.approx(film(f"{{setting: {place}}}")["gain"], rel=1e-3), "those of the place, written out"
    brighter = film(f"{{setting: studio, exposure: 1, lights: {{{own}, {fill}}}}}")["gain"]
    assert brighter == pytest.approx(2 * same, rel=1e-3)


@pytest.mark.parametrize("pattern", SURFACES)
def test_a_texture_keeps_the_colour_and_has_no_seam(pattern):
    made = texture(pattern)
    assert made.mean(axis=(0, 1)) == pytest.approx(1.0)
    rows = np.abs(np.diff(made, axis=0)).mean(axis=(1, 2))
    seam = np.abs(made[0] - made[-1]).mean()
    assert seam <= 1.2 * rows.max()


def test_a_wall_is_known_to_stand_in_the_light() -> None:
    things, middle = np.array([(-0.3, -0.3, 0.0), (0.3, 0.3, 0.6)]), np.array([0.0, 0.0, 0.3])
    wall = wall_mesh(BACKDROP, [np.array([0.0, -4.0, 1.0])], things, 1.0).mesh  # it stands on the +y side
    weak = {"direction": (0.0, -1.0, -0.3), "strength": 1.0}
    assert blocks_light(wall, middle, 1.0, [weak]), "the sun is low behind it"
    assert blocks_light(wall, middle, 1.0, [{"direction": (0.6, -0.6, -0.2), "strength": 1.0}])
    assert not blocks_light(wall, middle, 1.0, [{"direction": (1.0, 0.0, -0.3), "strength": 1.0}]), "it shines along it"
    assert not blocks_light(wall, middle, 1.0, [{"direction": (0.0, -0.2, -1.0), "strength": 1.0}]), (
        "it is high above it"
    )
    assert not blocks_light(wall, middle, 1.0, [weak | {"distance": 1.0}]), "a lamp in front of it"
    assert not blocks_light(wall, middle, 1.0, [weak, {"direction": (0.0, 1.0, -1.0), "strength": 3.0}]), "a weak light"


def test_the_wall_is_straight_and_behind_the_scene_but_round_about_a_camera_that_goes_round():
    things = np.array([(0.0, 1.0, 0.5)])
    made = wall_mesh(BACKDROP, [np.array([0.0, -4.0, 1.0])], things, 1.0)
    wall = made.mesh
    assert wall.vertices[:, 1].min() > 1.5
    assert np.ptp(wall.vertices[wall.vertices[:, 2] > 1][:, 1]) < 1e-9
    assert made.uvs is not None
    assert made.uvs[wall.vertices[:, 2].argmin(), 1] == 0, "textures stand on the floor"
    assert (wall.normals @ (0.0, -1.0, 0.3) > 0).all()
    turns = np.linspace(0, 2 * np.pi, 8, endpoint=False)
    round_about = [np.array([4 * np.cos(a), 4 * np.sin(a), 1.0]) for a in turns]
    assert np.ptp(wall_mesh(BACKDROP, round_about, things, 1.0).mesh.vertices[:, 1]) > 8


def looking(azimuth: float, away: float, aside: float = 0.0) -> View:
    """A camera at 1 m, that looks past the middle by so much."""
    c, s = np.cos(np.radians(azimuth)), np.sin(np.radians(azimuth))
    pos, look_at = np.array([away * c, away * s, 1.0]), np.array([-aside * s, aside * c, 0.5])
    return View(pos, look_at, np.array([0.0, 0.0, 1.0]), 45.0, 1.0, 0.0)


@pytest.mark.parametrize(
    ("cameras", "straight"),
    [
        ([(-90, 4, 0.0), (-126, 5, 0.0), (-55, 5, 0.0)], True),
        ([(-90, 4, 0.0), (-55, 4, 4.0)], True),
        ([(-90, 4, 9.0)], False),
    ],
)
def test_no_camera_sees_where_the_wall_or_the_floor_ends(cameras, straight):
    views = [looking(*camera) for camera in cameras]
    eyes, rays = [view.pos for view in views], [edge_rays(view, 16 / 9) for view in views]
    wall = wall_mesh(BACKDROP, eyes, np.array([(0.0, 1.0, 0.5)]), 1.0, rays).mesh
    assert (np.ptp(wall.vertices[wall.vertices[:, 2] > 1][:, :2] @ (0, 1)) < 3) == straight
    reach = float(np.hypot(*wall.vertices[:, :2].T).max())
    floor = backdrop_mesh(BACKDROP, eyes, rays, reach)
    assert np.hypot(*floor.vertices[:, :2].T).max() >= reach
    room = trimesh.Trimesh(
        np.concatenate([wall.vertices, floor.vertices]), np.concatenate([wall.faces, floor.faces + len(wall.vertices)]),
        process=False,
    )  # fmt: skip
    for eye, ways in zip(eyes, rays, strict=True):
        assert room.ray.intersects_any(np.broadcast_to(eye, ways.shape), ways).all()


def following(ways: list[float], side: tuple[float, float]) -> list[View]:
    """Cameras beside a thing that runs along x, all looking the same way."""
    up = np.array([0.0, 0.0, 1.0])
    return [View(np.array([x, -1.2, 0.6]), np.array([x + side[0], side[1], 0.3]), up, 32.0, 1.0, 0.0) for x in ways]


@pytest.mark.parametrize("turned", [False, True])
def test_no_wall_comes_before_a_camera_that_follows_something_far_away(turned):
    views = following([0.4, 1.5, 2.6, 4.0, 5.0], (-0.4, 0.0))
    if turned:  # looks back as well, so that the wall is a round one
        views += following([0.5], (0.0, -3.0))
    things = np.array([(x, 0.0, 0.2) for x in (0.0, 1.1, 2.2, 3.6, 4.6)])
    small = BACKDROP | {"radius": 3.3}
    wall = wall_mesh(small, [view.pos for view in views], things, 1.0, [edge_rays(view, 16 / 9) for view in views]).mesh
    room = trimesh.Trimesh(wall.vertices, wall.faces, process=False)
    for view, thing in zip(views, things, strict=False):
        hits, _, _ = room.ray.intersects_location([view.pos], [view.look_at - view.pos])
        away = np.linalg.norm(hits - view.pos, axis=1).min(initial=np.inf)
        assert away > np.linalg.norm(thing - view.pos)


def test_the_wall_meets_the_floor_in_a_level_line_for_the_camera_that_films_most():
    views = [looking(-100, 4, 0.4), looking(-100, 4, 0.4), looking(-120, 5)]
    eyes, rays = [view.pos for view in views], [edge_rays(view, 16 / 9) for view in views]
    wall = wall_mesh(BACKDROP, eyes, np.array([(0.0, 1.0, 0.5)]), 1.0, rays).mesh
    foot = wall.vertices[wall.vertices[:, 2] == wall.vertices[:, 2].min()]
    right = np.cross(views[0].look_at - views[0].pos, (0, 0, 1.0))
    along = foot[-1] - foot[0]
    assert abs(along @ right) == pytest.approx(np.linalg.norm(along) * np.linalg.norm(right))


def test_what_hangs_in_the_air_gets_posts_where_nothing_moves():
    ramp = box((1.0, 0.3, 0.03), (0, 0, 0.8), 0.3)
    made = posts([ramp], 0.0, [])
    assert made is not None
    assert made.vertices[:, 2].min() == 0
    assert made.vertices[:, 2].max() < 1.15
    corners = {(round(float(np.sign(x)), 0), round(float(np.sign(y)), 0)) for x, y, _ in made.vertices}
    assert len(corners) == 4
    ball = (np.array([(0.8, 0.2, 0.3)]), np.eye(3)[None], np.full((1, 3), 0.2))
    fewer = posts([ramp], 0.0, [ball])
    assert fewer is not None
    assert len(fewer.vertices) < len(made.vertices)
    assert not ((fewer.vertices[:, :2] > 0).all(axis=1)).any(), "the ball passes there"


def test_what_is_close_before_a_wall_is_fixed_to_it():
    board = box((1.3, 0.01, 0.36), (0, 0, 1.8))
    wall = box((1.3, 0.04, 1.15), (0, 0.19, 1.15))
    assert posts([board, wall], 0.0, []) is None
    for other in (
        box((1.3, 0.04, 1.15), (0, 0.6, 1.15)),  # too far
        box((0.3, 0.04, 1.15), (0, 0.19, 1.15)),  # narrow
        box((1.3, 0.04, 0.4), (0, 0.19, 0.4)),  # low
        box((1.3, 0.04, 1.0), (0, 0.19, 2.0)),  # hangs in the air itself
    ):
        assert posts([board, other], 0.0, []) is not None


def test_a_tilted_lawn_is_ground_and_needs_no_posts() -> None:
    """Neither does what stands on it, although the low edge of the lawn is all of the group that is on the floor."""
    lawn = StaticBody(
        np.array([[(-9, -9, 0), (9, -9, 0), (9, 9, 1.5)], [(-9, -9, 0), (9, 9, 1.5), (-9, 9, 1.5)]], float)
    )
    trunk = box((0.1, 0.1, 1.3), (1.0, 0.0, 2.0))
    assert posts([lawn, trunk], 0.0, []) is None
    assert posts([trunk], 0.0, []) is not None


def test_a_table_on_which_things_roll_stands_on_its_four_posts():
    table = box((0.5, 1.0, 0.02), (0, 0, 0.8))
    rolling = [
        (np.array([(x, 0.76, 0.835)]), np.eye(3)[None], np.full((1, 3), 0.015)) for x in np.linspace(-0.4, 0.4, 9)
    ]
    made, alone = posts([table], 0.0, rolling), posts([table], 0.0, [])
    assert made is not None
    assert alone is not None
    assert np.array_equal(made.vertices, alone.vertices), "what lies on the table is not in the way of its legs"
    assert made.vertices[:, 2].max() < 0.85
    below = (np.array([(0.26, 0.76, 0.77)]), np.eye(3)[None], np.full((1, 3), 0.005))
    fewer = posts([table], 0.0, [below])
    assert fewer is not None
    assert len(fewer.vertices) < len(made.vertices), "what passes just under the table is"


def test_no_post_stands_between_a_camera_and_the_middle_of_its_picture():
    shelf = box((1.0, 0.3, 0.03), (0, 0, 0.8))
    up = np.array([0, 0, 1.0])
    near = View(np.array([0.76, -1.0, 0.4]), np.array([0.76, 2.0, 0.4]), up, 40, 1, 0)
    far = View(np.array([0.76, -6.0, 0.4]), np.array([0.76, 0.0, 0.4]), up, 40, 6, 0)
    four, two = posts([shelf], 0.0, sights([far])), posts([shelf], 0.0, sights([near]))
    assert four is not None
    assert {float(np.sign(x)) for x in four.vertices[:, 0]} == {-1.0, 1.0}
    assert two is not None
    right = two.vertices[two.vertices[:, 0] > 0]
    assert (right[:, 2] > 0.8).all(), "the camera would look at its right legs"


def test_a_rail_that_could_have_one_leg_hangs_from_two_rods():
    rail = box((0.35, 0.01, 0.01), (0, 0, 1.0))
    cloth = (np.array([(0.25, 0.0, 0.5)]), np.eye(3)[None], np.array([(0.2, 0.1, 0.4)]))
    made = posts([rail], 0.0, [cloth])
    assert made is not None
    assert made.vertices[:, 2].min() > 0.98
    assert {float(np.sign(x)) for x in made.vertices[:, 0]} == {-1.0, 1.0}


def test_what_stands_or_leans_or_holds_on_to_something_gets_none():
    stands = box((0.3, 0.3, 0.3), (0, 0, 0.3))
    assert posts([stands], 0.0, []) is None
    peg = box((0.05, 0.3, 0.05), (0, -0.59, 0.5))
    assert posts([stands, peg], 0.0, []) is None, "it holds on to what stands"
    chute, post, low = (
        box((0.5, 0.05, 0.02), (0, 0, 0.8)),
        box((0.1, 0.1, 0.4), (0.5, 0, 0.4)),
        box((0.1, 0.1, 0.1), (0.5, 0, 0.1)),
    )
    assert posts([chute, post], 0.0, []) is None, "a bracket on a post"
    ramp = box((0.5, 0.1, 0.02), (0, 0, 0.35), 0.5)
    assert posts([ramp, low], 0.0, []) is not None, "what stands at its foot does not hold its upper end"


def test_the_fixed_base_of_a_mechanism_gets_posts_beside_what_moves_on_it(make_run: MakeRun) -> None:
    """A gantry: its rail, 1 m up and 2 m long, gets posts 12 % from its ends; the carriage runs 0.8 m along below it."""
    rail = {"half": (1.0, 0.03, 0.03), "pos": (0, 0, 1.0), "of": "gantry"}

    def span(start: float) -> tuple[float, float]:
        carriage = {"half": (0.1, 0.1, 0.3), "pos": (start, 0, 0.6), "velocity": (2, 0, 0), "of": "gantry"}
        made = supports(read_recording(make_run({"rail": rail, "carriage": carriage})), 0.0, set(), [])
        assert made is not None
        assert np.unique(np.sign(made.vertices[:, 0])).tolist() == [-1.0, 1.0]
        return made.vertices[:, 2].min(), made.vertices[:, 2].max()

    assert span(-0.4) == pytest.approx((0.0, 0.97), abs=1e-6)
    # It passes the post at x = -0.76 m: two rods hold the rail from above.
    assert span(-0.9) == pytest.approx((1.03, 1.03 + 6 * 2.0), abs=1e-6)


@pytest.mark.usefixtures("tracer")
def test_a_picture_without_a_render_section_uses_the_tonal_range(make_run: MakeRun) -> None:
    run = make_run({"box": {"half": 0.3, "pos": (0, 0, 0.3)}})
    case = load_text(CASE.replace("RENDER", "{}").replace("LOOK", ""))
    recording = read_recording(run, plan_case(case))
    filming = Filming(recording, "draft", size=(64, 36))
    shown = filming.develop(filming.trace(filming.reels()[0].frames[0])) / 255 @ tone.LUMA
    floor, behind = np.median(shown[-8:]), np.median(shown[:4])
    assert 0.55 < floor < 0.68
    assert 0.5 < np.median(shown) < 0.7
    assert behind > floor + 0.03, "the background is told from the floor"
    assert np.percentile(shown, 99) < 0.93
    assert np.percentile(shown, 5) > 0.1
