"""Drawings in a picture as flat forms: strokes and filled areas that are darker than the paper."""

from dataclasses import dataclass
from functools import lru_cache
from hashlib import file_digest
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from text2sim.assets.answer_cache import cached_answer
from text2sim.assets.confined import call_confined
from text2sim.compiler.shapes.lettering import areas
from text2sim.compiler.shapes.meshfile import errors_about
from text2sim.compiler.shapes.pictures import MAX_USEFUL_SIDE, open_picture, picture_path, pixels_of
from text2sim.spec_schema.errors import AssetError

if TYPE_CHECKING:
    from shapely import Polygon

MAX_ENLARGEMENT = 4.0
"""Greatest factor by which a picture is enlarged before forms are traced."""
BLUR_WIDTH = 0.8
"""Width [pixels of the picture] over which grain and steps are smoothed."""
OUTLINE_TOLERANCE = 0.3
"""How far [pixels of the picture] an outline may be from the traced one."""
MIN_CONTRAST = 24
"""Least difference of grey, of 255 levels, between ink and paper."""
MOST_INK = 0.9
"""Part of the picture that may be ink."""
MAX_SPECK = 1e-3
"""Pieces smaller than this part of the largest one are specks of dirt."""
MAX_PIECES = 500
MAX_POINTS = 400_000
"""Most points of all traced outlines."""
MAX_LOCAL_PIXELS = 1_000_000
"""Pictures with more pixels than this are traced in a process of their own."""
TRACED_PIECES_FACTOR = 4
"""How many times as many pieces may be traced, since most of them may be dirt."""


@dataclass(frozen=True, eq=False)
class Stroke:
    """A connected piece of a drawing, where it is."""

    form: "Polygon"
    """In x and z: the drawing is 1 high, and its lower left corner is the origin."""
    row: int
    column: int


def strokes(file: str, folder: Path) -> list[Stroke]:
    """Return the pieces of a drawing by rows, from left to right.

    Raises:
        AssetError: if the picture cannot be used, or nothing is drawn in it.
    """
    path = picture_path(file, folder)
    stat = path.stat()
    with errors_about(f"picture file `{file}`"):
        return list(_read(path, stat.st_mtime_ns, stat.st_size))


@lru_cache(maxsize=32)
def _read(path: Path, _mtime: int, _size: int) -> tuple[Stroke, ...]:
    """Return the strokes of a picture, from the cache if it was traced before."""
    from shapely import from_wkb

    with path.open("rb") as stream:
        digest = file_digest(stream, "sha256").digest()

    def ask() -> list[tuple[bytes, int, int]]:
        found = call_confined(trace, path, large=pixels_of(path) > MAX_LOCAL_PIXELS)
        return [(stroke.form.wkb, stroke.row, stroke.column) for stroke in found]

    return tuple(Stroke(from_wkb(form), *place) for form, *place in cached_answer((b"strokes", digest), ask))


def trace(path: Path) -> tuple[Stroke, ...]:
    """Return the pieces of a drawing without limits of time and memory; see `strokes`.

    Raises:
        AssetError: if the picture cannot be used, or nothing is drawn in it.
    """
    from shapely.affinity import affine_transform

    pieces = _pieces(_gray(path))
    low_x, low_z = min(p.bounds[0] for p in pieces), min(p.bounds[1] for p in pieces)
    scale = 1 / (max(p.bounds[3] for p in pieces) - low_z)
    forms = [affine_transform(p, [scale, 0, 0, scale, -low_x * scale, -low_z * scale]) for p in pieces]
    return tuple(_in_rows(forms))


def _gray(path: Path) -> np.ndarray:
    """Return a picture as grey levels (h, w) from 0 to 255, on white paper."""
    from PIL import Image

    image = open_picture(path)
    if image.mode in ("I", "F") or image.mode.startswith("I;"):
        levels = np.asarray(image, np.float32)
        return levels * (255.0 / (65535.0 if levels.max(initial=0) > 255 else 255.0))
    image = image.convert("RGBA")
    paper = Image.new("RGBA", image.size, (255, 255, 255, 255))
    return np.asarray(Image.alpha_composite(paper, image).convert("L"), np.float32)


def _pieces(gray: np.ndarray) -> "list[Polygon]":
    """Trace what is dark. x is to the right, z up, in pixels of the picture."""
    import cv2
    from contourpy import FillType, contour_generator
    from shapely import Polygon, make_valid

    tall, wide = gray.shape
    factor = min(MAX_USEFUL_SIDE / max(tall, wide), MAX_ENLARGEMENT)
    gray = cv2.GaussianBlur(gray, (0, 0), BLUR_WIDTH * max(1.0, 1 / factor))
    size = (max(round(wide * factor), 2), max(round(tall * factor), 2))
    big = cv2.resize(gray, size, interpolation=cv2.INTER_CUBIC if factor > 1 else cv2.INTER_AREA)
    big = np.clip(big, 0, 255)
    if float(big.max() - big.min()) < MIN_CONTRAST:
        raise AssetError("has nothing in it: it is equally dark everywhere; draw dark on light")
    level, _ = cv2.threshold(big.astype(np.uint8), 0, 255, cv2.THRESH_BINARY + cv2.THRESH_OTSU)
    ink = float((big <= level).mean())
    if ink > MOST_INK:
        raise AssetError(f"is dark on {100 * ink:.0f} % of it: draw dark on light, with paper around it")
    # White all around closes what touches the border of the picture.
    big = np.pad(big, 1, constant_values=255.0)
    filled: Any = contour_generator(z=255.0 - big, fill_type=FillType.OuterOffset).filled(254.5 - level, 1e6)
    if len(filled[0]) > TRACED_PIECES_FACTOR * MAX_PIECES:
        raise AssetError(f"has {len(filled[0])} pieces; at most {MAX_PIECES} are possible")
    rings, corners = sum(len(row) - 1 for row in filled[1]), sum(map(len, filled[0]))
    if rings > TRACED_PIECES_FACTOR * MAX_PIECES or corners > MAX_POINTS:
        raise AssetError(
            f"has outlines of {corners:,} points in {rings:,} rings; at most {MAX_POINTS:,} in "
            f"{TRACED_PIECES_FACTOR * MAX_PIECES:,} are possible: draw with fewer and thicker strokes"
        )
    found = []
    for points, offsets in zip(*filled, strict=True):
        flat = np.column_stack([points[:, 0] - 0.5, big.shape[0] - points[:, 1] - 1.5]) / factor
        rings = [flat[a : b - 1] for a, b in zip(offsets[:-1].tolist(), offsets[1:].tolist(), strict=True)]
        if len(rings[0]) < 3:
            continue
        form = Polygon(rings[0], [ring for ring in rings[1:] if len(ring) > 2])
        form = areas(make_valid(form.simplify(OUTLINE_TOLERANCE)))
        found.append(max(getattr(form, "geoms", [form]), key=lambda part: part.area))
    largest = max((form.area for form in found), default=0.0)
    kept = [_without_pinholes(form) for form in found if form.area >= max(MAX_SPECK * largest, 6.0)]
    if not kept:
        raise AssetError("has nothing in it larger than a speck: draw dark on light, with thick strokes")
    if len(kept) > MAX_PIECES:
        raise AssetError(f"has {len(kept)} pieces; at most {MAX_PIECES} are possible")
    return kept


def _without_pinholes(form: "Polygon") -> "Polygon":
    """Leave out holes as small as specks."""
    from shapely import Polygon

    return Polygon(
        form.exterior, [hole for hole in form.interiors if Polygon(hole).area >= max(MAX_SPECK * form.area, 6.0)]
    )


def _in_rows(forms: "list[Polygon]") -> list[Stroke]:
    """Put pieces into reading order.

    The tallest pieces make the rows. A piece belongs to a row if its middle is within the row's height, or the row's
    middle within the piece's. What lies between rows, such as a dot, goes to the nearest.
    """
    tall = sorted(forms, key=lambda form: (form.bounds[1] - form.bounds[3], form.bounds))
    typical = sorted(form.bounds[3] - form.bounds[1] for form in forms)[len(forms) // 2]
    rows: list[list[Polygon]] = []
    spans: list[list[float]] = []
    late: list[Polygon] = []
    for form in tall:
        low, high = form.bounds[1], form.bounds[3]
        middle = (low + high) / 2
        inside = [k for k, (a, b) in enumerate(spans) if a < middle < b or low < (a + b) / 2 < high]
        if inside:
            rows[min(inside, key=lambda k: abs(middle - sum(spans[k]) / 2))].append(form)
        elif high - low < 0.5 * typical:
            late.append(form)
        else:
            rows.append([form])
            spans.append([low, high])
    if not rows:
        rows, spans = [[late.pop(0)]], [[0.0, 1.0]]
    for form in late:
        middle = (form.bounds[1] + form.bounds[3]) / 2
        away = [max(a - middle, middle - b, 0.0) for a, b in spans]
        rows[away.index(min(away))].append(form)
    order = sorted(range(len(rows)), key=lambda k: -sum(spans[k]))
    return [
        Stroke(form, row, column)
        for row, k in enumerate(order)
        for column, form in enumerate(sorted(rows[k], key=lambda form: (form.bounds[0] + form.bounds[2], form.bounds)))
    ]
