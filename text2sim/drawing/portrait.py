"""Picture of a body for the gallery: from above at an angle, on an infinite light ground."""

from dataclasses import replace

import numpy as np

from text2sim.compiler.build import Resolution
from text2sim.compiler.shapes.pictures import picture_bytes
from text2sim.drawing.framing import box_of
from text2sim.drawing.lighting import ParallelLight, light_up, sky, soft_lamp
from text2sim.drawing.picture import Style, paint
from text2sim.drawing.prop import Prop, Stage
from text2sim.drawing.stage import stage
from text2sim.drawing.surfaces import decoded
from text2sim.drawing.view import PictureView, perspective

TRIANGLES = 100_000
BACKGROUND = (0.955, 0.958, 0.965)
VIEW_DIRECTION = (0.62, -1.0, 0.58)
"""Direction from the thing to the camera."""
FOV = 24.0
FILLED_SHARE = 0.8
"""Part of the picture's width or height that the thing fills."""
AMBIENT = 0.06


def portrait(resolution: Resolution, size: tuple[int, int] = (640, 480)) -> bytes:
    """Return a picture of everything in a case except its ground, as a PNG.

    Args:
        resolution: The resolved case, with few bodies, on a plane or in the air.
        size: Width and height [pixels].
    """
    from PIL import Image

    props = stage(resolution, TRIANGLES, fine=True)
    bounds = box_of([prop for prop in props if not prop.plane] or list(props))
    key, around = (24, 40) if len(props.triangles) < 2 * TRIANGLES else (12, 16)
    lamps = soft_lamp((-0.55, -0.75, 1.35), (0.62, 0.6, 0.56), key, 0.22)
    lamps += sky(around, (0.5, 0.51, 0.54), (0.5, 0.5, 0.52))
    scene = _on_ground(props, bounds, lamps)
    view = _framed(props, bounds, size)
    light = light_up(scene, lamps, AMBIENT, bounds, 640)
    picture = paint(scene, view, light, Style(BACKGROUND))
    pixels = (np.clip(picture.pixels, 0.0, 1.0) * 255 + 0.5).astype(np.uint8)
    return picture_bytes(Image.fromarray(pixels), "PNG", optimize=True)


def _on_ground(props: Stage, bounds: tuple[np.ndarray, np.ndarray], lamps: list[ParallelLight]) -> Stage:
    """The props on a ground that has the colour of the background outside of shadows."""
    low, high = bounds
    size = float((high - low).max())
    levels = [prop.triangles[0, 0, 2] for prop in props if prop.plane and np.ptp(prop.triangles[:, :, 2]) < 1e-9]
    heights = [float(level) for level in levels if low[2] - size < level < low[2] + 1e-6]
    # Without a ground near, the thing stays in the air.
    ground = max(heights) if heights else float(low[2]) - 0.1 * size
    light = AMBIENT + sum(lamp.direction[2] * np.array(lamp.color) for lamp in lamps)
    color = (decoded(BACKGROUND) / light) ** (1 / 2.2)
    square = np.array([(-1.0, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]) * 200 * size
    square += ((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, ground)
    triangles = square[np.array([(0, 1, 2), (0, 2, 3)])]
    flat = Prop("ground", "ground", triangles, tuple(color.tolist()), 1.0, False, "rough", True, True)
    kept = ~props.grounds
    return replace(
        props,
        props=[*props, flat],
        triangles=np.concatenate([props.triangles[kept], triangles]),
        normals=np.concatenate([props.normals[kept], np.full((2, 3, 3), (0.0, 0.0, 1.0), np.float32)]),
        colors=np.concatenate([props.colors[kept], np.full((2, 3), color, np.float32)]),
        owner=np.append(props.owner[kept], np.full(2, len(props), np.int32)),
        culled=np.append(props.culled[kept], [False, False]),
    )


def _framed(props: Stage, bounds: tuple[np.ndarray, np.ndarray], size: tuple[int, int]) -> PictureView:
    """A camera that shows everything as large as `FILLED_SHARE` allows."""
    points = props.triangles[~props.grounds].reshape(-1, 3)
    target = (bounds[0] + bounds[1]) / 2
    if not len(points):
        points = np.array(bounds)
    away = np.array(VIEW_DIRECTION) / np.linalg.norm(VIEW_DIRECTION)
    distance = 4.0 * float(np.linalg.norm(bounds[1] - bounds[0])) + 1e-6
    view = _view(target, away, distance, size)
    for _ in range(4):
        pixels = view.pixels(points)
        low, high = pixels.min(axis=0), pixels.max(axis=0)
        part = float(((high - low) / size).max())
        # Move the target such that the thing is in the centre of the picture.
        shift = ((low + high) / 2 - np.array(size) / 2) * distance / view.focal
        target = target + shift[0] * view.axes[0] - shift[1] * view.axes[1]
        distance *= max(part / FILLED_SHARE, 0.3)
        view = _view(target, away, distance, size)
    return view


def _view(target: np.ndarray, away: np.ndarray, distance: float, size: tuple[int, int]) -> PictureView:
    pos = target + distance * away
    return perspective(pos.tolist(), target.tolist(), (0.0, 0.0, 1.0), FOV, size, near=distance / 50)
