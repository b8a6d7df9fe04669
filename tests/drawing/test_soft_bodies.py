"""Soft bodies, cloth and grains are drawn as they are at rest, and cameras see them."""

import numpy as np
import pytest
from PIL import Image

from text2sim.compiler.build import resolve_case
from text2sim.drawing.layout import layout
from text2sim.drawing.stage import STAGE_TRIANGLES, _level, stage
from text2sim.legibility.layout import at_start
from text2sim.spec_schema.load import load_text

CASE = """\
text2sim: 2
name: soft
scene: {duration: 0.1, statics: {floor: {shape: {kind: plane}}}}
bodies:
  word: {kind: soft, shape: {kind: text, text: Ab, height: 0.2, depth: 0.1}, pose: {pos: [0, 0, 1]}, repeat: {kind: glyphs}}
  bar: {kind: soft, solver: mpm, shape: {kind: box, size: [0.4, 0.1, 0.1]}, pose: {pos: [1, 0, 1]}}
  curtain:
    kind: cloth
    shape: {kind: sheet, size: [0.4, 0.6], texture: flag.png}
    pose: {pos: [-1, 0, 1], euler_deg: [90, 0, 0]}
  rag: {kind: cloth, shape: {kind: sheet, size: [0.4, 0.6]}, pose: {pos: [0, 1, 1]}, look: {color: yellow}}
  heap: {kind: granular, shape: {kind: cone, radius: 0.1, height: 0.1}, pose: {pos: [1, 1, 0.5]}}
  water: {kind: liquid, shape: {kind: box, size: [0.2, 0.2, 0.1]}, pose: {pos: [0.5, 1, 0.5]}, look: {opacity: 0.5}}
  ball: {kind: snow, shape: {kind: sphere, radius: 0.1}, pose: {pos: [-0.5, 1, 0.5]}}
  line: {kind: rope, length: 0.5, radius: 0.01, pose: {pos: [-1, 1, 1.5]}}
render: {cameras: {main: {kind: still, from: [0, -4, 2], look_at: [0, 0.5, 0.8], fov_deg: 50}}}
"""


@pytest.fixture(scope="module")
def soft(tmp_path_factory):
    folder = tmp_path_factory.mktemp("soft")
    # Left half red, right half blue; a green strip at the top.
    picture = np.zeros((60, 40, 3), np.uint8)
    picture[:, :20, 0] = picture[:, 20:, 2] = 255
    picture[:6] = (0, 255, 0)
    Image.fromarray(picture).save(folder / "flag.png")
    return resolve_case(load_text(CASE, folder / "case.yaml"))


def of(props, name):
    return next(prop for prop in props if prop.name == name)


def test_every_body_is_there_where_it_starts(soft):
    props = stage(soft)
    assert {prop.name for prop in props} == {
        "floor", "word[0]", "word[1]", "bar", "curtain", "rag", "heap", "water", "ball", "line",
    }  # fmt: skip
    corners = of(props, "bar").triangles.reshape(-1, 3)
    assert corners.min(0) == pytest.approx((0.8, -0.05, 0.95))
    assert corners.max(0) == pytest.approx((1.2, 0.05, 1.05))
    curtain = of(props, "curtain").triangles.reshape(-1, 3)
    assert np.ptp(curtain, axis=0) == pytest.approx((0.4, 0, 0.6), abs=1e-9)
    assert of(props, "heap").triangles.reshape(-1, 3).max(0)[2] == pytest.approx(0.55)
    assert of(props, "water").opacity == 0.5
    assert all(prop.moves for prop in props if prop.name != "floor" and prop.name != "line")


def test_a_picture_lies_on_its_sheet_the_right_way_up(soft):
    props = stage(soft)
    number = [prop.name for prop in props].index("curtain")
    own = props.owner == number
    middles, colors = props.triangles[own].mean(axis=1), props.colors[own]
    assert not props.culled[own].any(), "it is seen from both sides"
    for part, channel in (
        ((middles[:, 2] < 1.2) & (middles[:, 0] < -1.02), 0),
        ((middles[:, 2] < 1.2) & (middles[:, 0] > -0.98), 2),
        (middles[:, 2] > 1.26, 1),
    ):
        assert part.any()
        assert (colors[part].argmax(axis=1) == channel).all()
    rag = props.owner == [prop.name for prop in props].index("rag")
    assert props.colors[rag][:, :2].min() > 0.8
    assert props.colors[rag][:, 2].max() < 0.2


def test_cameras_see_them(soft):
    seen = at_start(soft, "main").shares
    assert set(seen) >= {"word[0]", "word[1]", "bar", "curtain", "rag", "heap", "water", "ball", "line"}
    assert seen["curtain"] > seen["rag"] > 0, "one stands upright, the other lies"


def test_the_page_is_drawn(soft):
    assert layout(soft).startswith(b"\x89PNG")


def test_coarse_meshes_keep_their_triangles():
    assert _level([(10, 5), (1000, 1)], 2000) == 1000
    most = _level([(10, 5), (1000, 1), (90_000, 1)], 20_000)
    assert 18_000 < most < 19_000
    assert _level([(500, 10), (400, 10)], 2000) == 100
    assert _level([], STAGE_TRIANGLES) == 0


@pytest.mark.parametrize(
    ("bent", "low", "high"), [("sag: 0.1", 0.9, 1.0), ("over: 0.05, over_at: 0.6", 1 - (0.6 - np.pi / 40), 1.05)]
)
def test_sheets_that_are_bent_at_the_start_are_drawn_so(bent, low, high, tmp_path):
    case = f"text2sim: 2\nname: bent\nscene: {{duration: 0.1}}\nbodies: {{s: {{kind: cloth, shape: {{kind: sheet, size: [1, 0.2], {bent}}}, pose: {{pos: [0, 0, 1]}}}}}}\n"
    (sheet,) = stage(resolve_case(load_text(case, tmp_path / "case.yaml")))
    z = sheet.triangles.reshape(-1, 3)[:, 2]
    assert (z.min(), z.max()) == pytest.approx((low, high), abs=2e-3)
