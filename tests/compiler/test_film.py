"""The render section as numbers: cameras that frame, studios, shots, colours; none of it touches the physics."""

import math

import numpy as np
import pytest

from text2sim.compiler.build import plan_case
from text2sim.compiler.emit import emit
from text2sim.compiler.film_lights import MOST_GRAZING
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.models.colors import PALETTES, rgb
from text2sim.templates.cadence import read_film

CASE = """\
text2sim: 2
name: film
scene:
  duration: 2.0
  statics:
    floor: {shape: {kind: plane}}
    post: {shape: {kind: box, size: [0.2, 0.2, 1]}, place: {on: floor, at: [-0.6, 0]}}
    WALL
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 0.5]}}
  brick:
    kind: rigid
    shape: {kind: box, size: [0.1, 0.1, 0.1]}
    place: {on: floor, at: [0.5, 0]}
    repeat: {kind: line, count: 3, step: [0.2, 0, 0]}
    look: LOOK
render: RENDER
"""


def plan(render="{}", wall="", look="{}"):
    return plan_case(load_text(CASE.replace("RENDER", render).replace("WALL", wall).replace("LOOK", look)))


def film(render="{}", wall=""):
    return plan(render, wall).render


def test_the_program_says_what_was_resolved():
    made = plan('{shots: {a: {camera: main, to: 0.5, speed: 0.5}}, overlay: {title: "it\'s {{ x }}"}}')
    assert read_film(emit(made)["render.py"].decode()) == made.render


def test_without_a_camera_all_that_moves_is_framed_with_what_stands_near():
    (camera,) = film()["cameras"].values()
    assert camera["frame"]["bodies"] == ["ball", "brick", "post"]
    low, high = np.array(camera["frame"]["within"])
    assert (low < (-2, -2, -0.01)).all()
    assert low[2] > -1, "what falls through the ground is not followed"
    assert (high > (3, 2, 2)).all()


@pytest.mark.parametrize(("mast", "bare"), [(1.6, {"cart": ["cart.bed"]}), (0.8, None)])
def test_decor_that_is_far_larger_than_its_body_is_not_framed(mast, bare):
    cart = f"""cart: {{shape: {{kind: compound, parts: {{
      bed: {{shape: {{kind: box, size: [0.3, 0.2, 0.1]}}}},
      mast: {{shape: {{kind: cylinder, radius: 0.01, height: {mast}}}, pose: {{pos: [0, 0, {mast / 2}]}}, decor: true}}
    }}}}, pose: {{pos: [0, 2, 1]}}}}"""
    assert film(wall=cart)["auto"].get("bare") == bare


@pytest.mark.parametrize(
    ("wall", "side"),
    [
        ("", -1),
        ("wall: {shape: {kind: box, size: [4, 0.1, 3]}, place: {on: floor, at: [0.3, -1]}}", 1),
        ("wall: {shape: {kind: box, size: [4, 0.1, 3]}, place: {on: floor, at: [0.3, -1]}, look: {opacity: 0.2}}", -1),
    ],
)
def test_it_does_not_stand_behind_a_wall(wall, side):
    (camera,) = film(wall=wall)["cameras"].values()
    assert math.copysign(1, camera["pos"][1]) == side


@pytest.mark.parametrize(("step", "axis"), [("[0.3, 0, 0.4]", 1), ("[0, 0.3, 0.4]", 0), ("[0.3, 0.3, 0.4]", None)])
def test_what_stands_flat_is_seen_from_its_broad_side(step, axis):
    text = CASE.replace("count: 3, step: [0.2, 0, 0]", f"count: 6, step: {step}").replace(
        "pos: [0, 0, 0.5]", "pos: [0.5, 0, 0.5]"
    )
    made = plan_case(load_text(text.replace("RENDER", "{}").replace("WALL", "").replace("LOOK", "{}"))).render
    way = np.array(made["cameras"]["main"]["frame"]["direction"])
    flat = abs(way[axis]) if axis is not None else max(abs(way[:2]))
    assert (flat > 3.5 * abs(way[1 - axis])) if axis is not None else tuple(way) == (0.55, -1.0, 0.3)


def test_frames_name_what_states_know():
    cameras = "{cameras: {a: {kind: still, frame: ['brick[0:2]', ball], direction: [0, -1, 0], margin: 0.2}, b: {kind: orbit, frame: ['brick[*]']}}}"
    a, b = film(cameras)["cameras"].values()
    assert a["frame"] == {
        "bodies": ["brick[0]", "brick[1]", "ball"],
        "margin": 0.2,
        "within": None,
        "direction": (0.0, -1.0, 0.0),
    }
    assert a["pos"][1] < -0.5
    assert b["frame"]["bodies"] == ["brick"]
    assert b["frame"]["fit"]
    assert b["look_at"] == pytest.approx((0.5, 0, 0.05), abs=0.01)
    assert b["height"] / b["radius"] == pytest.approx(0.45, abs=0.01)


def test_a_lens_is_a_field_of_view():
    cameras = "{cameras: {a: {kind: still, from: [0, -3, 1], look_at: ball, lens_mm: 24, f_stop: 2, focus: ball}, b: {kind: still, from: [0, -3, 1], look_at: ball, f_stop: 4, focus: brick}}}"
    a, b = film(cameras)["cameras"].values()
    assert a["fov"] == pytest.approx(53.13, abs=0.01)
    assert a["focus"] == {"body": "ball", "link": None}
    assert b["fov"] == 40
    assert b["focus"] == pytest.approx((0.5, 0, 0.05)), "of several bodies, their middle"


@pytest.mark.parametrize("lighting", ["studio", "daylight", "sunlight", "overcast", "golden_hour", "dark_stage"])
@pytest.mark.parametrize("camera", ["from: [0, -5, 1]", "from: [5, 0, 1]"])
def test_a_studio_is_built_around_the_camera(lighting, camera):
    made = film(f"{{lighting: {lighting}, cameras: {{a: {{kind: still, {camera}, look_at: [0, 0, 0]}}}}}}")
    ahead = np.array((0, 1) if "-5" in camera else (-1, 0))
    first = next(light for light in made["lights"].values() if "direction" in light)
    assert first["direction"][2] < 0
    assert np.dot(first["direction"][:2], ahead) > 0, "the key light does not shine into the camera"
    assert 0.3 < made["gain"] < 3
    assert made["backdrop"]["kind"] in ("wall", "cyclorama", "ground", "horizon")
    assert made["backdrop"]["planes"] == ["floor"]
    # The wall begins to rise at half of its radius; lamps, which shine downwards, are nearer in plan than their distance.
    assert made["backdrop"]["radius"] > 1.9 * max(light.get("distance", 0) for light in made["lights"].values())


def test_lights_of_the_author_take_the_place_of_a_studios():
    made = film(
        "{lights: {key: {kind: softbox, direction: [0, 0, -1], at: ball, distance: 2}, bulb: {kind: lamp, pos: [0, 0, 2]}}}"
    )
    assert list(made["lights"]) == ["key", "bulb", "ambient"]
    assert made["lights"]["key"] | {"color": ()} == {
        "kind": "softbox", "strength": 3.0, "color": (), "direction": (0, 0, -1), "at": (0, 0, 0.5), "distance": 2, "size": 0.48,
    }  # fmt: skip
    sky = film("{lights: {day: {kind: sky}}, exposure: 1}")
    assert list(sky["lights"]) == ["day"]
    # A white sheet under an irradiance of 3: 3/pi, made white, and one stop more.
    assert sky["gain"] == pytest.approx(2 * math.pi / 3, rel=1e-3)
    assert film("{ambient: 0.5}")["lights"]["fill"]["strength"] == 0.5


def _own_gain(direction: str) -> float:
    """Gain of a film from -y with one light of its own, whose irradiance makes a white sheet white."""
    section = f"lights: {{key: {{kind: sun, direction: {direction}, strength: {math.pi}}}}}, ambient: 0"
    return film(f"{{{section}, cameras: {{a: {{kind: still, from: [0, -5, 0], look_at: [0, 0, 0]}}}}}}")["gain"]


def test_own_lights_that_graze_what_is_seen_make_the_film_brighter():
    # Lambert's phase function: a white ball that is lit from the side shows 1/pi of what it shows lit from the camera,
    # and 0.6 of that is taken for usual.
    assert _own_gain("[0, 1, 0]") == pytest.approx(1, abs=1e-3), "from the camera"
    assert _own_gain("[1, 1, 0]") == pytest.approx(1, abs=1e-3), "over the shoulder"
    angle = math.atan2(4, 1)
    ball = (math.sin(angle) + (math.pi - angle) * math.cos(angle)) / math.pi
    assert _own_gain("[4, 1, 0]") == pytest.approx(0.6 / ball, rel=1e-3)
    assert _own_gain("[1, 0, 0]") == pytest.approx(MOST_GRAZING, rel=1e-3), "from the side"


def test_a_lamp_is_measured_where_the_camera_looks():
    lamp = "lights: {bulb: {kind: lamp, pos: [0, -2, 0], strength: 12.5664}}, ambient: 0"
    near, far = (
        film(f"{{{lamp}, cameras: {{a: {{kind: still, from: [0, {y - 3}, 0], look_at: [0, {y}, 0]}}}}}}")["gain"]
        for y in (-1, 2)
    )
    assert near == pytest.approx(0.25, rel=1e-3), "4/r^2 at 1 m"
    assert far == pytest.approx(4, rel=1e-3), "at 4 m"


def test_a_ground_with_a_colour_of_its_own_is_kept():
    text = CASE.replace("kind: plane}}", "kind: plane}, look: {color: grass}}")
    made = plan_case(load_text(text.replace("RENDER", "{}").replace("WALL", "").replace("LOOK", "{}"))).render
    assert made["backdrop"]["planes"] == []


def test_shots_take_from_the_film_what_they_do_not_say():
    made = film(
        "{during: [0.5, 1.5], speed: 0.5, shots: {a: {camera: main}, b: {camera: main, from: 1, to: 9, speed: 2, hold: 1}}}"
    )
    assert made["shots"] == [
        {"name": "a", "camera": "main", "from": 0.5, "to": 1.5, "speed": 0.5, "hold": 0.0},
        {"name": "b", "camera": "main", "from": 1.0, "to": 2.0, "speed": 2.0, "hold": 1.0},
    ]


def test_nothing_of_it_touches_the_physics():
    plain = plan()
    looks = [
        "{color: {palette: cividis}}",
        "{finish: brushed_metal, color: red}",
        "{opacity: 0.5, vary: {hue: 0.1}}",
    ]
    renders = [
        "{lighting: dark_stage, motion_blur: 0.5}",
        "{shots: {a: {camera: main, hold: 1}}, overlay: {time: true}}",
    ]
    for other in [plan(look=look) for look in looks] + [plan(render) for render in renders]:
        assert other.sim_digest == plain.sim_digest
        assert other.render_digest != plain.render_digest


def test_copies_take_the_colours_of_a_palette_in_turn():
    made = plan(look="{color: {palette: tol_bright, start: 6}, finish: silicone}")
    group = next(group for group in made.bodies if group.name == "brick")
    colors = [PALETTES["tol_bright"][k] for k in (6, 0, 1)]
    assert [entity.surface.rgba[:3] for entity in group.entities] == [
        pytest.approx(rgb(color), abs=1e-4) for color in colors
    ]
    looks = emit(made)["looks.json"].decode()
    assert '"brick[1]": {"color": [0.2667, 0.4667, 0.6667], "opacity": 1.0, "finish": "silicone"' in looks
