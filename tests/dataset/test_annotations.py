"""Annotations against geometry: known points of boxes, projected by an independent pinhole."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from crates import HALF, Take, places

from text2sim.dataset.item import Item

WIDE, TALL = 64, 36
FOCAL = 18 / np.tan(np.radians(20))
BODIES = list(HALF)


def camera(k: int, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Where the camera is in a picture, and its axes right, down, ahead: a dolly that looks at a point."""
    pos = np.array((0.0, -4.0, 2.0)) + np.array((0.4, 0.2, 0.0)) * k / (count - 1)
    ahead = np.array((0, 0, 0.4)) - pos
    ahead /= np.linalg.norm(ahead)
    right = np.cross(ahead, (0, 0, 1))
    right /= np.linalg.norm(right)
    return pos, np.stack([right, np.cross(ahead, right), ahead])


def projected(points: Any, k: int, count: int) -> np.ndarray:
    """Column, row and depth."""
    pos, axes = camera(k, count)
    local = (np.asarray(points) - pos) @ axes.T
    return np.column_stack([
        WIDE / 2 + FOCAL * local[:, 0] / local[:, 2], TALL / 2 + FOCAL * local[:, 1] / local[:, 2], local[:, 2]
    ])  # fmt: skip


def unprojected(row: Any, column: Any, depth: np.ndarray, k: int, count: int) -> np.ndarray:
    """Points of the world that are seen at the middles of pixels."""
    local = np.column_stack([(column + 0.5 - WIDE / 2) / FOCAL, (row + 0.5 - TALL / 2) / FOCAL, np.ones(len(row))])
    pos, axes = camera(k, count)
    return pos + (local * depth[row, column].astype(float)[:, None]) @ axes


def crate_at(t: float) -> tuple[np.ndarray, np.ndarray]:
    """Middle and orientation of the crate, whose states are linear and turn at 2 rad/s."""
    _, pos, _ = places(1.0)
    c, s = np.cos(2 * t), np.sin(2 * t)
    return pos[0, 1] + (pos[-1, 1] - pos[0, 1]) * t / 0.8, np.array([(c, -s, 0), (s, c, 0), (0, 0, 1)])


def top_points() -> np.ndarray:
    """Points on the upper face of the crate, in its frame, away from its edges."""
    x, y = np.meshgrid(np.linspace(-0.16, 0.16, 5), np.linspace(-0.08, 0.08, 4))
    return np.column_stack([x.ravel(), y.ravel(), np.full(x.size, HALF["crate"][2])])


@pytest.fixture
def item(take: Take) -> Item:
    return take("a")


@pytest.fixture
def arrays(item: Item) -> dict[str, np.ndarray]:
    with np.load(item.folder / "annotations.npz") as found:
        return dict(found)


def test_depth_normals_and_masks_are_those_of_known_points(item: Item, arrays: dict[str, np.ndarray]) -> None:
    count = len(item.frames)
    assert count == 8 and arrays["depth"].shape == (8, TALL, WIDE)
    for k, frame in enumerate(item.frames):
        middle, turn = crate_at(frame["time"])
        found = projected(middle + top_points() @ turn.T, k, count)
        column, row = np.floor(found[:, :2]).astype(int).T
        assert (arrays["instances"][k, row, column] == 1 + BODIES.index("crate")).all()
        assert (arrays["parts"][k, row, column] == 1 + BODIES.index("crate")).all()
        # Points are somewhere in their pixels; what is seen at the middles of these lies in the upper face.
        assert unprojected(row, column, arrays["depth"][k], k, count)[:, 2] == pytest.approx(0.5, abs=1e-4)
        assert arrays["normals"][k, row, column] == pytest.approx(np.tile((0, 0, 1), (len(row), 1)), abs=2e-3)


def test_depth_is_exact_at_the_middle_of_pixels(item: Item, arrays: dict[str, np.ndarray]) -> None:
    """Every pixel of the floor, put back into the world, lies in the plane of its upper side."""
    for k in (0, 5):
        row, column = np.nonzero(arrays["instances"][k] == 1 + BODIES.index("floor"))
        assert len(row) > 200
        world = unprojected(row, column, arrays["depth"][k], k, len(item.frames))
        assert world[:, 2] == pytest.approx(0.0, abs=1e-4)
    assert np.isinf(arrays["depth"][arrays["instances"] == 0]).all()


def test_flow_leads_to_where_points_are_next(item: Item, arrays: dict[str, np.ndarray]) -> None:
    """From each pixel of the crate: back to a point of it, with the crate to the next picture, and through the camera."""
    count = len(item.frames)
    for k in (0, 3, 6):
        here, turn = crate_at(item.frames[k]["time"])
        there, turned = crate_at(item.frames[k + 1]["time"])
        row, column = np.nonzero(arrays["instances"][k] == 1 + BODIES.index("crate"))
        own = (unprojected(row, column, arrays["depth"][k], k, count) - here) @ turn
        wanted = projected(there + own @ turned.T, k + 1, count)[:, :2]
        found = np.column_stack([column + 0.5, row + 0.5]) + arrays["flow"][k, row, column]
        assert len(row) > 30
        assert found == pytest.approx(wanted, abs=2e-3)
        assert np.linalg.norm(arrays["flow"][k, row, column], axis=1).min() > 0.3, "the crate moves"
    assert np.isnan(arrays["flow"][arrays["instances"] == 0]).all()
    assert np.isnan(arrays["flow"][-1]).all(), "there is no next picture"


def test_points_that_will_be_hidden_are_not_seen_next(item: Item, arrays: dict[str, np.ndarray]) -> None:
    known = np.isfinite(arrays["flow"][..., 0])
    assert not arrays["seen_next"][~known].any()
    hidden = known[:-1] & ~arrays["seen_next"][:-1]
    assert 0 < hidden.sum() < 0.2 * known.sum(), "the crate covers floor that was seen before"


def test_the_floor_is_seen_next_at_grazing_angles_too(item: Item, arrays: dict[str, np.ndarray]) -> None:
    """A point of the floor is hidden only where the crate is, at its pixel or beside it, or outside of the picture."""
    for k in range(len(item.frames) - 1):
        row, column = np.nonzero((arrays["instances"][k] == 1) & ~arrays["seen_next"][k])
        at = np.array([column + 0.5, row + 0.5]) + arrays["flow"][k, row, column].T
        inside = (at >= 0).all(axis=0) & (at[0] < WIDE) & (at[1] < TALL)
        x, y = at[:, inside].astype(int)
        wide = np.pad(arrays["instances"][k + 1], 1, constant_values=1)
        assert (np.max([wide[y + i, x + j] for i in range(3) for j in range(3)], axis=0) > 1).all()


def test_recorded_cameras_and_boxes_are_those_of_the_film(item: Item, arrays: dict[str, np.ndarray]) -> None:
    count = len(item.frames)
    for k, frame in enumerate(item.frames):
        pos, axes = camera(k, count)
        turn, shift = np.reshape(frame["rotation"], (3, 3)), np.array(frame["translation"])
        assert frame["intrinsics"] == pytest.approx([FOCAL, FOCAL, 32, 18])
        assert turn == pytest.approx(axes, abs=1e-6)
        assert -turn.T @ shift == pytest.approx(pos, abs=1e-6)
        crate = next(thing for thing in frame["objects"] if thing["name"] == "crate")
        middle, spin = crate_at(frame["time"])
        assert crate["center"] == pytest.approx(middle, abs=1e-5)
        assert crate["size"] == pytest.approx(2 * np.array(HALF["crate"]), abs=1e-5)
        signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        corners = projected(middle + signs * HALF["crate"] @ spin.T, k, count)[:, :2]
        assert crate["whole_box"] == pytest.approx([*corners.min(axis=0), *corners.max(axis=0)], abs=1e-3)
        rows, columns = np.nonzero(arrays["instances"][k] == crate["instance"])
        assert crate["box"] == [columns.min(), rows.min(), columns.max() + 1, rows.max() + 1]
        keys = np.reshape(crate["keypoints"], (8, 3))
        assert np.reshape(crate["keypoint_pixels"], (8, 2)) == pytest.approx(projected(keys, k, count)[:, :2], abs=1e-6)
        assert (keys - middle) @ spin == pytest.approx(signs * HALF["crate"], abs=1e-5), (
            "they stay where they are on it"
        )
        assert 0 < sum(crate["keypoint_seen"]) < 8, "some are on the far side"
        ball = next(thing for thing in frame["objects"] if thing["name"] == "ball")
        assert 0 <= ball["hidden"] <= 1


def test_contacts_stand_where_and_when_they_were(item: Item, arrays: dict[str, np.ndarray]) -> None:
    count, k = len(item.frames), 3
    assert [len(frame["contacts"]) for frame in item.frames] == [0, 0, 0, 2, 0, 0, 0, 0]
    first = item.frames[k]["contacts"][0]
    where = projected([(0, -0.2, 0.1)], k, count)[0, :2]
    assert first["between"] == ["floor", "crate"]
    assert first["pixel"] == pytest.approx(where, abs=1e-3)
    column, row = where.astype(int)
    assert arrays["contacts"][k, row, column] == 5
    assert arrays["contacts"].sum() == 6


def test_pictures_agree_with_the_annotations(item: Item, arrays: dict[str, np.ndarray]) -> None:
    import av

    with av.open(str(item.folder / "film.mp4")) as film:
        pictures = [picture.to_ndarray(format="rgb24") for picture in film.decode(video=0)]
    assert len(pictures) == len(item.frames)
    crate = arrays["instances"][4] == 1 + BODIES.index("crate")
    inner = crate & np.roll(crate, 1, 0) & np.roll(crate, -1, 0) & np.roll(crate, 1, 1) & np.roll(crate, -1, 1)
    red, green, blue = pictures[4][inner].mean(axis=0)
    assert red > 1.5 * green > blue


def test_a_broken_item_is_refused_with_reasons(take: Take, recipe: Any, tmp_path: Path) -> None:
    from text2sim.dataset.curation import refusals

    why = ["penetration: 100 mm, more than 20 mm"]
    deep = take("deep", evidence={"penetration": {"value": 0.1}}, refused=why)
    (deep.folder / "film.mp4").write_bytes(b"no film")
    with np.load(deep.folder / "annotations.npz") as found:
        shifted = dict(found) | {"instances": np.roll(found["instances"], 9, axis=2)}
    np.savez(deep.folder / "annotations.npz", **shifted)
    reasons = refusals(deep, recipe.limits)
    assert {why.split(":")[0] for why in reasons} == {"penetration", "film", "annotation"}


def test_traced_pictures_show_things_where_the_annotations_have_them(
    take: Take, recipe: Any, tracer: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By colour: the crate alone is red. Its edges are a pixel or so wide."""
    from crates import CASE

    from text2sim.dataset.item import make_item
    from text2sim.rendering import renderer
    from text2sim.spec_schema.load import load_text

    monkeypatch.setattr(renderer, "find_variant", lambda: renderer.Variant("scalar"))
    run = take("a").folder.parents[1] / "a" / "case_one"
    script = run / "program" / "render.py"
    dome = {"dome": {"kind": "environment", "strength": 1.0, "color": (1, 1, 1), "horizon": (1, 1, 1)}}
    script.write_text(script.read_text().replace("LIGHTS = {}", f"LIGHTS = {dome!r}"))
    traced = recipe.model_copy(
        update={"film": recipe.film.model_copy(update={"quality": "draft", "frames": 2, "size": (160, 90)})}
    )
    item = make_item("t", run, None, load_text(CASE.format(name="c"), tmp_path / "c.yaml"), traced, tmp_path / "t")
    with np.load(item.folder / "annotations.npz") as found:
        masks = found["instances"] == 1 + BODIES.index("crate")
    import av

    with av.open(str(item.folder / "film.mp4")) as film:
        for mask, picture in zip(masks, film.decode(video=0), strict=True):
            image = picture.to_ndarray(format="rgb24").astype(int)
            red = image[..., 0] > 1.5 * image[..., 2]
            assert (red & mask).sum() / (red | mask).sum() > 0.85


def test_an_energy_gain_is_relative_to_kinetic_energy(take: Take, recipe: Any) -> None:
    account = {"not_counted": [], "start": 2.9, "end": 2.9, "min": 2.9, "max": 2.9, "work_of_motors": 0.0}
    assert take("still", evidence={"energy": account | {"change": 0.0}}).row["energy_gain"] == 0
    why = ["energy: 20 % without a source, more than 5 %"]
    # The crate of 1 kg is said to go at 1 m/s.
    moving = take("moving", evidence={"energy": account | {"change": 0.1}, "goes": 1.0}, refused=why)
    assert moving.row["energy_gain"] == pytest.approx(0.2)
    assert (
        take("open", evidence={"energy": account | {"change": 9.0, "not_counted": ["work"]}}).row["energy_gain"] is None
    )
