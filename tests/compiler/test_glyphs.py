"""Texts: letters in reading order, with their holes, as solids and as copies; what is wrong is said."""

import math
from pathlib import Path

import numpy as np
import pytest
from glyph_shapes import HERE, draw, holes, stroke_width, text
from soft_quality import signed_volume, surface_faults

from text2sim.compiler.build import resolve_case
from text2sim.compiler.shapes import geometry
from text2sim.compiler.shapes.extents import extents
from text2sim.compiler.shapes.extrude import convex_parts, polygons_of
from text2sim.compiler.shapes.glyphs import chosen, glyph_parts, whole
from text2sim.compiler.shapes.rotation import IDENTITY, quat_from_euler_deg
from text2sim.compiler.shapes.softmesh import soft_surface, write_obj
from text2sim.spec_schema.errors import AssetError, SpecError
from text2sim.spec_schema.load import load_text


class TestLetters:
    @pytest.mark.parametrize(("letter", "count"), [("A", 1), ("B", 2), ("8", 2), ("O", 1), ("L", 0), ("%", 2)])
    def test_holes_are_holes(self, letter, count):
        (glyph,) = glyph_parts(text(letter), HERE)
        assert holes(glyph.form) == count

    def test_a_letter_of_two_parts_is_one(self):
        (glyph,) = glyph_parts(text("i"), HERE)
        assert len(polygons_of(glyph.form)) == 2

    def test_height_is_that_of_a_capital(self):
        for letter in "HEI":
            (glyph,) = glyph_parts(text(letter), HERE)
            low, high = glyph.form.bounds[1], glyph.form.bounds[3]
            assert (low, high) == pytest.approx((-0.15, 0.15))

    def test_blanks_have_room_and_are_no_parts(self):
        near, far = (glyph_parts(text(words), HERE) for words in ("AB", "A B"))
        assert (len(near), len(far)) == (2, 2)
        assert far[1].offset[0] - far[0].offset[0] > near[1].offset[0] - near[0].offset[0] + 0.1

    def test_lines_begin_below_each_other(self):
        parts = glyph_parts(text("LA\nLo L"), HERE)
        assert [(one.row, one.column) for one in parts] == [(0, 0), (0, 1), (1, 0), (1, 1), (1, 2)]
        assert parts[0].offset[0] == pytest.approx(parts[2].offset[0]), "both lines begin with the same letter"
        assert parts[0].offset[1] - parts[2].offset[1] == pytest.approx(1.5 * 0.3)

    def test_the_whole_is_centred_and_a_part_on_its_own_middle(self):
        low, high = extents(text("Two\nrows"), IDENTITY, HERE)
        assert low == pytest.approx([-x for x in high])
        low, high = extents(text("Two\nrows", part=3), IDENTITY, HERE)
        assert low == pytest.approx([-x for x in high])
        assert high[0] < 0.1, "one letter"
        (glyph,) = chosen(text("Two\nrows", part=3), HERE)
        assert glyph.offset == (0.0, 0.0)

    def test_pairs_are_kerned(self):
        first, second = glyph_parts(text("AV"), HERE)
        lone, other = glyph_parts(text("AH"), HERE)
        gap = second.offset[0] - first.offset[0] - (second.form.bounds[2] + first.form.bounds[2])
        plain = other.offset[0] - lone.offset[0] - (other.form.bounds[2] + lone.form.bounds[2])
        assert gap < plain - 0.01

    def test_the_width_of_strokes(self):
        bar = glyph_parts(text("I"), HERE)[0].form
        assert stroke_width(bar) == pytest.approx(bar.bounds[2] - bar.bounds[0], rel=0.01)
        widths = [stroke_width(one.form) for one in glyph_parts(text("HELO"), HERE)]
        assert all(0.04 < width < 0.08 for width in widths)

    @pytest.mark.parametrize(
        ("shape", "said"),
        [
            (text("AB", part=2), "the text has 2 letters, 0 to 1; there is no part 2"),
            (text("A", part=1), "the text has one letter, 0; there is no part 1"),
            (text(" \n "), "nothing but blanks"),
            (text("A\u4e00"), r"the built-in font has no letter `.` \(U\+4E00\); take another font"),
            (text("A\x07"), r"U\+0007"),
            (text("A", font="missing.ttf"), "font file `missing.ttf` does not exist in the case's folder"),
            (text("A", font="../secret.ttf"), "outside"),
            (text("A", font="/etc/passwd"), "outside"),
            (text("A", font="notes.txt"), "must end in one of .ttf, .otf"),
            (text("A", font="broken.ttf"), "font file `broken.ttf` cannot be read"),
            (text("A", font="empty.otf"), "font file `empty.otf` cannot be read"),
            (text("A", font="huge.ttf"), "too large"),
        ],
    )
    def test_what_cannot_be_had_is_said(self, tmp_path, shape, said):
        folder = tmp_path / "case"
        folder.mkdir()
        (tmp_path / "secret.ttf").write_bytes(b"")
        (folder / "notes.txt").write_text("hello")
        (folder / "broken.ttf").write_bytes(b"\x00\x01\x00\x00" + bytes(range(256)) * 4)
        (folder / "empty.otf").write_bytes(b"")
        with (folder / "huge.ttf").open("wb") as file:
            file.truncate(9 * 1024 * 1024)
        with pytest.raises(AssetError, match=said):
            whole(shape, folder)

    def test_a_font_of_the_case_and_damaged_copies_of_it(self, tmp_path):
        from matplotlib import get_data_path

        serif = (Path(get_data_path()) / "fonts/ttf/DejaVuSerif.ttf").read_bytes()
        (tmp_path / "serif.ttf").write_bytes(serif)
        own = whole(text("I", font="serif.ttf"), tmp_path)
        assert own.area != pytest.approx(whole(text("I"), tmp_path).area, rel=0.05)
        rng = np.random.default_rng(5)
        for number in range(12):
            damaged = np.frombuffer(serif, np.uint8).copy()
            where = rng.integers(0, 4000 if number % 2 else len(damaged), 60)
            damaged[where] = rng.integers(0, 256, 60)
            (tmp_path / f"bad{number}.ttf").write_bytes(damaged.tobytes())
            said = "readable"
            try:
                assert math.isfinite(whole(text("Ig", font=f"bad{number}.ttf"), tmp_path).area)
            except AssetError as error:
                said = str(error)
            assert said == "readable" or f"bad{number}.ttf" in said


class TestSolids:
    def test_prisms_are_convex_few_and_as_large_as_the_letter(self):
        for letter, most in (("I", 1), ("L", 2), ("E", 5), ("A", 8), ("O", 24), ("8", 40)):
            shape = text(letter)
            found = geometry.pieces(shape, HERE)
            assert len(found) <= most, letter
            assert sum(piece.volume() for piece in found) == pytest.approx(geometry.volume(shape, HERE), rel=0.03)
            for piece in found:
                corners = np.array(piece.vertices)
                a, b, c = corners[np.array(piece.faces)].transpose(1, 0, 2)
                normals = np.cross(b - a, c - a)
                above = np.einsum("fk,vfk->vf", normals, corners[:, None] - a)
                assert above.max() <= 1e-9 * np.abs(above).max(), "all of it lies behind each of its faces"

    def test_convex_parts_fill_the_form_without_overlap(self):
        from shapely import Polygon, unary_union

        form = whole(text("&R"), HERE)
        cells = [Polygon(cell) for cell in convex_parts(form)]
        assert sum(cell.area for cell in cells) == pytest.approx(form.area)
        assert unary_union(cells).symmetric_difference(form).area < 1e-9
        assert all(cell.convex_hull.area == pytest.approx(cell.area, rel=1e-6) for cell in cells)

    def test_what_is_drawn_is_closed_and_has_normals_that_look_outward(self):
        (mesh,) = geometry.visual_mesh(text("A8"), HERE)
        assert signed_volume(mesh.vertices, mesh.faces) == pytest.approx(geometry.volume(text("A8"), HERE), rel=0.01)
        a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
        flat = np.cross(b - a, c - a)
        flat /= np.linalg.norm(flat, axis=1, keepdims=True)
        assert (np.einsum("fk,fck->fc", flat, mesh.normals[mesh.faces]) > 0.7).all()
        assert np.linalg.norm(mesh.normals, axis=1) == pytest.approx(1)

    def test_bounds_hold_in_every_orientation(self):
        shape, quat = text("Rg"), quat_from_euler_deg((20, 40, 60))
        low, high = extents(shape, quat, HERE)
        from scipy.spatial.transform import Rotation

        (mesh,) = geometry.visual_mesh(shape, HERE)
        turned = Rotation.from_quat(quat, scalar_first=True).apply(mesh.vertices)
        assert turned.min(0) == pytest.approx(low, abs=2e-3)
        assert turned.max(0) == pytest.approx(high, abs=2e-3)

    @pytest.mark.parametrize("edge", [0.1, 0.04, 0.015])
    def test_soft_letters_are_closed_at_every_fineness(self, edge):
        shape = text("Agi&8%\nQW@")
        mesh = soft_surface(shape, HERE, edge)
        faults = surface_faults(mesh, thin=False)
        assert faults.closed
        assert faults.loose == 12, "the i has a dot, the percent sign two rings"
        assert faults.volume == pytest.approx(geometry.volume(shape, HERE), rel=0.02)

    def test_the_same_text_gives_the_same_bytes(self):
        from text2sim.compiler.shapes import glyphs, lettering, softmesh

        one = write_obj(soft_surface(text("S"), HERE, 0.05))
        softmesh._SURFACES.clear()
        glyphs._scaled.cache_clear()
        lettering._set.cache_clear()
        assert write_obj(soft_surface(text("S"), HERE, 0.05)) == one


CASE = """\
text2sim: 2
name: letters
scene: {{duration: 1, statics: {{floor: {{shape: {{kind: plane}}}}}}}}
bodies:
  word:
    kind: {kind}
    shape: {shape}
    pose: {{pos: [1, 2, 3]}}
    repeat: {{kind: glyphs}}
{more}"""


def resolved(folder=HERE, shape='{kind: text, text: "Hi\\nyou", height: 0.3, depth: 0.1}', kind="rigid", more=""):
    return resolve_case(load_text(CASE.format(shape=shape, kind=kind, more=more), folder / "case.yaml"))


class TestCopies:
    def test_one_copy_for_each_letter_where_it_stands(self):
        copies = resolved().placed["word"]
        parts = glyph_parts(text("Hi\nyou"), HERE)
        assert [copy.name for copy in copies] == [f"word[{k}]" for k in range(5)]
        assert [copy.shape.part for copy in copies] == [0, 1, 2, 3, 4]
        for copy, part in zip(copies, parts, strict=True):
            assert copy.pos == pytest.approx((1 + part.offset[0], 2, 3 + part.offset[1]))
            assert copy.model.shape is copy.shape
        assert [copy.variables["row"] for copy in copies] == [0, 0, 1, 1, 1]
        assert [copy.variables["column"] for copy in copies] == [0, 1, 0, 1, 2]
        assert [copy.variables["u"] for copy in copies] == [0, 0.25, 0.5, 0.75, 1]
        assert copies[0].variables["n"] == 5

    def test_they_turn_with_their_body(self):
        copies = resolved(
            shape='{kind: text, text: "HH", height: 0.3, depth: 0.1}', more="    look: {color: red}\n"
        ).placed["word"]
        turned = resolve_case(
            load_text(
                CASE.format(shape='{kind: text, text: "HH", height: 0.3, depth: 0.1}', kind="rigid", more="").replace(
                    "pos: [1, 2, 3]", "pos: [1, 2, 3], euler_deg: [0, 0, 90]"
                )
            )
        ).placed["word"]
        across = copies[1].pos[0] - copies[0].pos[0]
        assert turned[1].pos == pytest.approx((1, 2 + across / 2, 3))

    def test_they_are_placed_together(self):
        shape = '{kind: text, text: "Ag", height: 0.3, depth: 0.1}'
        text_of = CASE.format(shape=shape, kind="rigid", more="").replace(
            "pose: {pos: [1, 2, 3]}", "place: {on: floor, at: [0, 0]}"
        )
        copies = resolve_case(load_text(text_of)).placed["word"]
        lows = [copy.pos[2] + extents(copy.shape, copy.quat, HERE)[0][2] for copy in copies]
        assert min(lows) == pytest.approx(0, abs=1e-6)
        assert lows[0] > 0.05, "the g hangs below the A"

    def test_names_may_vary_and_selectors_count(self):
        more = "    look: {color: white, vary: {hue: '${0.1 * u}', seed: 2}}\nactions: {measures: {h: {kind: extent, of: 'word[4]', axis: z, stat: max}}}\n"
        assert len(resolved(more=more).placed["word"]) == 5
        with pytest.raises(SpecError, match="`word` has 5 copies"):
            resolved(more=more.replace("word[4]", "word[5]"))

    def test_pieces_of_a_sketch(self, tmp_path):
        draw(tmp_path / "sketch.png", [(60, 50), (60, 250)], (220, 150, 90))
        shape = "{kind: sketch, file: sketch.png, height: 0.5, depth: 0.1}"
        found = resolved(tmp_path, shape, kind="soft")
        assert len(found.placed["word"]) == 2
        assert len({entity.options["file"] for entity in found.plan.bodies[0].entities}) == 2
        more = "actions: {measures: {h: {kind: extent, of: 'word[2]', axis: z, stat: max}}}\n"
        with pytest.raises(SpecError, match="`word` has 2 copies"):
            resolved(tmp_path, shape, kind="soft", more=more)

    @pytest.mark.parametrize(
        ("shape", "path", "said"),
        [
            ("{kind: box, size: [1, 1, 1]}", "/bodies/word/repeat", "this is neither"),
            ('{kind: text, text: "AB", height: 1, depth: 1, part: 0}', "/bodies/word/shape/part", "leave out `part`"),
            ("{kind: sketch, file: no.png, height: 1, depth: 1}", "/bodies/word/shape", "does not exist"),
            ('{kind: text, text: "  ", height: 1, depth: 1}', "/bodies/word/shape", "nothing but blanks"),
        ],
    )
    def test_what_has_no_letters_is_said_where_it_stands(self, tmp_path, shape, path, said):
        with pytest.raises(SpecError, match=said) as caught:
            resolved(tmp_path, shape)
        assert [problem.path for problem in caught.value.problems] == [path]

    def test_texts_that_differ_in_length_from_copy_to_copy(self):
        with pytest.raises(SpecError, match="there is no part|letters, that of copy 0"):
            resolved(shape="{kind: text, text: \"A${'B' if i else 'BC'}\", height: 1, depth: 1}")
