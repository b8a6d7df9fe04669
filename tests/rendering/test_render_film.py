"""Films: the right place, only what is not yet done, parts that fit together."""

import os
import subprocess
import sys
from pathlib import Path

import av
import numpy as np
import pytest
from filmed import FILM, MakeRun
from PIL import Image
from typer.testing import CliRunner

from text2sim.cli.main import app
from text2sim.cli.render import _suffix
from text2sim.legibility.film import Watcher
from text2sim.recording.film_record import read_recording
from text2sim.rendering.film import Filming, FilmProgress
from text2sim.rendering.legibility import write_legibility
from text2sim.rendering.renderer import mitsuba
from text2sim.rendering.scene import FilmStage, sensor
from text2sim.rendering.trace import RIM, undimmed
from text2sim.spec_schema.errors import RunError
from text2sim.templates.cameras import Cameras, project

pytestmark = pytest.mark.usefixtures("tracer")

CRATE = {"half": 0.4, "pos": (0, 0, 0.4), "color": (0.8, 0.2, 0.1)}
SLIDING = CRATE | {"velocity": (1.0, 0, 0)}


def film(folder: Path, size: tuple[int, int] = (32, 18)) -> Filming:
    return Filming(read_recording(folder), "draft", size=size, samples=4)


def traced(filming: Filming, **options: tuple[int, int]) -> list[bool]:
    """Render and return of each picture whether it was traced."""
    told: list[FilmProgress] = []
    (reel,) = filming.reels()
    filming.render(reel, told.append, **options)
    return [bool(progress.seconds) for progress in told]


def test_points_are_where_the_preview_shows_them(make_run: MakeRun) -> None:
    places = {"a": (0.9, 0.4, 0.2), "b": (-1.0, 1.0, 1.2), "c": (0.3, -1.0, 0.1)}
    cameras = {
        "main": {"kind": "still", "up": (0.2, 0, 1), "fov": 50.0, "pos": (1.0, -4.0, 2.0), "look_at": (0.2, 0, 0.5)},
        "round": {"kind": "orbit", "up": (0, 0, 1), "fov": 35.0, "look_at": (0, 0, 0.4), "radius": 5.0, "height": 3.0,
                  "start": 1.0, "turn": 2.0},
    }  # fmt: skip
    paints = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    boxes = {k: {"half": 0.06, "pos": p, "color": c} for (k, p), c in zip(places.items(), paints, strict=True)}
    recording = read_recording(make_run(boxes, cameras=cameras))
    views = Cameras(recording.film, recording.states)
    stage, watcher = FilmStage(recording), Watcher(recording)
    aov = mitsuba().load_dict({"type": "aov", "aovs": "paint:albedo,depth:depth"})
    for name in cameras:
        view = views.view(name, 0.2, 0.5)
        made = mitsuba().render(stage.at(0.2).solid, sensor=sensor(view, (320, 180)), integrator=aov, spp=1, seed=0)
        paint, depth = np.split(np.array(made, np.float32)[..., -4:], [3], axis=2)
        sight = watcher.recorded.sight(0.2, view, (320, 180))
        expected = project(view, np.array(list(places.values())), 320 / 180)
        for k, (across, up, away) in enumerate(expected):
            rows, columns = np.nonzero((paint[..., k] > 0.3) & (paint.max(axis=2) == paint[..., k]))
            for found in ((rows, columns), np.nonzero(sight.mask(k))):
                middle = (found[1].mean() + 0.5, found[0].mean() + 0.5)
                assert middle == pytest.approx(((1 + across) * 160, (1 - up) * 90), abs=1.0)
            assert depth[rows, columns].mean() == pytest.approx(away, rel=0.1)


def test_what_carries_a_camera_stays_in_its_picture_while_it_swings(make_run: MakeRun) -> None:
    boxes = {"arm": {"half": 0.06, "pos": (0, 0, 1), "velocity": (1.0, 0, 0), "spin": 2.0, "color": (1, 0, 0)},
             "post": {"half": 0.06, "pos": (0.4, 1.0, 1.0), "color": (0, 1, 0)}}  # fmt: skip
    # It looks along the y of the arm with z up: x is to the right.
    camera = {"kind": "mounted", "body": "arm", "link": "arm", "pos": (0.3, -1.5, 0.2), "look_at": (0.3, 0, 0.2),
              "up": (0, 0, 1), "fov": 50.0}  # fmt: skip
    recording = read_recording(make_run(boxes, cameras={"main": camera}))
    views, stage, watcher = Cameras(recording.film, recording.states), FilmStage(recording), Watcher(recording)
    aov = mitsuba().load_dict({"type": "aov", "aovs": "paint:albedo"})
    focal = 90 / np.tan(np.radians(25))
    for t in (0.0, 0.2, 0.4):
        view = views.view("main", t)
        # The post in the frame of the arm, which has moved by t along x and turned by 2 t about y.
        x, y, z = 0.4 - t, 1.0, 0.0
        x, z = x * np.cos(2 * t) - z * np.sin(2 * t), x * np.sin(2 * t) + z * np.cos(2 * t)
        made = mitsuba().render(stage.at(t).solid, sensor=sensor(view, (320, 180)), integrator=aov, spp=1, seed=0)
        paint = np.array(made, np.float32)[..., -3:]
        sight = watcher.recorded.sight(t, view, (320, 180))
        for k, (across, up, away) in enumerate([(-0.3, -0.2, 1.5), (x - 0.3, z - 0.2, y + 1.5)]):
            film, preview = (paint[..., k] > 0.3) & (paint.max(axis=2) == paint[..., k]), sight.mask(k)
            for rows, columns in (np.nonzero(film), np.nonzero(preview)):
                middle = (columns.mean() + 0.5, rows.mean() + 0.5)
                assert middle == pytest.approx((160 + focal * across / away, 90 - focal * up / away), abs=1.0)


def test_a_second_render_does_nothing_and_a_change_only_what_it_touches(make_run: MakeRun) -> None:
    folder = make_run({"crate": SLIDING})
    assert traced(film(folder)) == [True] * 4
    assert traced(film(folder)) == [False] * 4
    make_run({"crate": SLIDING}, overlay={"title": "Slide", "time": True, "values": [], "inset": False})
    assert traced(film(folder)) == [False] * 4, "what is written into pictures is not part of them"
    make_run({"crate": SLIDING}, end=0.3)
    assert traced(film(folder)) == [False] * 3
    make_run({"crate": SLIDING}, gain=1.2)
    assert traced(film(folder)) == [True] * 4
    assert not list((folder / "render" / "frames").glob(".*"))


def test_pictures_are_the_same_each_time_and_still_where_nothing_moves(make_run: MakeRun) -> None:
    filming = film(make_run({"crate": CRATE, "far": SLIDING | {"half": 0.05, "pos": (-0.4, -2.0, 0.3)}}))
    frames = filming.reels()[0].frames
    first, again, later = (filming.develop(filming.trace(frames[k])).astype(int) for k in (0, 0, 1))
    assert (first == again).all()
    assert np.abs(first[:6] - later[:6]).mean() < 1.0, "the same noise in every picture does not flicker"


def test_parts_make_one_film(make_run: MakeRun) -> None:
    folder = make_run({"crate": SLIDING})
    assert traced(film(folder), shard=(0, 2)) == [True] * 2
    with pytest.raises(RunError, match="2 of 4 pictures of draft are not rendered yet: 1, 3"):
        film(folder).encode(film(folder).reels()[0])
    assert traced(film(folder), shard=(1, 2)) == [True] * 2
    video = film(folder).encode(film(folder).reels()[0])
    with av.open(str(video)) as container:
        stream = container.streams.video[0]
        assert (stream.width, stream.height) == (32, 18)
        assert stream.codec_context.colorspace == 1
        assert sum(1 for _ in container.decode(stream)) == 4


def test_workers_trace_the_pictures_of_one_film(make_run: MakeRun, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = make_run({"crate": SLIDING})
    monkeypatch.setattr(Filming, "trace", lambda *_: pytest.fail("a picture was traced here"))
    done = CliRunner().invoke(app, ["render", str(folder), "--resolution", "32x18", "--workers", "2"])
    assert done.exit_code == 0, done.output
    assert "2 of 2 done" in done.output
    assert len(list((folder / "render/frames").glob("*.png"))) == 4
    assert (folder / "render/draft.mp4").is_file()


def test_what_is_in_glass_is_seen(make_run: MakeRun) -> None:
    glass = {"half": 0.6, "pos": (0, 0, 0.6), "finish": "glass", "color": (0.9, 0.95, 1.0)}
    bare, covered = (
        film(make_run({"crate": CRATE, **more}, name)) for name, more in (("bare", {}), ("covered", {"glass": glass}))
    )
    pictures = [filming.develop(filming.trace(filming.reels()[0].frames[0])).astype(int) for filming in (bare, covered)]
    middle = [picture[8:10, 15:17].mean(axis=(0, 1)) for picture in pictures]
    assert middle[1][0] > 1.5 * middle[1][2], "red as before"
    assert np.abs(pictures[0] - pictures[1]).max() > 5, "and yet there is glass"


def test_transparent_colours_filter_what_is_behind_them(make_run: MakeRun) -> None:
    """Both sides of a pane of opacity o and linear colour c let 1 - o (1 - c) of the light pass."""
    pane = {"half": (0.6, 0.02, 0.6), "pos": (0, -0.8, 0.4), "opacity": 0.4, "color": (0.0, 1.0, 0.0)}
    camera = {"main": {"kind": "still", "up": (0, 0, 1), "fov": 30.0, "pos": (0, -3.0, 0.5), "look_at": (0, 0, 0.4)}}
    runs = {"bare": {"crate": CRATE | {"color": (0.9, 0.9, 0.9)}}}
    runs["covered"] = runs["bare"] | {"pane": pane}
    filmings = [film(make_run(boxes, name, cameras=camera)) for name, boxes in runs.items()]
    plain, through = (one.trace(one.reels()[0].frames[0]).radiance[8:10, 15:17].mean(axis=(0, 1)) for one in filmings)
    assert (through / plain)[0] == pytest.approx(0.6**2, abs=0.12), "and the reflections of the pane"
    assert (through / plain)[1] > 0.95


def test_legibility_tells_what_is_seen(make_run: MakeRun) -> None:
    boxes = {
        "crate": CRATE,
        "hidden": {"half": 0.1, "pos": (0, 1.0, 0.1)},
        "gone": {"half": 0.1, "pos": (0, -40.0, 0.1)},
        "runner": {"half": 0.1, "pos": (-1.5, 0, 0.1), "velocity": (1.0, 0, 0), "color": (0.1, 0.1, 0.9)},
    }
    boxes = {name: {"velocity": (0, 0, 0)} | what for name, what in boxes.items()}
    filming = film(make_run(boxes), (64, 36))
    filming.render(reel := filming.reels()[0], lambda progress: None)
    rows = write_legibility(filming, [reel])["draft"][0]["bodies"]
    assert 0.05 < rows["crate"]["share"] < 0.5
    assert rows["hidden"]["share"] == 0
    assert rows["hidden"]["hidden"] == 1
    assert "gone" not in rows
    assert rows["runner"]["motion"] > 0.01 > rows["crate"]["motion"]
    assert rows["crate"]["contrast"] > 0.1
    assert rows["crate"]["edge"] > rows["runner"]["edge"] - 0.5


def test_the_command(make_run: MakeRun, tmp_path: Path) -> None:
    folder, runner = make_run({"crate": SLIDING}), CliRunner()
    done = runner.invoke(
        app, ["render", str(folder), "--resolution", "32x18", "--frames", "1:3", "--frames-only", "png"]
    )
    assert done.exit_code == 0, done.output
    assert sorted(path.name for path in (folder / "render" / "draft").iterdir()) == ["00001.png", "00002.png"]
    done = runner.invoke(app, ["render", str(folder), "--resolution", "32x18"])
    assert done.exit_code == 0
    whole = (folder / "render" / "draft.mp4").read_bytes()
    done = runner.invoke(app, ["render", str(folder), "--resolution", "32x18", "--frames", "1:3"])
    assert done.exit_code == 0
    assert (folder / "render" / "draft_1-2.mp4").is_file()
    assert (folder / "render" / "draft.mp4").read_bytes() == whole, "a part does not take the place of the whole"
    with Image.open(folder / "render" / "draft" / "00001.png") as picture:
        assert picture.size == (32, 18)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--camera", "mian"], "there is no camera `mian`; there are main; did you mean `main`?"),
        (["--frames", "9:12"], "pictures 0 to 3"),
        (["--shard", "3/2"], "1/4"),
        (["--shard", "²/³"], "1/4"),
        (["--resolution", "²x³"], "write 1280x720"),
        (["--join"], "are not rendered yet"),
    ],
)
def test_what_is_wrong_is_said(make_run: MakeRun, options: list[str], words: str) -> None:
    done = CliRunner().invoke(app, ["render", str(make_run({"crate": CRATE})), *options])
    assert done.exit_code != 0
    assert words in str(done.exception or "") + done.output


def test_a_folder_without_a_recording(tmp_path: Path) -> None:
    with pytest.raises(RunError, match="nothing was recorded"):
        read_recording(tmp_path)


def test_what_moves_is_blurred_while_the_shutter_is_open(make_run: MakeRun) -> None:
    fast = {"crate": CRATE | {"half": 0.2, "pos": (-0.5, 0, 0.4), "velocity": (5.0, 0, 0)}}
    sharp, blurred = (
        film(make_run(fast, name, motion_blur=blur), (64, 36)) for name, blur in (("sharp", 0.0), ("blurred", 0.9))
    )
    pictures = [filming.trace(filming.reels()[0].frames[1]).alpha for filming in (sharp, blurred)]
    widths = [np.count_nonzero(picture.max(axis=0) > 0.05) for picture in pictures]
    assert widths[1] > 1.5 * widths[0]
    assert pictures[1].sum() == pytest.approx(pictures[0].sum(), rel=0.15)


def test_edges_before_the_background_are_no_darker_than_what_they_suffix(make_run: MakeRun) -> None:
    pale = CRATE | {"color": (0.9, 0.9, 0.9)}
    filming = Filming(read_recording(make_run({"crate": pale}, background=(0.9, 0.9, 0.9))), "draft")
    traced = filming.trace(filming.reels()[0].frames[0])
    shown, edge = filming.develop(traced).astype(int), (traced.alpha > 0) & (traced.alpha < 1)
    assert edge.sum() > 20
    assert shown[traced.alpha > 0].min() > np.median(shown[traced.alpha == 1]) - 20


LAMP = {"kind": "lamp", "strength": 1.0, "color": (1, 1, 1), "pos": (0.9, 0.0, 0.4), "radius": 0.25}


@pytest.mark.parametrize(("blur", "opacity"), [(0.0, 0.3), (0.5, 0.3), (0.0, 1.0), (0.5, 1.0)])
def test_before_nothing_lamps_are_not_seen_and_what_is_clear_is_seen_through(
    make_run: MakeRun, blur: float, opacity: float
) -> None:
    faint = CRATE | {"pos": (-0.6, 0, 0.4), "opacity": opacity, "velocity": (0.01, 0, 0)}
    lights = {**FILM["lights"], "bulb": LAMP}
    filming = film(make_run({"crate": faint}, lights=lights, motion_blur=blur), (64, 36))
    traced = filming.trace(filming.reels()[0].frames[1])
    shown = filming.develop(traced).astype(int)
    background = shown[0, 0]
    assert np.abs(background - 255 * 0.8).max() <= 1
    assert (shown[:, 36:] == background).all(), "where the lamp hangs"
    assert (0.2 < np.median(traced.alpha[traced.alpha > 0.02]) < 0.8) == (opacity < 1)


def test_what_is_behind_dark_glass_is_there_in_a_blurred_draft_too(make_run: MakeRun) -> None:
    bottle = CRATE | {"finish": "tinted_glass", "velocity": (0.01, 0, 0)}
    wall = {"half": 1.5, "pos": (0, 2.5, 0.4)}
    filming = film(make_run({"bottle": bottle, "wall": wall}, motion_blur=0.5), (64, 36))
    alpha = filming.trace(filming.reels()[0].frames[1]).alpha
    assert alpha[14:22, 28:36].min() > 0.9


def test_the_better_the_picture_the_finer_its_edges(make_run: MakeRun) -> None:
    run = make_run({"crate": CRATE | {"velocity": (1, 0, 0)}})
    steps = []
    for quality in ("draft", "final"):
        filming = Filming(read_recording(run), quality, size=(64, 36))
        alpha = filming.trace(filming.reels()[0].frames[0]).alpha
        steps.append(len(np.unique(alpha.round(4))))
    assert steps[0] <= 9
    assert steps[1] > 18


def test_what_fills_a_part_of_a_pixel_is_as_bright_as_if_it_filled_it() -> None:
    alpha = np.zeros((3, 12))
    alpha[:, :3], alpha[:, 3] = 1.0, 0.25
    made = undimmed(np.array([0.2, 0.4, 0.8]) * alpha[..., None], alpha)
    np.testing.assert_allclose(made[:, : 4 + RIM], np.broadcast_to((0.2, 0.4, 0.8), (3, 4 + RIM, 3)), rtol=1e-6)
    assert not made[:, 4 + RIM :].any()
    broken = np.array([0.2, 0.4, 0.8]) * alpha[..., None]
    broken[1, 3], broken[0, 1] = np.nan, np.inf
    np.testing.assert_allclose(undimmed(broken, alpha)[:, :4], made[:, :4], rtol=1e-6)


MOVES = """
import numpy as np
from text2sim.rendering.renderer import mitsuba
from text2sim.rendering.scene import sensor
from text2sim.templates.cameras import View

mi = mitsuba()  # chooses LLVM, before drjit takes another one
import drjit

print(mi.variant())
if mi.variant().startswith("scalar"):
    raise SystemExit
scene = mi.load_dict({"type": "scene", "ball": {"type": "sphere"}})
guide = mi.load_dict({"type": "depth"})
drjit.set_flag(drjit.JitFlag.KernelHistory, True)
at, up = np.zeros(3), np.array([0.0, 0.0, 1.0])
for k in (0, 1, 2):
    drjit.kernel_history_clear()
    view = View(np.array([0.1 * k, -3.0 - 0.02 * k, 1.0]), at, up, 40.0 + k, 3.0 + 0.02 * k, 0.01 + 0.001 * k)
    np.array(mi.render(scene, sensor=sensor(view, (32, 18)), integrator=guide, spp=1))
    kernels = [row for row in drjit.kernel_history() if row["type"] == drjit.KernelType.JIT]
    print(sum(not row["cache_hit"] for row in kernels), len(kernels))
"""


def test_a_camera_that_moves_needs_no_new_kernels(tmp_path: Path) -> None:
    """Compiling takes ten times as long as tracing; whatever is a plain number of a sensor is part of the code."""
    home = {**os.environ, "HOME": str(tmp_path)}  # where kernels of earlier runs are kept
    done = subprocess.run([sys.executable, "-c", MOVES], capture_output=True, text=True, check=True, env=home)
    variant, *rows = done.stdout.split("\n")[:-1]
    if variant.startswith("scalar"):
        pytest.skip("no LLVM here: nothing is compiled")
    counts = [[int(word) for word in row.split()] for row in rows]
    assert len(counts) == 3
    assert counts[0][0] > 0
    assert all(compiled == 0 < kernels for compiled, kernels in counts[1:]), counts


def test_a_film_of_some_seconds_with_fewer_pictures_stands_beside_the_whole_one(make_run: MakeRun) -> None:
    run = make_run({"ball": {"half": 0.1, "pos": (0, 0, 0.4), "velocity": (1, 0, 0)}})
    whole, fewer = Filming(read_recording(run)), Filming(read_recording(run), fps=5.0)
    assert [round(frame.t, 9) for frame in whole.reels(during=(0.1, 0.25))[0].frames] == [0.1, 0.2]
    assert [round(frame.t, 9) for frame in fewer.reels()[0].frames] == [0.0, 0.2]
    with pytest.raises(RunError, match="shows 0 s to 0.3 s, and no picture from 2 s to 3 s"):
        whole.reels(during=(2.0, 3.0))
    (reel,) = fewer.reels(during=(0.2, 0.4))
    assert _suffix(fewer, reel, whole=False) == "_5fps_1-1"
    assert _suffix(whole, whole.reels()[0], whole=True) == ""


def test_the_pace_is_told_by_the_preview_alone(make_run: MakeRun) -> None:
    quiet = {"title": None, "time": False, "values": [], "inset": False, "pace": True}
    for name, time in (("quiet", False), ("asked", True)):
        filming = film(make_run({"crate": CRATE}, name, overlay=quiet | {"time": time}, speed=0.5), (96, 54))
        (reel,) = filming.reels()
        paths = filming.render(reel, lambda progress: None)
        with Image.open(paths[0]) as picture:
            bare = np.asarray(picture.convert("RGB"))
        assert np.array_equal(next(iter(filming.pictures(reel, paths))), bare) is not time
