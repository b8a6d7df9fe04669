"""Patterns that are painted on the sheets of an unfolded body: cartons, crates, books, pips and labels."""

from typing import Any

import numpy as np

if __package__:
    from .patterns import INK, Decoration, contrast, fitted, size_for, tile  # noqa: TID252
    from .unfolding import Sheet  # noqa: TID252
else:
    from patterns import INK, Decoration, contrast, fitted, size_for, tile
    from unfolding import Sheet

LARGEST = 2048
"""Longest side of a picture [pixels]."""
FINEST = 640
"""Pixels along the longest side of a sheet, if `LARGEST` allows it."""
GAP = 0.02
"""Gap between sheets, as a fraction of the widest."""
TAPE = (0.55, 0.36, 0.17)
PRINT = (0.16, 0.12, 0.08)
TIMBER = (0.86, 0.72, 0.50)
BARK_SHARE = 0.93
"""Radius of the wood of a sawn end, in radii of the trunk."""
PAGES = (0.93, 0.90, 0.82)
LABELLED = 0.4
"""Sheets with at least this share of the largest sheet's area get the label."""
PIPS = {
    1: ((0, 0),),
    2: ((-1, 1), (1, -1)),
    3: ((-1, 1), (0, 0), (1, -1)),
    4: ((-1, 1), (1, 1), (-1, -1), (1, -1)),
    5: ((-1, 1), (1, 1), (0, 0), (-1, -1), (1, -1)),
    6: ((-1, 1), (1, 1), (-1, 0), (1, 0), (-1, -1), (1, -1)),
}
DIE = {"+x": 1, "-x": 6, "+y": 2, "-y": 5, "+z": 3, "-z": 4}


def places(sheets: list[Sheet]) -> tuple[np.ndarray, tuple[float, float]]:
    """Return the left edge [m] of each sheet in the picture, and the picture's width and height [m]."""
    widths = np.array([sheet.width for sheet in sheets])
    gap = GAP * widths.max()
    left = np.concatenate([[0.0], np.cumsum(widths + gap)[:-1]])
    return left, (float(left[-1] + widths[-1]), max(sheet.height for sheet in sheets))


def painted(decoration: Decoration, sheets: list[Sheet], own: tuple[float, ...]) -> np.ndarray:
    """Return one picture of all sheets: red, green, blue and alpha, 0 to 1, shape (h, w, 4), top row first.

    Args:
        decoration: Pattern and label of the surface.
        sheets: Sheets of the body.
        own: Colour of the body, sRGB.
    """
    from PIL import Image

    left, (width, height) = places(sheets)
    longest = max(max(sheet.width, sheet.height) for sheet in sheets)
    scale = min(FINEST / longest, LARGEST / max(width, height))
    whole = Image.new("RGBA", (max(round(width * scale), 1), max(round(height * scale), 1)), (*_ink(own), 0))
    is_round = sheets[0].name == "side"
    for sheet, x in zip(sheets, left, strict=True):
        size = max(round(sheet.width * scale), 1), max(round(sheet.height * scale), 1)
        picture = Image.new("RGBA", size, (*_ink(own), 0))
        if decoration.kind == "rings":
            _rings(_Pen(picture, scale), sheet, decoration, own)
        elif decoration.kind in _PAINTERS and not is_round:
            _PAINTERS[decoration.kind](_Pen(picture, scale), sheet, sheets, decoration, own)
        elif decoration.kind and decoration.kind not in _PAINTERS:
            picture = _tiled(decoration, sheet, sheets, own, size)
        if decoration.text and decoration.kind != "book":
            _write(picture, sheet, sheets, decoration, own)
        whole.paste(picture, (round(x * scale), whole.height - size[1]))
    return np.asarray(whole, float) / 255


def _ink(color: Any, alpha: float | None = None) -> tuple[int, ...]:
    values = (*color[:3],) if alpha is None else (*color[:3], alpha)
    return tuple(round(255 * float(x)) for x in values)


class _Pen:
    """Draws over a picture, in metres from its lower left corner."""

    def __init__(self, picture: Any, scale: float):
        self.picture, self.scale = picture, scale

    def box(self, x0: float, y0: float, x1: float, y1: float, color: Any, alpha: float = 1.0) -> None:
        self.polygon([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], color, alpha)

    def polygon(self, corners: Any, color: Any, alpha: float = 1.0) -> None:
        high = self.picture.height
        self._draw("polygon", [(x * self.scale, high - y * self.scale) for x, y in corners], color, alpha)

    def disc(self, x: float, y: float, radius: float, color: Any, alpha: float = 1.0) -> None:
        s, high = self.scale, self.picture.height
        ends = (x - radius) * s, high - (y + radius) * s, (x + radius) * s, high - (y - radius) * s
        self._draw("ellipse", ends, color, alpha)

    def _draw(self, what: str, where: Any, color: Any, alpha: float) -> None:
        from PIL import Image, ImageDraw

        layer = Image.new("RGBA", self.picture.size, (*_ink(color), 0))
        getattr(ImageDraw.Draw(layer), what)(where, fill=_ink(color, alpha))
        self.picture.alpha_composite(layer)


def _tiled(decoration: Decoration, sheet: Sheet, sheets: list[Sheet], own: Any, size: tuple[int, int]) -> Any:
    """Return a sheet covered with a repeating pattern."""
    from PIL import Image

    is_round = sheets[0].name == "side"
    if is_round:
        box = np.full(3, sheets[0].width / np.pi)
    else:
        sides = np.array([(one.width, one.height) for one in sheets])
        box = np.unique(np.round(sides[sides > 0], 6))
        box = box if len(box) >= 3 else np.resize(box, 3)
    length = decoration.size or size_for(decoration.kind, box, is_round=is_round)
    made = tile(decoration.kind, decoration.color, own, joints=not is_round)
    fu, fv = fitted(decoration.kind, length, sheet.width, sheet.height)
    rows, columns = made.picture.shape[:2]
    u = (np.arange(size[0]) + 0.5) / size[0] * sheet.width * fu / length / made.period[0] % 1
    v = (np.arange(size[1])[::-1] + 0.5) / size[1] * sheet.height * fv / length / made.period[1] % 1
    if decoration.turned:
        u, v = v, u
    chosen = made.picture[(v * rows).astype(int)[:, None], (u * columns).astype(int)[None]]
    if decoration.turned:
        chosen = chosen.swapaxes(0, 1)
    return Image.fromarray((chosen * 255 + 0.5).astype(np.uint8), "RGBA")


def _carton(pen: _Pen, sheet: Sheet, sheets: list[Sheet], decoration: Decoration, own: Any) -> None:
    w, h, low = sheet.width, sheet.height, min(sheet.width, sheet.height)
    edge = 0.012 * max(w, h)
    for x0, y0, x1, y1 in ((0, 0, w, edge), (0, h - edge, w, h), (0, 0, edge, h), (w - edge, 0, w, h)):
        pen.box(x0, y0, x1, y1, PRINT, 0.22)
    top = next(one for one in sheets if one.name == "+z")
    along_x, color = top.width >= top.height, decoration.color or TAPE
    tape = 0.17 * min(top.width, top.height)
    if sheet.name in ("+z", "-z"):
        seam = 0.006 * low
        if along_x:
            pen.box(0, h / 2 - seam, w, h / 2 + seam, PRINT, 0.8)
            pen.box(0, (h - tape) / 2, w, (h + tape) / 2, color, 0.78)
        else:
            pen.box(w / 2 - seam, 0, w / 2 + seam, h, PRINT, 0.8)
            pen.box((w - tape) / 2, 0, (w + tape) / 2, h, color, 0.78)
        return
    if (sheet.name[1] == "x") == along_x:  # the sides over which the ends of the tape hang
        end = min(0.24 * h, 1.2 * tape)
        for y in (0.0, h - end):
            pen.box((w - tape) / 2, y, (w + tape) / 2, y + end, color, 0.78)
    _arrows(pen, 0.12 * w, 0.14 * h, 0.24 * low)
    if sheet.name in ("-y", "+x"):
        _address(pen, 0.56 * w, 0.52 * h, min(0.34 * w, 0.5 * h), 0.3 * h)


def _arrows(pen: _Pen, x: float, y: float, tall: float) -> None:
    """Print the arrows that mean "this way up"."""
    for step in (0.0, 0.55 * tall):
        a = x + step
        pen.polygon([(a, y + 0.55 * tall), (a + 0.2 * tall, y + tall), (a + 0.4 * tall, y + 0.55 * tall)], PRINT, 0.85)
        pen.box(a + 0.13 * tall, y + 0.16 * tall, a + 0.27 * tall, y + 0.56 * tall, PRINT, 0.85)
    pen.box(x, y, x + 0.95 * tall, y + 0.07 * tall, PRINT, 0.85)


def _address(pen: _Pen, x: float, y: float, wide: float, tall: float) -> None:
    """Draw an address label with lines and a bar code."""
    pen.box(x, y, x + wide, y + tall, (0.95, 0.94, 0.91))
    for row, part in enumerate((0.8, 0.55, 0.68)):
        top = y + tall * (0.88 - 0.14 * row)
        pen.box(x + 0.08 * wide, top - 0.06 * tall, x + part * wide, top, INK, 0.8)
    for bar in range(13):
        a = x + wide * (0.1 + 0.062 * bar)
        pen.box(a, y + 0.08 * tall, a + wide * (0.02 + 0.018 * (bar * 7 % 3)), y + 0.4 * tall, INK, 0.9)


def _crate(pen: _Pen, sheet: Sheet, sheets: list[Sheet], decoration: Decoration, own: Any) -> None:
    w, h, low = sheet.width, sheet.height, min(sheet.width, sheet.height)
    frame = min(0.15 * low, decoration.size or low)
    many = max(3, round((w - 2 * frame) / (1.25 * frame)))
    chance = np.random.default_rng(sum(sheet.name.encode()))
    board = (w - 2 * frame) / many
    for k in range(many):
        x = frame + k * board
        pen.box(x, frame, x + board, h - frame, (0, 0, 0), 0.2 + 0.16 * chance.random())
        for _ in range(5):
            a = x + board * chance.random()
            pen.box(a, frame, a + 0.03 * board, h - frame, (0, 0, 0), 0.1)
        pen.box(x, frame, x + 0.07 * board, h - frame, INK, 0.8)
    for k in range(4):  # shadow of the frame
        d = 0.16 * frame * (4 - k) / 4
        pen.box(frame, h - frame - d, w - frame, h - frame, (0, 0, 0), 0.22)
        pen.box(frame, frame, frame + d, h - frame, (0, 0, 0), 0.22)
    tones = chance.uniform(0.0, 0.14, 4)
    sides = ((0, h - frame, w, h), (0, 0, w, frame), (0, frame, frame, h - frame), (w - frame, frame, w, h - frame))
    line = 0.05 * frame
    for (x0, y0, x1, y1), tone in zip(sides, tones, strict=True):
        pen.box(x0, y0, x1, y1, decoration.color or (0, 0, 0), 1.0 if decoration.color else float(tone))
        wide = x1 - x0 > y1 - y0
        for k in range(1, 5):
            a = k / 5 + 0.06 * chance.uniform(-1, 1)
            if wide:
                pen.box(x0, y0 + a * (y1 - y0), x1, y0 + a * (y1 - y0) + 0.025 * frame, (0, 0, 0), 0.16)
            else:
                pen.box(x0 + a * (x1 - x0), y0, x0 + a * (x1 - x0) + 0.025 * frame, y1, (0, 0, 0), 0.16)
    for y in (frame, h - frame):
        pen.box(0, y - line / 2, w, y + line / 2, INK, 0.75)
    for x in (frame, w - frame):
        pen.box(x - line / 2, frame, x + line / 2, h - frame, INK, 0.75)
    for x in (0.3 * frame, 0.7 * frame, w - 0.7 * frame, w - 0.3 * frame):
        for y in (0.5 * frame, h - 0.5 * frame):
            pen.disc(x, y, 0.07 * frame, INK, 0.8)


def _book(pen: _Pen, sheet: Sheet, sheets: list[Sheet], decoration: Decoration, own: Any) -> None:
    w, h = sheet.width, sheet.height
    sizes = {"x": sheets[2].width, "y": sheets[0].width, "z": sheets[0].height}
    thin, middle, _ = sorted("xyz", key=lambda axis: sizes[axis])
    ink = decoration.ink or (0.85, 0.72, 0.4)
    if sheet.name[1] == thin or sheet.name == f"-{middle}":  # covers, and the spine
        b = 0.07 * min(w, h)
        for d in (b, 1.5 * b):
            for x0, y0, x1, y1 in (
                (d, d, w - d, d + 0.12 * b), (d, h - d - 0.12 * b, w - d, h - d),
                (d, d, d + 0.12 * b, h - d), (w - d - 0.12 * b, d, w - d, h - d),
            ):  # fmt: skip
                pen.box(x0, y0, x1, y1, ink, 0.9)
        if decoration.text:
            _fit(pen.picture, decoration.text, ink, (0.72, 0.3), at=(0.5, 0.36), upended=h > 2.5 * w, plate=None)
        return
    cover = min(0.14 * sizes[thin], 0.004)
    is_wide = _right(sheet) == thin
    pen.box(*((cover, 0, w - cover, h) if is_wide else (0, cover, w, h - cover)), PAGES)
    many = 16
    for k in range(1, many):
        a = k / many
        if is_wide:
            pen.box(cover + a * (w - 2 * cover), 0, cover + (a + 0.2 / many) * (w - 2 * cover), h, PRINT, 0.25)
        else:
            pen.box(0, cover + a * (h - 2 * cover), w, cover + (a + 0.2 / many) * (h - 2 * cover), PRINT, 0.25)


def _right(sheet: Sheet) -> str:
    return {"x": "y", "y": "x", "z": "x"}[sheet.name[1]]


def _pips(pen: _Pen, sheet: Sheet, sheets: list[Sheet], decoration: Decoration, own: Any) -> None:
    w, h = sheet.width, sheet.height
    color, largest = decoration.color or contrast(own), max(one.width * one.height for one in sheets)
    if w * h < 0.6 * largest:
        return
    if 0.8 < w / h < 1.25:
        halves = [(w / 2, h / 2, 0.5 * min(w, h), DIE[sheet.name])]
    else:  # a domino
        x, y = (w / 4, 0.0) if w > h else (0.0, h / 4)
        cell, line = 0.5 * min(max(w, h) / 2, min(w, h)), 0.02 * max(w, h)
        halves = [(w / 2 - x, h / 2 - y, cell, 2), (w / 2 + x, h / 2 + y, cell, 5)]
        across = (w / 2 - line / 2, 0.1 * h, w / 2 + line / 2, 0.9 * h)
        pen.box(*(across if w > h else (0.1 * w, h / 2 - line / 2, 0.9 * w, h / 2 + line / 2)), color)
    for x, y, cell, number in halves:
        for a, b in PIPS[number]:
            pen.disc(x + 0.52 * a * cell, y + 0.52 * b * cell, 0.2 * cell, color)


def _rings(pen: _Pen, sheet: Sheet, decoration: Decoration, own: Any) -> None:
    """Draw the sawn end of a trunk within a rim of bark: rings about a pith beside the middle, and cracks."""
    if sheet.name not in ("top", "bottom"):
        return
    r, pale = sheet.width / 2, np.array(decoration.color or TIMBER)
    chance = np.random.default_rng(7 if sheet.name == "top" else 8)
    x, y = r * (1 + chance.uniform(-0.12, 0.12, 2))
    pen.disc(r, r, BARK_SHARE * r, pale)
    edges = np.sort(chance.uniform(0.06, 1.0, round(9 + 4 * chance.random())))[::-1]
    for k, edge in enumerate(edges):
        away = 1 - edge  # inner rings are about the pith
        middle = (r + away * (x - r), r + away * (y - r))
        pen.disc(*middle, edge * BARK_SHARE * r, 0.62 * pale, 0.55)
        pen.disc(*middle, edge * BARK_SHARE * r - 0.022 * r, pale * (1 - 0.10 * (k % 2) - 0.12 * away))
    pen.disc(x, y, 0.035 * r, 0.4 * pale)
    for _ in range(5):
        turn, long = chance.uniform(0, 2 * np.pi), r * chance.uniform(0.25, 0.7)
        across = 0.012 * r * np.array((-np.sin(turn), np.cos(turn)))
        tip = np.array((x, y)) + long * np.array((np.cos(turn), np.sin(turn)))
        pen.polygon([(x + across[0], y + across[1]), tuple(tip), (x - across[0], y - across[1])], 0.4 * pale, 0.7)


def _write(picture: Any, sheet: Sheet, sheets: list[Sheet], decoration: Decoration, own: Any) -> None:
    """Write the label on a sheet, if the sheet gets one."""
    room, places_across = (0.7, 0.5), (0.5,)
    if sheets[0].name == "side":
        flat = len(sheets) > 1 and sheets[0].height < 0.6 * sheets[1].width
        if (sheet.name == "side") == flat:
            return
        room = (0.62, 0.5)
        if sheet.name == "side":
            room, places_across = (0.2, min(0.5 * sheet.height, 0.14 * sheet.width) / sheet.height), (0.25, 0.75)
    elif sheet.name == "-z" or sheet.width * sheet.height < LABELLED * max(one.width * one.height for one in sheets):
        return
    for x in places_across:
        _fit(picture, decoration.text, _letters(decoration, own), room, at=(x, 0.5), plate=decoration.plate)


def _letters(decoration: Decoration, own: Any) -> Any:
    return decoration.ink or contrast(decoration.plate or own)


def _fit(picture: Any, text: str, ink: Any, room: Any, *, at: Any, plate: Any, upended: bool = False) -> None:
    """Write a line of text as large as the space allows.

    Args:
        picture: The picture.
        text: The text.
        ink: Colour of the text, sRGB.
        room: Width and height of the space for the text, as fractions of the picture's.
        at: Centre of the text, as fractions of the picture's size from its upper left corner.
        plate: Colour of a plate behind the text; None for no plate.
        upended: Whether the text runs upwards.
    """
    from PIL import Image, ImageDraw, ImageFont

    wide, tall = room[0] * picture.width, room[1] * picture.height
    if upended:
        wide, tall = 0.8 * picture.height, 0.6 * picture.width
    font = ImageFont.load_default(size=100)
    left, top, right, bottom = font.getbbox(text, stroke_width=3)
    size = max(100 * min(wide / max(right - left, 1), tall / max(bottom - top, 1)), 4)
    font, stroke = ImageFont.load_default(size=size), round(size / 30)
    left, top, right, bottom = font.getbbox(text, stroke_width=stroke)
    pad = round(0.45 * (bottom - top)) if plate else 2
    made = Image.new("RGBA", (round(right - left) + 2 * pad, round(bottom - top) + 2 * pad), (*_ink(ink), 0))
    if plate:
        across = max(made.size) if len(text) < 3 else 0
        made = Image.new("RGBA", (max(made.width, across), max(made.height, across)), (*_ink(plate), 0))
        draw = ImageDraw.Draw(made)
        shape = draw.ellipse if len(text) < 3 else draw.rectangle
        shape((0, 0, made.width - 1, made.height - 1), fill=(*_ink(plate), 255))
    middle = (made.width - (left + right)) / 2, (made.height - (top + bottom)) / 2
    ImageDraw.Draw(made).text(middle, text, font=font, fill=(*_ink(ink), 255), stroke_width=stroke)
    if upended:
        made = made.transpose(Image.Transpose.ROTATE_90)
    where = round(at[0] * picture.width - made.width / 2), round(at[1] * picture.height - made.height / 2)
    layer = Image.new("RGBA", picture.size, (*_ink(ink), 0))
    layer.paste(made, where)
    picture.alpha_composite(layer)


_PAINTERS = {"carton": _carton, "crate": _crate, "book": _book, "pips": _pips}
