"""Prefabs: what is wrong with a use or with a prefab and where it is said, and what hostile ones cannot do."""

import time
from pathlib import Path

import pytest
from small_case import only_problem
from stick_prefabs import HEAD, STICK

from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.reuse.overlay import CaseOverlay

ENDLESS = 60.0
"""CPU time [s] that only work which doubles at every step can take; all of it is done in a fraction of a second."""

# --- what is wrong with a use -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("given", "key", "says", "hint"),
    [
        ("length: 3", "length", "needs a length [m] from 0.1 to 2 (got the number 3)", None),
        ("length: '${speed}'", "length", "needs a length [m] from 0.1 to 2 (got the number 3)", None),
        ("length: '${sped}'", "length", "unknown name `sped`; there are speed, d, low", "speed"),
        ("length: '${i + 1}'", "length", "`i` varies between copies and is defined only beside a repeat", None),
        ("length: '${1 +}'", "length", "`1 +` is not arithmetic", None),
        ("lenght: 1", "lenght", "unknown parameter `lenght`; `stick` takes length, thick", "length"),
        ("thick: 0", "thick", "needs a length [m] greater than 0 (got the number 0)", None),
        ("thick: true", "thick", "(got true)", None),
        ("count: 1.5", "count", "needs a whole number (got the number 1.5)", None),
        ("at: [0, 0]", "at", "needs 3 numbers of at least -5 (got [0, 0])", None),
        ("at: [0, 0, '${low}']", "at", "needs 3 numbers of at least -5 (got [0, 0, -9])", None),
        ("at: {x: 1}", "at", "(got a mapping)", None),
        ("at: {x: '${d}'}", "at", "(got a mapping)", None),
        ("at: [{x: '${d}'}, 1, '${d}']", "at", "(got a list of 3 items)", None),
        ("hue: redd", "hue", "unknown colour `redd`", "red"),
        ("hue: [1, 2, 0]", "hue", "needs a colour", None),
        ("what: wod", "what", "needs one of wood, metal (got the text 'wod')", "wood"),
        ("'on': a b", "on", "`a b` is not a selector", None),
        ("plain: 1", "plain", "needs true or false (got the number 1)", None),
        ("what: null", "what", "(got nothing)", None),
    ],
)
def test_an_argument_is_checked_where_it_stands(use_problems, given, key, says, hint):
    (problem,) = use_problems(f"  s: {{use: stick, with: {{{given}}}}}\n")
    assert (problem.path, problem.line, problem.hint) == (f"/bodies/s/with/{key}", 7, hint)
    assert says in problem.message


@pytest.mark.parametrize(
    ("use", "path", "says", "hint"),
    [
        ("{use: stik}", "/bodies/s/use", "there is no prefab `stik`; there are ", "stick"),
        ("{use: ../stick}", "/bodies/s/use", "there is no prefab `../stick`", "stick"),
        ("{use: '${d}'}", "/bodies/s/use", "cannot be an expression", None),
        ("{use: [stick]}", "/bodies/s/use", "needs the name of a prefab", None),
        ("{use: null}", "/bodies/s/use", "needs the name of a prefab (got nothing)", None),
        ("{use: stick, with: 3}", "/bodies/s/with", "needs a mapping of parameters", None),
        ("{use: gate}", "/bodies/s", "`gate` needs the parameter `width` (a length [m] greater than 0)", None),
        ("{use: gate, with: {width: 1}, bra: {}}", "/bodies/s/bra", "are its parts: post, bar", "bar"),
        ("{use: stick, mas: 3}", "/bodies/s/mas", "unknown key `mas`", None),
    ],
)
def test_what_is_wrong_with_a_use(use_problems, use, path, says, hint):
    (problem,) = use_problems(f"  s: {use}\n")
    assert (problem.path, problem.line, problem.hint) == (path, 7, hint)
    assert says in problem.message


def test_what_is_wrong_inside_is_said_of_the_use_with_the_line_of_the_prefab(use_problems, write_prefabs):
    write_prefabs(thin=STICK.replace("stick", "thin").replace('["${thick}"', '["${thick - 1}"'))
    (problem,) = use_problems("  s: {use: thin}\n")
    assert (problem.path, problem.line, problem.column) == ("/bodies/s/shape/size/0", 7, 12)
    assert problem.message == "must be greater than 0 (got -0.95) (in prefab `thin`, prefabs/thin.yaml:15)"


def test_what_is_wrong_in_a_prefab_of_a_prefab_names_both(use_problems):
    (problem,) = use_problems("  s: {use: gate, with: {width: 9}}\n")
    assert problem.path == "/bodies/s_post/with/length"
    assert problem.message.endswith("(got the number 4.5) (in prefab `gate`, prefabs/gate.yaml:5)")


def test_uses_that_are_fine_are_checked_beside_those_that_are_not(use_problems):
    found = use_problems("  s: {use: stik}\n  t: {use: stick, with: {length: 9}}\n  u: {kind: ragdoll, height: -1}\n")
    assert [problem.path for problem in found] == ["/bodies/s/use", "/bodies/t/with/length", "/bodies/u/height"]


def test_two_bodies_cannot_have_one_name(use_problems):
    (problem,) = use_problems("  s: {use: gate, with: {width: 1}}\n  s_bar: {kind: ragdoll, height: 1}\n")
    assert (problem.line, problem.rule) == (7, "duplicate-name")


@pytest.mark.parametrize("bodies", ["{use: gate, with: {width: 1}}", "{use: doll}"])
def test_a_static_is_one_rigid_body(tmp_path: Path, write_prefabs, bodies):
    write_prefabs(doll="text2sim: 2\nprefab: doll\nbody: {kind: ragdoll, height: 1}\n")
    text = HEAD.replace("floor: {", f"pole: {bodies}, floor: {{") + "bodies: {b: {kind: ragdoll, height: 1}}\n"
    problem = only_problem(text, tmp_path / "case.yaml")
    assert problem.path == "/scene/statics/pole"
    assert "static" in problem.message
    assert "got" not in problem.message
    assert ("`kind: ragdoll`" in problem.message) == ("doll" in bodies)


# --- what is wrong with a prefab --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("edit", "line", "says"),
    [
        (("prefab: stick", "prefab: stik"), 2, "the file is stick.yaml"),
        (("text2sim: 2\n", ""), 1, "`text2sim` is missing"),
        (("text2sim: 2", "text2sim: 7"), 1, "versions 1 to 2"),
        (("kind: length, default: 0.5", "kind: lenght, default: 0.5"), 5, "must be one of number, integer, length"),
        (('"${length / 10}"', "{a: '${length}'}"), 6, "(got a mapping)"),
        (("default: 0.5", "default: 5"), 5, "needs a length [m] from 0.1 to 2 (got the number 5)"),
        (("min: 0.1, max: 2", "min: 3, max: 2"), 5, "max must not be smaller than min"),
        (("${length / 10}", "${lenght / 10}"), 6, "unknown name `lenght`: a prefab knows its own parameters"),
        (("${length / 10}", "${thick}"), 6, "defaults refer to each other in a cycle"),
        (("${length / 10}", "${speed}"), 6, "unknown name `speed`"),
        (("${length / 10}", "${i}"), 6, "unknown name `i`"),
        (("  count:", "  pi:"), 7, "`pi` already has a meaning"),
        ((", of: [wood, metal]", ""), 10, "choice needs `of`"),
        (("body:\n", "bod:\n"), 13, "unknown key `bod`"),
        (("  material: {density", "  material: {densty"), 16, "unknown key `densty`"),
        (("  material:", "  materiel:"), 16, "unknown key `materiel`"),
        (("${700 if", "${700 + if"), 16, "is not arithmetic"),
        (("body:", "more: 3\nbody:"), 13, "unknown key `more`; a prefab takes text2sim, prefab, doc, params, body"),
        (("doc: A stick.", "doc: [A"), 4, "not valid YAML"),
    ],
)
def test_a_broken_prefab_is_reported_in_its_own_file(use_problems, write_prefabs, tmp_path, edit, line, says):
    write_prefabs(stick=STICK.replace(*edit))
    found = [p for p in use_problems("  s: {use: stick}\n  t: {use: stick}\n") if says in p.message]
    (problem,) = found
    assert (problem.file, problem.line) == (str(tmp_path / "prefabs" / "stick.yaml"), line)
    assert problem.message.endswith("(used by `s`)")


def test_a_prefab_of_the_case_is_checked_whether_it_is_used_or_not(use_problems):
    top = "prefabs:\n  a: {body: {kind: rigid, shap: {}}}\n  b: 3\n  c: {params: {x: {kind: number, default: a}}, body: {}}\n"
    found = use_problems("  s: {use: a}\n", top)
    assert [(p.path, p.line) for p in found] == [
        ("/prefabs/a/body/shap", 6),
        ("/prefabs/b", 7),
        ("/prefabs/c/params/x/default", 8),
    ]


def test_prefabs_that_use_each_other_in_a_circle(use_problems, write_prefabs):
    write_prefabs(a="text2sim: 2\nprefab: a\nbody: {use: b}\n", b="text2sim: 2\nprefab: b\nbodies: {x: {use: a}}\n")
    (problem,) = use_problems("  s: {use: a}\n")
    assert (problem.line, problem.rule) == (7, "circular-use")
    assert "a → b → a (in prefab `b`, prefabs/b.yaml:3, in prefab `a`, prefabs/a.yaml:3)" in problem.message


# --- hostile prefabs --------------------------------------------------------------------------------------------


def test_texts_that_look_like_code_stay_texts(use_problems, write_prefabs):
    write_prefabs(
        label=STICK.replace("stick", "label")
        .replace("{kind: color, default: red}", "{kind: text}")
        .replace("hue if plain else 'black'", "hue")
    )
    (problem,) = use_problems("  s: {use: label, with: {hue: '$${__import__(1)}'}}\n")
    assert "unknown colour `${__import__(1)}`" in problem.message
    (problem,) = use_problems("  s: {use: label, with: {hue: \"red' if 1 else '\"}}\n")
    assert problem.rule == "unknown-color"


def test_no_prefab_is_read_from_outside(use_problems, tmp_path):
    (tmp_path / "secret.yaml").write_text("text2sim: 2\nprefab: link\nbody: {kind: ragdoll, height: 1}\n")
    outside = tmp_path.parent / f"{tmp_path.name}_outside.yaml"
    outside.write_text("text2sim: 2\nprefab: out\nbody: {kind: ragdoll, height: 1}\n")
    (tmp_path / "prefabs" / "out.yaml").symlink_to(outside)
    (tmp_path / "prefabs" / "loop.yaml").symlink_to(tmp_path / "prefabs" / "loop.yaml")
    (tmp_path / "prefabs" / "null.yaml").symlink_to("/dev/zero")
    (tmp_path / "prefabs" / "dir.yaml").mkdir()
    for name in ("out", "loop", "null", "dir", "../secret", "/etc/passwd", "..", ""):
        (problem,) = use_problems(f"  s: {{use: '{name}'}}\n")
        assert problem.severity == "error", name


def test_a_folder_elsewhere_is_not_even_listed(tmp_path):
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "secret.yaml").write_text(STICK)
    (tmp_path / "case").mkdir()
    (tmp_path / "case" / "prefabs").symlink_to(tmp_path / "there")
    with pytest.raises(SpecError) as caught:
        load_text(f"{HEAD}bodies: {{s: {{use: secrets}}}}\n", tmp_path / "case" / "case.yaml")
    assert "secret," not in caught.value.problems[0].message
    assert caught.value.problems[0].hint != "secret"


def test_an_unknown_argument_says_that_it_was_set(use_problems):
    sets = ("bodies.s.with.lenght=2",)
    (problem,) = use_problems("  s: {use: stick, with: {length: 1}}\n", overlay=CaseOverlay(sets=sets))
    assert problem.rule == "unknown-param"
    assert "from `--set bodies.s.with.lenght=2`" in problem.message


def test_defaults_that_double_are_refused_at_once(use_problems, write_prefabs):
    rows = "".join(f"  p{k}: {{kind: number, default: '${{p{k - 1} + p{k - 1}}}'}}\n" for k in range(1, 90))
    write_prefabs(
        bomb=f"text2sim: 2\nprefab: bomb\nparams:\n  p0: {{kind: number}}\n{rows}body: {{kind: rigid, shape: {{kind: sphere, radius: '${{p89}}'}}}}\n"
    )
    begun = time.process_time()
    for value in ("'${d}'", "1", "'${i}'"):
        (problem,) = use_problems(f"  s: {{use: bomb, with: {{p0: {value}}}}}\n")
        assert problem.rule == "too-large"
        assert "prefabs/bomb.yaml" in problem.message
    assert time.process_time() - begun < ENDLESS


def test_defaults_that_nest_deeper_and_deeper_are_refused(use_problems, write_prefabs):
    rows = "".join(f"  p{k}: {{kind: number, default: '${{-p{k - 1} + {'-' * 25}1}}'}}\n" for k in range(1, 90))
    write_prefabs(
        deep=f"text2sim: 2\nprefab: deep\nparams:\n  p0: {{kind: number}}\n{rows}body: {{kind: rigid, shape: {{kind: sphere, radius: '${{p89}}'}}}}\n"
    )
    begun = time.process_time()
    (problem,) = use_problems("  s: {use: deep, with: {p0: '${d}'}}\n")
    assert "nested more than 100 deep" in problem.message
    assert time.process_time() - begun < ENDLESS


def test_prefabs_that_multiply_are_refused_at_once(use_problems, write_prefabs):
    for k in range(7):
        parts = "".join(f"  a{j}: {{use: w{k + 1}}}\n" for j in range(50))
        write_prefabs(**{f"w{k}": f"text2sim: 2\nprefab: w{k}\nbodies:\n{parts}"})
    write_prefabs(w7="text2sim: 2\nprefab: w7\nbody: {kind: ragdoll, height: 1}\n")
    begun = time.process_time()
    (problem,) = use_problems("  s: {use: w0}\n")
    assert problem.rule == "too-large"
    assert time.process_time() - begun < ENDLESS


def test_long_texts_cannot_be_multiplied(use_problems, write_prefabs):
    sites = ", ".join(["'${len(t)}'"] * 500)
    body = (
        "body: {kind: rigid, shape: {kind: compound, parts: {"
        + ", ".join(f"p{k}: {{shape: [{sites}]}}" for k in range(100))
        + "}}}"
    )
    write_prefabs(wide=f"text2sim: 2\nprefab: wide\nparams: {{t: {{kind: color}}}}\n{body}\n")
    begun = time.process_time()
    found = use_problems("  s: {use: wide, with: {t: [" + ", ".join(["red"] * 600) + "]}}\n")
    assert {problem.rule for problem in found} == {"too-large"}
    assert time.process_time() - begun < ENDLESS


def test_prefabs_are_not_too_large_in_all(use_problems, write_prefabs):
    for k in range(3):
        write_prefabs(
            **{f"big{k}": f"text2sim: 2\nprefab: big{k}\nbody: {{kind: ragdoll, height: 1}}\n" + "# words\n" * 100_000}
        )
    (problem,) = use_problems("".join(f"  s{k}: {{use: big{k}}}\n" for k in range(3)))
    assert (problem.path, problem.message) == (
        "/bodies/s2/use",
        "with `big2`, the prefabs are larger than 2 MB in all (prefabs/big2.yaml)",
    )
