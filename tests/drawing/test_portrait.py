"""Pictures for the gallery; light and glass."""

from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from pictures import resolved
from PIL import Image

from text2sim.compiler.build import resolve_case
from text2sim.drawing.framing import subject_bounds
from text2sim.drawing.lighting import Light, light_up, sky, soft_lamp
from text2sim.drawing.picture import Style, paint
from text2sim.drawing.portrait import BACKGROUND, portrait
from text2sim.drawing.stage import stage
from text2sim.drawing.surfaces import decoded, encoded
from text2sim.drawing.view import parallel, perspective
from text2sim.spec_schema.load import load_case

BOX = "box: {kind: rigid, shape: {kind: box, size: [1, 1, 1]}, pose: {pos: [0, 0, 0]}, look: {color: crimson}}"
ROBOT = """\
<robot name="pole">
  <material name="green"><color rgba="0 0.5 0 1"/></material>
  <link name="base">
    <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="1 1 1"/></geometry></collision>
    <visual><origin xyz="0 0 0.5"/><geometry><cylinder radius="0.1" length="2"/></geometry><material name="green"/></visual>
  </link>
</robot>
"""


def pixels_of(png: bytes) -> np.ndarray:
    return np.asarray(Image.open(BytesIO(png)).convert("RGB"), float) / 255


def test_portrait_is_centred_whole_and_on_light_ground() -> None:
    pixels = pixels_of(portrait(resolved(BOX), (200, 150)))
    assert pixels.shape == (150, 200, 3)
    red = pixels[:, :, 0] > pixels[:, :, 1] + 0.2
    rows, columns = np.nonzero(red)
    assert (rows.min() + rows.max()) / 2 == pytest.approx(75, abs=4)
    assert (columns.min() + columns.max()) / 2 == pytest.approx(100, abs=4)
    filled = max(np.ptp(rows) / 150, np.ptp(columns) / 200)
    assert filled == pytest.approx(0.8, abs=0.05)
    assert pixels[2, 2] == pytest.approx(BACKGROUND, abs=0.02)
    assert (pixels[~red].min() < 0.9) and (pixels[~red].mean() > 0.88), "a shadow, and a soft one"


def test_robot_is_drawn_with_its_own_surfaces(tmp_path: Path) -> None:
    (tmp_path / "pole.urdf").write_text(ROBOT)
    (tmp_path / "case.yaml").write_text(
        "text2sim: 2\nname: pole\nscene: {duration: 1}\nbodies: {pole: {kind: articulated, file: pole.urdf}}\n"
    )
    case = resolve_case(load_case(tmp_path))
    rough, fine = stage(case), stage(case, fine=True)
    assert np.concatenate([p.triangles for p in rough]).reshape(-1, 3).max(axis=0) == pytest.approx((0.5, 0.5, 0.5))
    (prop,) = fine
    assert prop.rgb == pytest.approx((0, 0.5, 0))
    assert prop.triangles.reshape(-1, 3).max(axis=0) == pytest.approx((0.1, 0.1, 1.5), abs=0.002)


def test_shadow_lies_where_the_light_does_not_reach() -> None:
    case = resolved(BOX)  # the ground is half a metre below it
    props = stage(case)
    lamps = soft_lamp((1.0, 0.0, 1.0), (0.8, 0.8, 0.8), 1, 0.0)
    light = light_up(props, lamps, 0.1, subject_bounds(props))
    view = parallel(np.eye(3), (0.0, 0.0, 5.0), 20.0, (120, 60))
    picture = paint(props, view, light, Style((1.0, 1.0, 1.0)))
    gray = picture.pixels.mean(axis=2)

    def at(x: float, y: float) -> float:
        return float(gray[int(30 - 20 * y), int(60 + 20 * x)])

    # At 45 degrees it reaches from 0 to 2 m aside, away from the light; the box hides a quarter of it.
    assert at(-0.8, 0) < 0.6 * at(1.2, 0)
    assert at(-1.8, 0) < 0.6 * at(1.2, 0)
    assert at(-2.2, 0) == pytest.approx(at(1.2, 0), abs=0.02)
    assert at(-0.8, 0.8) == pytest.approx(at(1.2, 0), abs=0.02)


def test_glass_hides_as_much_as_its_opacity() -> None:
    pane = "pane: {kind: rigid, shape: {kind: box, size: [1, 0.02, 1]}, pose: {pos: [0, -2, 0]}, look: {color: black, opacity: %s}}"
    view = perspective((0, -8, 0), (0, 0, 0), (0, 0, 1), 20, (60, 60))
    seen = {}
    for opacity in (0.0, 0.5, 1.0):
        picture = paint(stage(resolved(BOX, pane % opacity)), view, Light([], 0.5), Style((1.0, 1.0, 1.0)))
        seen[opacity] = decoded(picture.pixels[30, 30])[0]
    assert seen[1.0] == pytest.approx(0.0, abs=1e-3)
    assert seen[0.5] == pytest.approx(seen[0.0] / 2, rel=0.02)


def test_edges_are_smooth() -> None:
    view = perspective((0.3, -8, 0.2), (0, 0, 0), (0.1, 0, 1), 20, (60, 60))
    picture = paint(stage(resolved(BOX)), view, Light([], 0.5), Style((1.0, 1.0, 1.0), planes=False))
    parts = set(np.unique(picture.coverage).tolist())
    assert parts == {0.0, 0.25, 0.5, 0.75, 1.0}


def test_background_keeps_its_colour() -> None:
    colors = np.array([(1.0, 1.0, 1.0), (0.85, 0.88, 0.93), (0.2, 0.5, 0.0)], np.float32)
    assert encoded(decoded(colors)) == pytest.approx(colors, abs=1e-3)


def test_sky_gives_a_level_surface_all_its_light() -> None:
    for count in (1, 7, 40):
        total = sum(lamp.color[0] * lamp.direction[2] for lamp in sky(count, (0.5, 0.5, 0.5), (0.5, 0.5, 0.5)))
        assert total == pytest.approx(0.5, rel=0.02)
