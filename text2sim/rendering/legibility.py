"""How well each body is seen, measured on sampled pictures by cheap identifier passes: no light, no noise.

    RUN/render/legibility.json     film -> sampled pictures -> bodies

Of each body: its share of the picture; how much of it others hide; how far it is from the edge of the picture; how much
it stands out from what is around it; how fast it crosses the picture.
"""

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from text2sim.rendering.film import Filming, Reel
from text2sim.rendering.frames import save
from text2sim.rendering.recording import Recording
from text2sim.rendering.renderer import mitsuba
from text2sim.rendering.scene import Stage, decoded, sensor
from text2sim.templates.cadence import Frame
from text2sim.templates.cameras import Cameras

Array = NDArray[np.floating]
Indices = NDArray[np.integer]

SAMPLES = 8
"""Pictures of a film that are looked at."""
WIDTH = 320
"""Of the pictures that are measured [pixels]; shares do not depend on it."""
RING = 4
"""Pixels around a body that it is compared with."""


class Identifier:
    """Tells which body is seen in each pixel.

    Args:
        stage: What is filmed.
        size: Width and height [pixels].
    """

    def __init__(self, stage: Stage, size: tuple[int, int]):
        self._stage, self._size = stage, size

    def bodies(self, t: float, view: Any) -> tuple[Indices, Array]:
        """Return the index of the body seen in each pixel, -1 where none is, and its distance [m], both (h, w)."""
        mi = mitsuba()
        integrator = mi.load_dict({"type": "aov", "aovs": "body:albedo,depth:depth"})
        camera = sensor(view, self._size, sharp=True)
        # One sample for each pixel: what stands for a body is not to be averaged.
        made = mi.render(self._stage.identified(t), sensor=camera, integrator=integrator, spp=1, seed=0)
        found = np.array(made, np.float32)[..., -4:]
        return np.where(found[..., 3] > 0, decoded(found[..., :3]), -1), found[..., 3]


def measure(filming: Filming, reel: Reel) -> list[dict[str, Any]]:
    """Return what is seen in sampled pictures of a film."""
    recording = filming.recording
    width, height = filming.size
    size = (min(WIDTH, width), max(2, round(height * min(1.0, WIDTH / width))))
    stage = filming.stage
    identifier, cameras = Identifier(stage, size), Cameras(recording.film, recording.states)
    chosen = np.unique(np.linspace(0, len(reel.frames) - 1, SAMPLES).round().astype(int))
    rows = []
    for k in chosen.tolist():
        frame = reel.frames[k]
        seen, _ = identifier.bodies(frame.t, cameras.view(frame.camera, frame.t, frame.part))
        picture = _picture(filming, frame, size)
        moving = reel.frames[k + 1] if k + 1 < len(reel.frames) else None
        rows.append(
            {"frame": frame.k, "camera": frame.camera, "t": round(frame.t, 6)}
            | {"bodies": _rows(recording, cameras, seen, picture, frame, moving)}
        )
    return rows


def write_legibility(filming: Filming, reels: list[Reel]) -> dict[str, Any]:
    """Measure films and write what was found beside them; return it."""
    found = {reel.name: measure(filming, reel) for reel in reels}
    text = json.dumps(found, indent=1, allow_nan=False) + "\n"
    save(filming.folder / "legibility.json", lambda part: part.write_text(text, "utf-8"))
    return found


def _rows(
    recording: Recording, cameras: Cameras, seen: Indices, picture: Array | None, frame: Frame, after: Frame | None
) -> dict[str, dict[str, float | None]]:
    """Return the measures of every body that has a place in the picture, seen or not."""
    height, width = seen.shape
    rows: dict[str, dict[str, float | None]] = {}
    for k, body in enumerate(recording.bodies):
        mask = seen == k
        share = float(mask.mean())
        box = _outline(recording, cameras, body, frame, width / height)
        if not share and (box is None or body in recording.statics):
            continue
        row: dict[str, float | None] = {"share": share, "hidden": None, "edge": None, "contrast": None, "motion": None}
        if box is not None:
            row["hidden"] = float(np.clip(1 - share / max(box[2], 1e-9), 0, 1)) if box[2] > share else 0.0
            later = None if after is None else _outline(recording, cameras, body, after, width / height)
            if later is not None and after is not None and after.camera == frame.camera:
                row["motion"] = float(np.hypot(*(later[1] - box[1])) / 2)
        if share:
            rows_of, columns = np.nonzero(mask)
            gaps = (rows_of.min(), height - 1 - rows_of.max(), columns.min(), width - 1 - columns.max())
            row["edge"] = float(min(gaps)) / height
            if picture is not None:
                row["contrast"] = _contrast(picture, mask)
        rows[body] = {name: None if value is None else round(value, 5) for name, value in row.items()}
    return rows


def _outline(
    recording: Recording, cameras: Cameras, body: str, frame: Frame, aspect: float
) -> tuple[Array, Array, float] | None:
    """Return the outermost points of a body in the picture, their middle, and the share that their hull fills.

    None if it is behind the camera or outside of the picture.
    """
    from scipy.spatial import ConvexHull, QhullError

    from text2sim.templates.cameras import project

    points = recording.states.bounds([body], frame.t)
    if not len(points):
        return None
    flat = project(cameras.view(frame.camera, frame.t, frame.part), points, aspect)
    flat = flat[flat[:, 2] > 0][:, :2]
    inside = np.clip(flat, -1, 1)
    if len(flat) < 3 or not (np.abs(flat) < 1).any():
        return None
    try:
        area = float(ConvexHull(inside).volume) / 4
    except QhullError:
        area = 0.0
    return flat, flat.mean(axis=0), area


def _picture(filming: Filming, frame: Frame, size: tuple[int, int]) -> Array | None:
    """Return the finished picture in the size of the pass, linear; None if it is not rendered."""
    from PIL import Image

    path = filming.finished(frame)
    if not path.is_file():
        return None
    with Image.open(path) as picture:
        return np.asarray(picture.convert("RGB").resize(size, Image.Resampling.BOX), float) / 255


def _contrast(picture: Array, mask: NDArray[np.bool_]) -> float | None:
    """Return the distance in colour between a body and a ring around it, 0 to 1; None if nothing is around it."""
    from scipy.ndimage import binary_dilation

    ring = np.asarray(binary_dilation(mask, iterations=RING), bool) & ~mask
    if not ring.any():
        return None
    return float(np.linalg.norm(picture[mask].mean(axis=0) - picture[ring].mean(axis=0)) / np.sqrt(3))
