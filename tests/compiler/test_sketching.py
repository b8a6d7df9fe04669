"""Sketches: pieces in reading order with the width of their strokes; what is no drawing is said."""

import struct
import zlib

import numpy as np
import pytest
from glyph_shapes import draw, holes, sketch, stroke_width
from PIL import Image

from text2sim.compiler.shapes import sketching
from text2sim.compiler.shapes.glyphs import glyph_parts, whole
from text2sim.spec_schema.errors import AssetError


class TestSketches:
    def test_pieces_are_read_by_rows_from_left_to_right(self, tmp_path):
        # Two rows, drawn out of order, neither level.
        draw(
            tmp_path / "sketch.png",
            [(300, 210), (300, 270)],
            [(40, 30), (40, 110)],
            (120, 235, 30),
            [(200, 50), (260, 50), (260, 120)],
            [(40, 200), (60, 275)],
            (120, 60, 30),
        )
        parts = glyph_parts(sketch(), tmp_path)
        assert [(one.row, one.column) for one in parts] == [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2)]
        assert [holes(one.form) for one in parts] == [0, 1, 0, 0, 1, 0]
        assert parts[0].offset[1] > 0 > parts[5].offset[1], "z is up"
        assert parts[0].offset[0] < parts[1].offset[0] < parts[2].offset[0]

    def test_a_dot_belongs_to_the_row_that_it_is_near(self, tmp_path):
        tall = [[(x, 40), (x, 120)] for x in (60, 160, 260)] + [[(x, 190), (x, 270)] for x in (60, 160)]
        draw(tmp_path / "sketch.png", *tall, [(330, 118), (331, 118)])
        assert [(one.row, one.column) for one in glyph_parts(sketch(), tmp_path)][3] == (0, 3)

    def test_the_size_is_that_of_what_is_drawn_not_of_the_paper(self, tmp_path):
        draw(tmp_path / "sketch.png", [(150, 100), (150, 200)], pen=20)
        (glyph,) = glyph_parts(sketch(height=0.6), tmp_path)
        low_x, low_z, high_x, high_z = glyph.form.bounds
        assert high_z - low_z == pytest.approx(0.6)
        # A line of 100 pixels with round ends of 10.
        assert (high_x - low_x) / (high_z - low_z) == pytest.approx(21 / 121, rel=0.05)

    @pytest.mark.parametrize("pen", [8, 30])
    def test_strokes_keep_their_width(self, tmp_path, pen):
        draw(tmp_path / "sketch.png", [(60, 50), (60, 250)], (220, 150, 90), pen=pen)
        pixel = 1.0 / (2 * 90 + pen + 1)
        for glyph in glyph_parts(sketch(), tmp_path):
            assert stroke_width(glyph.form) == pytest.approx(pen * pixel, rel=0.12)
        ink = (255 - np.asarray(Image.open(tmp_path / "sketch.png"), float) - 5).sum() / 230
        high = max(one.form.bounds[3] + one.offset[1] for one in glyph_parts(sketch(), tmp_path))
        assert high == pytest.approx(0.5)
        area = sum(one.form.area for one in glyph_parts(sketch(), tmp_path))
        rows = np.flatnonzero((np.asarray(Image.open(tmp_path / "sketch.png")) < 135).any(axis=1))
        assert area == pytest.approx(ink / (rows[-1] - rows[0] + 1) ** 2, rel=0.02)

    def test_filled_forms_touching_the_border_and_grey_ink(self, tmp_path):
        picture = np.full((200, 300), 235, np.uint8)
        picture[0:80, 0:120] = 130
        picture[120:180, 200:280] = 130
        Image.fromarray(picture).save(tmp_path / "sketch.jpg", quality=60)
        parts = glyph_parts(sketch("sketch.jpg"), tmp_path)
        assert len(parts) == 2
        assert parts[0].form.area / parts[1].form.area == pytest.approx(2, rel=0.03)

    def test_clear_paper_is_white_and_specks_are_dirt(self, tmp_path):
        picture = np.zeros((200, 200, 4), np.uint8)
        picture[50:150, 80:120] = (10, 10, 10, 255)
        picture[5:7, 5:7] = (0, 0, 0, 255)
        Image.fromarray(picture).save(tmp_path / "sketch.png")
        assert len(glyph_parts(sketch(), tmp_path)) == 1

    def test_what_was_traced_is_kept(self, tmp_path, monkeypatch):
        monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
        draw(tmp_path / "sketch.png", [(60, 50), (60, 250)], (220, 150, 90))
        before = glyph_parts(sketch(), tmp_path)
        (tmp_path / "more").mkdir()
        (tmp_path / "sketch.png").rename(tmp_path / "more" / "sketch.png")
        monkeypatch.setattr(sketching, "trace", None)
        again = glyph_parts(sketch(), tmp_path / "more")
        assert [(g.form.wkb, g.row, g.column) for g in again] == [(g.form.wkb, g.row, g.column) for g in before]

    def test_a_part_is_a_piece(self, tmp_path):
        draw(tmp_path / "sketch.png", [(60, 50), (60, 250)], (220, 150, 90))
        assert holes(whole(sketch(part=1), tmp_path)) == 1
        with pytest.raises(AssetError, match="the sketch has 2 pieces, 0 to 1; there is no part 7"):
            whole(sketch(part=7), tmp_path)

    @pytest.mark.parametrize(
        ("content", "said"),
        [
            (None, "picture file `sketch.png` does not exist"),
            (b"", "cannot be read"),
            (b"\x89PNG\r\n\x1a\n" + b"\0" * 40, "cannot be read"),
            (b"<svg xmlns='http://www.w3.org/2000/svg'/>", "cannot be read"),
            ("white", "nothing in it: it is equally dark everywhere"),
            ("black", "nothing in it: it is equally dark everywhere"),
            ("dark", "is dark on 9. % of it: draw dark on light"),
            ("bomb", "has too many pixels"),
            ("cut", "cannot be read"),
        ],
    )
    def test_what_is_no_drawing_is_said(self, tmp_path, content, said):
        path = tmp_path / "sketch.png"
        if content in ("white", "black", "dark"):
            picture = np.full((100, 100), 250 if content == "white" else 5, np.uint8)
            if content == "dark":
                picture[10:20, 10:30] = 250
            Image.fromarray(picture).save(path)
        elif content == "bomb":
            # A head that promises a thousand million pixels; nothing is unpacked to see it.
            head = struct.pack(">IIBBBBB", 40_000, 40_000, 8, 0, 0, 0, 0)
            body = zlib.compress(bytes(4096))
            chunks = [(b"IHDR", head), (b"IDAT", body), (b"IEND", b"")]
            path.write_bytes(
                b"\x89PNG\r\n\x1a\n"
                + b"".join(struct.pack(">I", len(d)) + k + d + struct.pack(">I", zlib.crc32(k + d)) for k, d in chunks)
            )
        elif content == "cut":
            draw(path, [(60, 50), (60, 250)])
            path.write_bytes(path.read_bytes()[:300])
        elif content is not None:
            path.write_bytes(content)
        with pytest.raises(AssetError, match=said):
            whole(sketch(), tmp_path)

    def test_nothing_outside_the_folder_and_no_other_kinds(self, tmp_path):
        folder = tmp_path / "case"
        folder.mkdir()
        draw(tmp_path / "sketch.png", [(60, 50), (60, 250)])
        with pytest.raises(AssetError, match="outside"):
            whole(sketch("../sketch.png"), folder)
        (folder / "a.bmp").write_bytes(b"BM")
        with pytest.raises(AssetError, match="must end in one of .png, .jpg, .jpeg"):
            whole(sketch("a.bmp"), folder)

    def test_a_changed_picture_is_read_again(self, tmp_path):
        draw(tmp_path / "sketch.png", [(60, 50), (60, 250)])
        assert len(glyph_parts(sketch(), tmp_path)) == 1
        draw(tmp_path / "sketch.png", [(60, 50), (60, 250)], (220, 150, 90))
        assert len(glyph_parts(sketch(), tmp_path)) == 2
