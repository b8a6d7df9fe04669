"""Letters of a text as flat forms, from the outlines of a font."""

import math
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from text2sim.compiler.shapes.meshfile import case_path, errors_about
from text2sim.spec_schema.errors import AssetError

if TYPE_CHECKING:
    from shapely import MultiPolygon, Polygon

SUFFIXES = (".ttf", ".otf")
MAX_BYTES = 8 * 1024 * 1024
"""Size of a font. One with all of Chinese is larger; a subset of it will do."""
MAX_POINTS = 4_000
"""Most points in the outline of a letter."""
PATH_UNITS = 64
"""FreeType takes the font's units for 64ths of pixels, and returns outlines in pixels."""
CURVE_STEPS = 6
"""Straight pieces that a curve becomes."""
LINE_SPACING = 1.5
"""Distance between lines, in heights of a capital letter."""
MODEL_LETTERS = "HEIZ"
"""Flat capitals, which measure a font; one without them is measured by the letters of the text."""


@dataclass(frozen=True, eq=False)
class Letter:
    """A letter where it stands in its text."""

    form: "Polygon | MultiPolygon"
    """In x and z, in heights of a capital letter; the first line stands on z = 0."""
    row: int
    column: int


def letters(text: str, font: str | None, folder: Path) -> "list[Letter]":
    """Return the letters of a text, blanks left out; lines begin at x = 0, each below the one before.

    Args:
        text: The text.
        font: Font file; the built-in font if None.
        folder: Folder of the case, for the font file.

    Raises:
        AssetError: if the font cannot be used or lacks a letter, or the text is blank.
    """
    if not text.strip():
        raise AssetError("the text has nothing but blanks: there is no letter to make a body of")
    if font is None:
        with errors_about("the built-in font"):
            return list(_set(text, None, 0, 0))
    path, _ = case_path(font, folder, "font", SUFFIXES, MAX_BYTES)
    stat = path.stat()
    with errors_about(f"font file `{font}`"):
        return list(_set(text, path, stat.st_mtime_ns, stat.st_size))


@lru_cache(maxsize=64)
def _set(text: str, path: Path | None, _mtime: int, _size: int) -> "tuple[Letter, ...]":
    from shapely.affinity import affine_transform

    face = _Face(path)
    high = face.capital(text)
    found, forms = [], {}
    for row, line in enumerate(text.split("\n")):
        pen, column, before = 0.0, 0, None
        for char in line.rstrip("\r"):
            if char == "\t":
                pen += 4 * face.advance(" ")
                continue
            if char not in forms:
                forms[char] = None if char.isspace() else face.form(char)
            if before is not None:
                pen += face.kerning(before, char)
            form = forms[char]
            if form is not None and not form.is_empty:
                scale = 1 / high
                moved = affine_transform(form, [scale, 0, 0, scale, pen * scale, -LINE_SPACING * row])
                found.append(Letter(moved, row, column))
                column += 1
            pen += face.advance(char)
            before = char
    if not found:
        raise AssetError("has no outline for anything in this text")
    return tuple(found)


class _Face:
    """A font, read by FreeType, in its own units."""

    def __init__(self, path: Path | None) -> None:
        try:
            from matplotlib import ft2font, get_data_path
        except ImportError as error:
            raise AssetError(f"cannot be read: {error}") from None
        self.flags = ft2font.LoadFlags.NO_SCALE | ft2font.LoadFlags.NO_HINTING | ft2font.LoadFlags.NO_BITMAP
        self.unfitted = ft2font.Kerning.UNSCALED
        file = path or Path(get_data_path()) / "fonts" / "ttf" / "DejaVuSans-Bold.ttf"
        try:
            self.font = ft2font.FT2Font(str(file))
            scalable = self.font.scalable and self.font.units_per_EM > 0
        except Exception as error:  # readers of foreign files fail in every way there is
            raise AssetError(f"cannot be read ({type(error).__name__}: {str(error)[:120]})") from error
        if not scalable:
            raise AssetError("has pictures of letters, not outlines: take a scalable font")
        self._known: dict[str, Any] = {}

    def advance(self, char: str) -> float:
        """Return the distance from this letter to the next."""
        return float(self._load(char)[2])

    def kerning(self, before: str, char: str) -> float:
        """Return how much nearer or farther two letters stand."""
        return float(self.font.get_kerning(self._index(before), self._index(char), self.unfitted))

    def capital(self, text: str) -> float:
        """Return the height of a capital letter."""
        for char in MODEL_LETTERS:
            if self.font.get_char_index(ord(char)):
                form = self.form(char)
                if not form.is_empty:
                    return form.bounds[3] - form.bounds[1]
        heights = [form.bounds[3] for char in text if not char.isspace() and not (form := self.form(char)).is_empty]
        if not heights or max(heights) <= 0:
            raise AssetError("has no outline for anything in this text")
        return max(heights)

    def _index(self, char: str) -> Any:
        return self.font.get_char_index(ord(char))

    def _load(self, char: str) -> Any:
        if char not in self._known:
            if not self._index(char) and not char.isspace():
                raise AssetError(f"has no letter `{char}` (U+{ord(char):04X}); take another font, or leave it out")
            try:
                glyph = self.font.load_char(ord(char), flags=self.flags)
                points, codes = self.font.get_path()
                self._known[char] = points * PATH_UNITS, codes, glyph.horiAdvance
            except Exception as error:
                raise AssetError(f"has a letter `{char}` that cannot be read ({str(error)[:80]})") from error
        return self._known[char]

    def form(self, char: str) -> "Polygon | MultiPolygon":
        """Return the area that a letter covers."""
        points, codes, _ = self._load(char)
        if len(points) > MAX_POINTS:
            raise AssetError(f"has a letter `{char}` of {len(points)} points; at most {MAX_POINTS} are possible")
        return filled(_contours(points.tolist(), codes.tolist()))


def _contours(points: list[list[float]], codes: list[int]) -> list[list[tuple[float, float]]]:
    """Return outlines as polygons. Codes are those of matplotlib: 1 starts one, 2 is a line, 3 and 4 are curves."""
    found: list[list[tuple[float, float]]] = []
    k = 0
    while k < len(points):
        code = codes[k]
        if code == 1:
            found.append([_pair(points[k])])
            k += 1
        elif code in (2, 3, 4) and found:
            count = code - 1
            ends = [_pair(point) for point in points[k : k + count]]
            found[-1] += ends if code == 2 else _curve([found[-1][-1], *ends])
            k += count
        else:
            k += 1  # 79 closes an outline; polygons are always closed
    return found


def _pair(point: list[float]) -> tuple[float, float]:
    return (float(point[0]), float(point[1]))


def _curve(control: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return points on a Bézier curve, without its start."""
    n = len(control) - 1
    found = []
    for step in range(1, CURVE_STEPS + 1):
        t = step / CURVE_STEPS
        weights = [math.comb(n, k) * t**k * (1 - t) ** (n - k) for k in range(n + 1)]
        found.append((
            sum(w * x for w, (x, _) in zip(weights, control, strict=False)),
            sum(w * y for w, (_, y) in zip(weights, control, strict=False)),
        ))  # fmt: skip
    return found


def filled(contours: list[list[tuple[float, float]]]) -> "Polygon | MultiPolygon":
    """Return what outlines cover: those that run the same way round as the largest one fill, the others cut holes."""
    from shapely import Polygon, make_valid, unary_union

    rings = [(signed_area(ring), ring) for ring in contours if len(ring) > 2]
    if not rings:
        return Polygon()
    turning = max(rings, key=lambda row: abs(row[0]))[0]
    fills = [make_valid(Polygon(ring)) for area, ring in rings if area * turning > 0]
    holes = [make_valid(Polygon(ring)) for area, ring in rings if area * turning < 0]
    return areas(unary_union(fills).difference(unary_union(holes)))


def areas(form: Any) -> "Polygon | MultiPolygon":
    """Return the polygons of a form; its lines and points are left out."""
    from shapely import MultiPolygon, Polygon

    parts = [part for part in getattr(form, "geoms", [form]) if isinstance(part, Polygon) and part.area > 0]
    return parts[0] if len(parts) == 1 else MultiPolygon(parts)


def signed_area(ring: list[tuple[float, float]]) -> float:
    """Return the area of a polygon; negative if it runs clockwise."""
    return sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(ring, [*ring[1:], ring[0]], strict=True)) / 2
