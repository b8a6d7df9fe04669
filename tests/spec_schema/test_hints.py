"""Slips that people make: each is said where it is, with the way out."""

import pytest
from small_case import only_problem

from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.load import load_case, load_text

HEAD = "text2sim: 2\nname: a\nprompt: p\nscene: {duration: 1}\nbodies:\n"
BODY = "  b: {kind: rigid, shape: {kind: sphere, radius: 1}"
SLIPS = [
    (BODY + ", repeat: {kind: grid, counts: [3, 0.5, 2], spacing: 1}}\n", (6, "/bodies/b/repeat/counts/1"), "(got 0.5)"),
    (BODY + ", repeat: {kind: grid, counts: [3, 2], spacing: [1, -1]}}\n", (6, "/bodies/b/repeat/spacing/1"), "(got -1)"),
    (BODY + "}\nwaive: {overlap: x}\n", (7, "/waive/overlap"), "at least 10 characters (got 1)"),
    (BODY + ", mass: 3}\n", (6, "/bodies/b/mass"), "`mass` belongs in `material`"),
    (BODY + ", position: [0, 0, 1]}\n", (6, "/bodies/b/position"), "`position` belongs in `pose`"),
    (BODY + ", velocity: [1, 0, 0]}\n", (6, "/bodies/b/velocity"), "`kind: initial_velocity` in `actions.controls`"),
    ("  b: {kind: cloth, shape: {kind: sheet, size: [1, 1]}, pinned: [left]}\n", (6, "/bodies/b/pinned"), "`kind: attach`"),
    (BODY.replace("rigid", "driven") + ", motion: {kind: waypoints, times: [0, 1], positions: [[0, 0, 0], [1, 0, 0]], spin: 3}}\n", (6, "/bodies/b/motion/spin"), "both slides and turns is `articulated`"),
    (BODY + ", fixed: true}\n", (6, "/bodies/b/fixed"), "`scene.statics`"),
    (BODY + ", pose: {position: [0, 0, 1]}}\n", (6, "/bodies/b/pose/position"), "did you mean `pos`?"),
    ("  b: {kind: rigid, shape: {kind: box, size: [1, 1, 1]}, look: {colour: red}}\n", (6, "/bodies/b/look/colour"), "`color`?"),
    ("  b\u0430ll: {kind: rigid, shape: {kind: sphere, radius: 1}}\n", (6, "/bodies/b\u0430ll"), "CYRILLIC SMALL LETTER A"),
    ("  b:\n    kind\uff1a rigid\n    shape: {kind: sphere, radius: 1}\n", (7, ""), "FULLWIDTH COLON"),
    ("  b:\n\u00a0   kind: rigid\n    shape: {kind: sphere, radius: 1}\n", (7, ""), "NO-BREAK SPACE"),
    ("  b: {kind:\u00a0rigid, shape: {kind: sphere, radius: 1}}\n", (6, ""), "NO-BREAK SPACE"),
    ("  b: {kind\uff1a rigid, shape: {kind: sphere, radius: 1}}\n", (6, ""), "FULLWIDTH COLON"),
    (BODY + ", pose: {pos: [0, 0, \u22121]}}\n", (6, "/bodies/b/pose/pos/2"), "MINUS SIGN"),
    (BODY + ", mount: {kind: hinge, axis: -y}}\n", (6, "/bodies/b/mount/axis"), "(got the text '-y'); write [0, -1, 0] ["),
    ("  b: {kind: rigid, shape: {kind: sphere, radius: {{r}}}}\n", (6, ""), "expressions are ${…}"),
    ("  b: {kind: rigid, shape: [}\n", (6, ""), "a bracket is closed that was not opened"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "place", "words"), SLIPS)
def test_a_slip_is_said_where_it_is(text, place, words):
    problem = only_problem(HEAD + text)
    assert (problem.line, problem.path) == place
    assert words in str(problem)


def test_a_key_with_a_letter_of_another_alphabet():
    with pytest.raises(SpecError, match="`\u0430` is CYRILLIC SMALL LETTER A"):
        load_text(HEAD + BODY.replace("radius", "r\u0430dius") + "}\n")


def test_a_name_in_curly_quotes():
    with pytest.raises(SpecError, match="`\u201c` is LEFT DOUBLE QUOTATION MARK"):
        load_text((HEAD + BODY + "}\n").replace("name: a", "name: \u201ca\u201d"))


def test_a_case_that_is_a_link_out_of_its_folder_is_not_read(tmp_path):
    (tmp_path / "secret").write_text("password: 1234\n")
    folder = tmp_path / "case"
    folder.mkdir()
    (folder / "case.yaml").symlink_to(tmp_path / "secret")
    with pytest.raises(SpecError, match="leads out of the folder") as raised:
        load_case(folder)
    assert "1234" not in str(raised.value)
    (folder / "case.yaml").unlink()
    (folder / "mine.yaml").write_text(HEAD + BODY + "}\n")
    (folder / "case.yaml").symlink_to("mine.yaml")
    assert load_case(folder).case.name == "a"
