"""Walls of places as pictures."""

import numpy as np
import pytest

from text2sim.compiler.build import plan_case
from text2sim.compiler.film_places import PLACES
from text2sim.rendering.backdrop import Wall
from text2sim.rendering.meshes import RenderMesh
from text2sim.rendering.skyline import ROWS
from text2sim.rendering.walls import COLUMNS, SKIRTING, WALLS, wall_picture
from text2sim.spec_schema.load import load_text

NOTHING = RenderMesh(np.zeros((0, 3)), np.zeros((0, 3), int), np.zeros((0, 3)))
CASE = """
text2sim: 2
name: drop
scene: {duration: 0.4, statics: {floor: {shape: {kind: plane}}}}
bodies: {box: {kind: rigid, shape: {kind: box, size: [0.6, 0.6, 0.6]}, pose: {pos: [0, 0, 0.5]}}}
render: RENDER
"""


def picture(kind, stage=2.0, *, window=False):
    away = 3 * stage
    return wall_picture(kind, Wall(NOTHING, None, (9 * away, 3.2 * away), away), stage, window=window)


def backdrop(render):
    return plan_case(load_text(CASE.replace("RENDER", render))).render["backdrop"]


@pytest.mark.parametrize("kind", WALLS)
def test_a_wall_keeps_about_its_colour(kind):
    made = picture(kind)
    assert made.shape[1] == COLUMNS
    assert 0.6 < made.mean() < 1.1
    assert made.min() > 0.3
    assert made.max() < 1.6


def test_the_window_lights_a_part_of_the_wall_beside_the_subject():
    plain, lit = picture("plaster"), picture("plaster", window=True)
    ratio = lit / plain
    assert ratio.max() == pytest.approx(1.0, abs=0.02)
    bright = ratio > 0.95
    assert 0.005 < bright.mean() < 0.1
    assert np.argwhere(bright)[:, 1].mean() < COLUMNS / 2, "the key light stands on the right"


def test_a_room_has_a_skirting_board_and_a_table_top_has_none():
    for stage, there in ((2.0, True), (0.3, False)):
        made = picture("plaster", stage)
        rows_per_metre = len(made) / (3.2 * 3 * stage)
        board = made[int(0.3 * SKIRTING * rows_per_metre)].mean()
        above = made[int(2.0 * SKIRTING * rows_per_metre)].mean()
        assert (board > 1.05 * above) == there


def test_places_say_what_is_behind_them():
    for name, place in PLACES.items():
        made = backdrop(f"{{setting: {name}}}")
        assert made["kind"] == place.backdrop
        assert made["wall"] == place.wall
        assert made["wall"] in WALLS
        assert made.get("skyline", "wood") in ROWS
    assert backdrop("{setting: kitchen}")["window"]
    for dark in ("lighting: dark_stage", "lights: {key: {kind: sun}}"):
        assert "window" not in backdrop(f"{{setting: kitchen, {dark}}}"), "its light comes from somewhere else"
    assert "skyline" not in backdrop("{setting: meadow, backdrop: none}"), "the author chose what is behind"


def test_a_light_out_of_doors_brings_its_sky_and_the_ground_its_pattern():
    golden = backdrop("{lighting: golden_hour}")
    assert golden["skyline"] == "wood"
    assert golden["sky"] != backdrop("{setting: meadow}")["sky"]
    assert backdrop("{setting: street, lighting: golden_hour}") | {"floor": None} == golden | {
        "floor": None, "skyline": "town", "wall": "plain",
    }  # fmt: skip
    assert backdrop("{lighting: golden_hour, background: '#dfe6ea'}")["skyline"] == "wood", "that is its haze"
    assert backdrop("{backdrop: horizon, lights: {sun: {kind: sun}}}")["skyline"] == "wood"
    assert "skyline" not in backdrop("{backdrop: horizon, background: '#101418'}"), "it is night"
    assert "skyline" not in backdrop("{lighting: golden_hour, backdrop: ground}")
    assert backdrop("{setting: room, lighting: golden_hour}")["kind"] == "wall"
    assert "floor" not in golden, "a ground without a colour has that of the haze"
    for color, pattern in (("forestgreen", "grass"), ("peru", "earth"), ("gray", "asphalt")):
        ground = CASE.replace("{shape: {kind: plane}}", f"{{shape: {{kind: plane}}, look: {{color: {color}}}}}")
        made = plan_case(load_text(ground.replace("RENDER", "{lighting: sunlight}"))).render["backdrop"]
        assert made["floor"]["pattern"] == pattern
        assert made["planes"] == []
