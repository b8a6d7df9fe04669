"""The page that shows how a case starts."""

import subprocess
import sys
from io import BytesIO
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from pictures import resolved
from PIL import Image

from text2sim.compiler.build import Resolution, resolve_case
from text2sim.drawing.canvas import Canvas, clipped, shortened, text_width
from text2sim.drawing.framing import subject_bounds
from text2sim.drawing.labels import draw_labels, place_labels
from text2sim.drawing.layout import SIZE, layout
from text2sim.drawing.lighting import Light
from text2sim.drawing.marks import JointMark, arrow_marks, camera_marks, joint_marks
from text2sim.drawing.panel import fitted, nice_step, ticks
from text2sim.drawing.picture import Style, paint
from text2sim.drawing.signs import SignMarks, draw_marks
from text2sim.drawing.stage import stage
from text2sim.spec_schema.load import load_case, load_text


@pytest.mark.parametrize("name", ["brick_wall", "crank_slider"])
def test_page_of_a_case(cases: Path, name: str) -> None:
    page = Image.open(BytesIO(layout(resolve_case(load_case(cases / name)))))
    assert page.size == SIZE
    pixels = np.asarray(page.convert("RGB"), int)
    height, width = pixels.shape[:2]
    for rows in (slice(0, height // 2), slice(height // 2, height)):
        for columns in (slice(0, width // 2), slice(width // 2, width)):
            part = pixels[rows, columns].reshape(-1, 3)
            drawn = (part.max(axis=1) < 190) | (np.ptp(part, axis=1) > 60)
            assert 0.01 < drawn.mean() < 0.97, "every panel shows something, and none is full of it"


def test_page_of_everything_is_the_same_each_time(zoo: Resolution) -> None:
    assert layout(zoo, "variant soft") == layout(zoo, "variant soft")


def test_page_needs_neither_the_engine_nor_torch(cases: Path, tmp_path: Path) -> None:
    script = (
        "import sys; sys.argv = ['text2sim', 'show', sys.argv[1], '--png', sys.argv[2]]\n"
        "from text2sim.cli.main import run\n"
        "try: run()\n"
        "except SystemExit as end: assert not end.code, end.code\n"
        "print([name for name in ('genesis', 'torch', 'matplotlib', 'scipy', 'trimesh') if name in sys.modules])"
    )
    command = [sys.executable, "-c", script, str(cases / "domino_spiral"), str(tmp_path / "page.png")]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.rstrip().endswith("[]"), done.stdout[-200:]
    assert (tmp_path / "page.png").stat().st_size > 50_000


def test_ground_and_huge_statics_do_not_decide_the_frame() -> None:
    ball = "ball: {kind: rigid, shape: {kind: sphere, radius: 0.5}, pose: {pos: [0, 0, 1]}}"
    low, high = subject_bounds(stage(resolved(ball)))
    assert (low, high) == (pytest.approx((-0.5, -0.5, 0.5), abs=0.02), pytest.approx((0.5, 0.5, 1.5), abs=0.02))


def test_a_ramp_is_shown_whole_and_a_floor_is_not() -> None:
    text = """\
text2sim: 2
name: run
scene:
  duration: 1
  statics:
    ramp: {shape: {kind: box, size: [1, 0.1, 0.02]}, pose: {pos: [0, 0, 0.9], euler_deg: [0, 20, 0]}}
    bin: {shape: {kind: cup, radius: 0.15, height: 0.2, thickness: 0.01}, pose: {pos: [1.8, 0, 0.3]}}
    slab: {shape: {kind: box, size: [30, 30, 0.1]}, pose: {pos: [0, 0, 0]}}
bodies:
  marble: {kind: rigid, shape: {kind: sphere, radius: 0.02}, pose: {pos: [-0.4, 0, 1.1]}}
"""
    low, high = subject_bounds(stage(resolve_case(load_text(text))))
    assert -1 < low[0] < -0.46, "all of the ramp"
    assert 1.95 < high[0] < 2.5, "and the bin, and little of the slab"
    assert low[2] < 0.06
    assert high[2] == pytest.approx(1.12, abs=0.01)


def test_statics_near_moving_bodies_are_shown_and_large_ones_in_part(zoo: Resolution) -> None:
    low, high = subject_bounds(stage(zoo))
    assert (np.abs(low) < 3).all(), "the slab is forty metres long"
    assert (np.abs(high) < 3).all()
    assert low[2] == pytest.approx(-0.2), "it is shown as deep as it is"


def test_labels_do_not_overlap_and_belong_to_their_bodies(zoo: Resolution) -> None:
    props = stage(zoo)
    panel = fitted("front", subject_bounds(props), (10, 20, 710, 480))
    picture = paint(props, panel.view, Light([], 1.0), Style((1.0, 1.0, 1.0), planes=False))
    canvas = Canvas(np.ones((500, 720, 3)))
    labels = draw_labels(canvas, panel, picture, props, {name: name for name in zoo.loaded.case.bodies})
    assert len(labels) >= 12
    for a, b in combinations(labels, 2):
        apart = a.box[2] < b.box[0] or b.box[2] < a.box[0] or a.box[3] < b.box[1] or b.box[3] < a.box[1]
        assert apart, (a.text, b.text)
    for label in labels:
        assert label.box[0] >= 0
        assert label.box[1] >= 0
        assert label.box[2] <= panel.view.width
        assert label.box[3] <= panel.view.height
        x, y = (int(value) for value in label.target)
        shown = {picture.owner[y, x], picture.glazed[y, x]} - {-1}
        assert label.key in {props.props[number].body for number in shown}


def test_label_stands_on_free_ground_beside_its_thing() -> None:
    seen = np.full((200, 300), -1)
    seen[80:120, 100:160] = 0
    (label,) = place_labels([("box", "box", 50.0)], seen, ["box"], 19.0, np.zeros_like(seen, bool))
    left, upper, right, lower = (int(value) for value in label.box)
    assert (seen[upper:lower, left:right] == -1).all()
    assert min(abs(upper - 120), abs(lower - 80), abs(left - 160), abs(right - 100)) < 25


def test_a_hinge_seen_along_its_axis_shows_which_way_it_counts() -> None:
    """Anticlockwise, seen from where its axis points to; the open quarter of the arrow is the last one."""

    def red(end: float) -> np.ndarray:
        panel = fitted("front", (np.full(3, -0.1), np.full(3, 0.1)), (0, 0, 100, 100))
        canvas = Canvas(np.ones((100, 100, 3)))
        draw_marks(canvas, panel, SignMarks([JointMark("hinge", ((0, 0, 0), (0, end, 0)), "wheel")]))
        pixels = np.asarray(canvas.finished(), int)
        return pixels[..., 0] - pixels[..., 1] > 100

    towards, away = red(-0.05), red(0.05)
    assert towards[:50, 51:].sum() > 1.3 * away[:50, 51:].sum(), "upper right"
    assert away[51:, 51:].sum() > 1.3 * towards[51:, 51:].sum(), "lower right"


def test_joints_arrows_and_cameras_of_the_case(zoo: Resolution) -> None:
    joints = {joint.body: joint for joint in joint_marks(zoo)}
    assert {name: joint.kind for name, joint in joints.items()} == {
        "hammer": "ball",
        "wheel": "hinge",
        "shaker": "slider",
        "lift": "path",
    }
    assert joints["hammer"].points[0] == pytest.approx((-1, 1, 0.3))
    start, end = (np.array(point) for point in joints["wheel"].points)
    assert start + end == pytest.approx((-3, 2, 1.2)), "it goes through the middle"
    assert np.abs(end - start) == pytest.approx((0, 0.05, 0), abs=1e-9)
    assert joints["shaker"].points == (
        pytest.approx((-0.2 / 2**0.5, -1 - 0.2 / 2**0.5, 0.3)),
        pytest.approx((0.2 / 2**0.5, -1 + 0.2 / 2**0.5, 0.3)),
    )
    assert joints["lift"].points[-1] == pytest.approx((1.5, -1, 0.8))
    arrows = arrow_marks(zoo, stage(zoo))
    texts = {arrow.kind: arrow.text for arrow in arrows if arrow.text}
    assert texts == {
        "velocity": "2.24 m/s",
        "spin": "5 rad/s",
        "force": "0.2 to 4 N at 0.5 s",
        "torque": "1 N m",
        "impulse": "1 N s at 0.3 s",
    }
    assert sum(arrow.kind == "force" for arrow in arrows) == 5
    hit = next(arrow for arrow in arrows if arrow.kind == "impulse")
    cone = zoo.placed["cone"][0]
    assert hit.start == pytest.approx(np.add(cone.pos, (0, 0, 0.1)))
    assert [camera.name for camera in camera_marks(zoo)] == ["round", "with", "ride"]
    corner = np.array(camera_marks(zoo)[0].corners[0])
    assert corner[0] < 0 < 0.5 < corner[2], "the upper left corner of its picture"


def test_a_derived_camera_is_no_mark() -> None:
    case = resolved("ball: {kind: rigid, shape: {kind: sphere, radius: 0.5}}")
    assert camera_marks(case) == []


def test_round_numbers() -> None:
    assert [nice_step(span, 5) for span in (1.0, 2.4, 0.03, 70)] == [0.2, 0.5, pytest.approx(0.01), 20]
    assert ticks(-0.25, 0.31, 6) == pytest.approx([-0.2, -0.1, 0, 0.1, 0.2, 0.3])


def test_lines_are_cut_at_the_frame() -> None:
    assert clipped((-5, 5), (15, 5), (0, 0, 10, 10)) == ((0, 5), (10, 5))
    assert clipped((-5, -5), (-1, 20), (0, 0, 10, 10)) is None
    assert clipped((float("nan"), 1), (5, 5), (0, 0, 10, 10)) is None


def test_long_text_is_shortened_to_fit() -> None:
    text = "A long story about nothing at all. " * 20
    short = shortened(text, 200, 14)
    assert short.endswith("…")
    assert 150 < text_width(short, 14) <= 200


def test_springs_are_marked_from_end_to_end() -> None:
    text = """
text2sim: 2
name: hung
scene: {duration: 1, statics: {beam: {shape: {kind: box, size: [1, 0.1, 0.1]}, pose: {pos: [0, 0, 2]}}}}
bodies: {bob: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0.3, 0, 1], euler_deg: [0, 180, 0]}}}
actions:
  controls:
    hang: {kind: spring, body: bob, point: [0, 0, -0.1], to: beam, to_point: [0.3, 0, -0.05], stiffness: 20}
"""
    (mark,) = joint_marks(resolve_case(load_text(text)))
    assert (mark.kind, mark.body) == ("spring", "bob")
    assert mark.points == (pytest.approx((0.3, 0, 1.1)), pytest.approx((0.3, 0, 1.95)))
