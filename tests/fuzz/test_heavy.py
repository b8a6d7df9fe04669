"""Documents that are no trouble to write and would be much work: each is answered in little time."""

import time

import pytest

from text2sim.compiler.build import resolve_case
from text2sim.lint import lint_case
from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.load import load_case, load_text

SECONDS = 30.0
"""Far more than any of these takes (under 3 s): a test fails on work that explodes, not on a busy machine."""
HEAD = """\
text2sim: 2
name: heavy
scene: {duration: 1, statics: {floor: {shape: {kind: plane}}}}
bodies:
"""
HEAVY = {
    "copies": ("  post: {kind: rigid, shape: {kind: sphere, radius: 0.1}, place: {left_of: floor, facing: [0, 0, 0]}, "
               "repeat: {kind: line, count: 100000, step: [0, 0, 0]}}\n", "more than 20,000 convex pieces"),
    "cups": ("  cup: {use: cup, with: {height: '${0.05 + 0.0001 * i}'}, repeat: {kind: grid, counts: [20, 40], spacing: 0.3}}\n",
             "more than 250 different surfaces"),
    "nets": ("  net: {kind: net, cells: [20, 20], size: [1, 1], radius: 0.004, pose: {pos: [0, 0, 1]}, "
             "repeat: {kind: line, count: 5, step: [0.01, 0.01, 0.001]}}\n", ""),
    "one place": ("  ball: {kind: rigid, shape: {kind: sphere, radius: 3}, pose: {pos: [0, 0, 5]}, "
                  "repeat: {kind: grid, counts: [6, 1000], spacing: 1.0e-6}}\n", "overlap by 6 m at the start"),
    "a heap": ("  cup: {use: cup, repeat: {kind: line, count: 120, step: [0.001, 0, 0]}}\n", ""),
    "round": ("  barrel: {kind: rigid, shape: {kind: tube, outer_radius: 0.5, inner_radius: 0.3, height: 1}, pose: {pos: [0, 0, 2]}}\n"
              "  roll: {kind: rigid, shape: {kind: cylinder, radius: 0.4, height: 200}, pose: {pos: [0, 0, 2]}, "
              "repeat: {kind: line, count: 30, step: [0.01, 0.02, 0.003]}}\n", ""),
    "jagged": ("  lump: {kind: rigid, shape: {kind: mesh, file: mesh.obj, scale: 0.001}, pose: {pos: [0, 0, 1]}}\n", ""),
    "far": ("  lump: {kind: rigid, shape: {kind: mesh, file: far.obj}, pose: {pos: [0, 0, 1]}}\n", "a coordinate of 1e+30"),
}  # fmt: skip


@pytest.mark.filterwarnings("error", "ignore::pytest.PytestUnraisableExceptionWarning")  # of earlier tests
@pytest.mark.parametrize("name", list(HEAVY))
def test_is_answered_in_time(tmp_path, name):
    body, complaint = HEAVY[name]
    (tmp_path / "case.yaml").write_text(HEAD + body)
    corners = "".join(f"v {i % 97} {i % 89} {i % 83}\n" for i in range(40_000))
    (tmp_path / "mesh.obj").write_text(corners + "".join(f"f {i} {i + 1} {i + 2}\n" for i in range(1, 39_000)))
    (tmp_path / "far.obj").write_text("v 0 0 0\nv 1e30 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n")
    import trimesh  # noqa: F401  loaded before the clock runs

    start = time.process_time()
    try:
        said = " ".join(problem.message for problem in lint_case(resolve_case(load_case(tmp_path))).problems)
    except SpecError as error:
        said = str(error)
    assert time.process_time() - start < SECONDS
    assert complaint in said


def test_the_time_of_copies_goes_with_their_number(tmp_path):
    took = []
    for rows in (10, 10, 40):  # the first imports what is needed
        body = "  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, place: {on: floor, at: [0, 0]}, "
        body += f"repeat: {{kind: grid, counts: [{rows}, 200], spacing: 0.3}}}}\n"
        (tmp_path / "case.yaml").write_text(HEAD + body)
        start = time.process_time()
        assert lint_case(resolve_case(load_case(tmp_path))).ok
        took.append(time.process_time() - start)
    assert took[2] < 10 * took[1], "four times as many would take sixteen times as long if it were quadratic"


def test_expressions_are_read_once_and_bounded(tmp_path):
    """4,000 of them, nested 14 deep, cost under a second more than plain numbers; what would cost more is refused."""
    from text2sim.spec_schema.arithmetic import expressions

    before, seen = expressions.parse_expression.cache_info().misses, 4000
    rows = "".join(f"  p{i}: ${{{'(a+' * 14}{i}{')' * 14}}}\n" for i in range(seen))
    ball = "  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, place: {on: floor, at: [0, 0]}}\n"
    start = time.process_time()
    lint_case(resolve_case(load_text(f"{HEAD}{ball}params:\n  a: 1\n{rows}", tmp_path / "case.yaml")))
    assert time.process_time() - start < 5.0, "about 0.8 s"
    assert expressions.parse_expression.cache_info().misses - before <= seen + 10, "nobody reads them again"
    long = "".join(f"  p{i}: ${{max({'1,' * 240}{i})}}\n" for i in range(3500))
    with pytest.raises(SpecError, match="more than 600000 characters") as raised:
        load_text(f"{HEAD}{ball}params:\n{long}", tmp_path / "case.yaml")
    assert len(raised.value.problems) == 1


def test_expectations_of_one_measure_are_not_all_held_against_each_other():
    rows = "".join(f"    e{i}: {{measure: m, at: end, below: {i + 1}}}\n" for i in range(4000))
    ball = "  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, place: {on: floor, at: [0, 0]}}\n"
    start = time.process_time()
    actions = f"actions:\n  measures: {{m: {{kind: speed, of: ball}}}}\n  expect:\n{rows}"
    lint_case(resolve_case(load_text(f"{HEAD}{ball}{actions}")))
    assert time.process_time() - start < 4.0, "about 0.5 s; all pairs take 10 s"


def test_of_a_hundred_thousand_errors_ten_thousand_are_said():
    text = HEAD + "".join(f"  b{i}: 1\n" for i in range(30_000))
    start = time.process_time()
    with pytest.raises(SpecError, match="20,000 more values are wrong") as raised:
        load_text(text)
    assert len(raised.value.problems) == 10_001
    assert time.process_time() - start < 6.0, "about 1 s"
