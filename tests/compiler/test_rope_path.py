"""Ropes that are laid along points and round pulleys."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from text2sim.compiler.build import compile_case, plan_case, resolve_case
from text2sim.compiler.placing.placement import place_all
from text2sim.compiler.trees.generators import link_of
from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.load import load_case, load_text

CASE = """
text2sim: 2
name: ropes
scene: {{duration: 1}}
bodies:
  line: {{kind: rope, along: {along}, radius: 0.005, segments: 80, pose: {{pos: [0, 0, 1]}}}}
  wheel: {{kind: rigid, shape: {{kind: cylinder, radius: 0.1, height: {height}}}, mount: {{kind: hinge, axis: {axis}}}, pose: {{pos: [0, 0, 2], euler_deg: [90, 0, 0]}}}}
  lower: {{kind: rigid, shape: {{kind: cylinder, radius: 0.06, height: 0.1}}, mount: {{kind: fixed}}, pose: {{pos: [0.5, 0, 1.5], euler_deg: [90, 0, 0]}}}}
  box: {{kind: rigid, shape: {{kind: box, size: [1, 1, 1]}}, pose: {{pos: [5, 0, 0]}}}}
"""


def case_of(folder: Path, along: str, height: float = 0.1, axis: str = "z"):
    (folder / "case.yaml").write_text(CASE.format(along=along, height=height, axis=axis))
    return load_case(folder)


def laid(folder: Path, along: str):
    copies, problems = place_all(case_of(folder, along))
    assert not problems, problems
    return copies["line"][0].model


@pytest.mark.parametrize(
    ("way", "cone", "timeconst"),
    [
        ("{round: wheel}", "elliptic", 0.001),
        ("[-0.105, 0, 1], [-0.074, 0, 1.074], [0, 0, 1.105], [0.074, 0, 1.074], [0.105, 0, 1]", "elliptic", 0.001),
        ("[0, 0, 1.2]", "pyramidal", 0.002),
    ],
)
def test_contacts_of_what_goes_round_something_are_stiff(tmp_path: Path, way: str, cone: str, timeconst: float):
    case_of(tmp_path, f"[[-0.105, 0, 0], {way}, [0.105, 0, 0]]")
    path = tmp_path / "case.yaml"
    path.write_text(path.read_text().replace("duration: 1", "duration: 1, dt: 0.01, substeps: 40"))
    settings = resolve_case(load_case(tmp_path)).settings
    assert (settings.solver, settings.cone) == ("cg", cone)
    assert settings.timeconst == pytest.approx(timeconst)


@pytest.mark.parametrize("own", [None, 3e-4])
def test_joints_of_what_is_laid_along_a_path_are_damped(tmp_path: Path, own: float | None):
    """15 m l2 per second: with the 0.05 of other ropes, links that slide round a post spin until they fly apart."""
    case_of(tmp_path, "[[-0.105, 0, 0], {round: wheel}, [0.105, 0, 0]]")
    path = tmp_path / "case.yaml"
    if own is not None:
        path.write_text(path.read_text().replace("segments: 80", f"segments: 80, damping: {own}"))
    lowering = resolve_case(load_case(tmp_path)).lowering
    link = lowering.trees["line"].roots[0].children[0]
    mass, length = link_of(place_all(load_case(tmp_path))[0]["line"][0].model)
    assert link.joint is not None
    assert link.joint.damping == pytest.approx(own or 15 * mass * length**2)


@pytest.mark.parametrize(("segments", "armature"), [(50, 0.02), (122, 1.5e-6 * 122**3 - 1 / 3)])
def test_the_links_of_a_long_rope_are_not_lost_in_its_inertia(tmp_path: Path, segments: int, armature: float):
    """A link has 1 / n^3 of the rope's inertia about its end: 5e-7 for 122 links, in numbers that are exact to 1.2e-7."""
    case_of(tmp_path, "[[-0.105, 0, 0], {round: wheel}, [0.105, 0, 0]]")
    path = tmp_path / "case.yaml"
    path.write_text(path.read_text().replace("segments: 80", f"segments: {segments}"))
    joint = resolve_case(load_case(tmp_path)).lowering.trees["line"].roots[0].children[0].joint
    mass, length = link_of(place_all(load_case(tmp_path))[0]["line"][0].model)
    assert joint is not None and joint.armature == pytest.approx(armature * mass * length**2)


def test_it_goes_over_one_pulley_and_under_the_next(tmp_path: Path):
    """The links keep the rope's radius off both, touch them, and are equally long."""
    line = laid(tmp_path, "[[-0.105, 0, 0], {round: wheel}, {round: lower, side: [0, 0, -1]}, [0.7, 0, 1.2]]")
    nodes = np.array(line.along) + [0, 0, 1]
    assert len(nodes) == 81
    lengths = np.linalg.norm(np.diff(nodes, axis=0), axis=1)
    assert lengths == pytest.approx(line.length / 80, rel=1e-6)
    assert nodes[[0, -1]] == pytest.approx(np.array([[-0.105, 0, 1], [0.7, 0, 2.2]]), abs=1e-6)
    middles = (nodes[1:] + nodes[:-1]) / 2
    for center, radius, top in (((0, 0, 2), 0.1, 1), ((0.5, 0, 1.5), 0.06, -1)):
        away = middles - center
        # Where it comes to a pulley, a link lies half on the straight part.
        assert radius + 0.005 - 1e-6 <= np.linalg.norm(away, axis=1).min() < radius + 0.0058
        assert top * away[np.linalg.norm(away, axis=1).argmin(), 2] > 0


def test_turns_lie_side_by_side(tmp_path: Path):
    line = laid(tmp_path, "[[-0.105, 0, 0], {round: wheel, turns: 2}, [0.105, 0, 0]]")
    nodes = np.array(line.along) + [0, 0, -1]
    wound = np.hypot(nodes[:, 0], nodes[:, 2]) < 0.11
    angle = np.unwrap(np.arctan2(nodes[wound, 2], nodes[wound, 0]))
    assert abs(angle[-1] - angle[0]) == pytest.approx(5 * math.pi, abs=0.7)
    assert np.ptp(nodes[wound, 1]) == pytest.approx(2 * 2.2 * 0.005, rel=0.1)


@pytest.mark.parametrize(
    ("along", "says"),
    [
        ("[[-0.105, 0, 0], {round: box}, [0.105, 0, 0]]", "cannot see how thick `box` is"),
        ("[[-0.02, 0, 1], {round: wheel}, [0.105, 0, 0]]", "comes from a point 20 mm from the axis of `wheel`"),
        ("[[0, 0, 0], {round: wheel}, [0, 0, 0]]", "on one line through the axis of `wheel`"),
        ("[[-1, 0, 2], {round: wheel}, [1, 0, 2]]", "passes `wheel` without touching it"),
        ("[[-0.105, 0, 0], {round: wheel, side: y}, [0.105, 0, 0]]", "has `side` along the axis of `wheel`"),
        ("[[-0.105, 0, 0], {round: wheel, turns: 20}, [0.105, 0, 0]]", "take 230 mm of `wheel`, which is 100 mm high"),
        ("[[-0.105, 0, -40], {round: wheel}, [0.105, 0, 0]]", "too long to lie round `wheel`"),
    ],
)  # fmt: skip
def test_what_cannot_be_laid_is_said_at_its_place(tmp_path: Path, along: str, says: str):
    _, problems = place_all(case_of(tmp_path, along))
    assert [(says in one.message, one.path) for one in problems] == [(True, "/bodies/line/along/1")]


@pytest.mark.parametrize(
    ("along", "end"),
    [
        ("[[{}, 0, 1], {{round: wheel, side: [0, 0, 1]}}, [0.105, 0, 0]]", -1),
        ("[[0.105, 0, 0], {{round: wheel, side: [0, 0, 1]}}, [{}, 0, 1]]", -1),
    ],
)
def test_a_point_on_the_pulley_is_told_how_far_to_move(tmp_path: Path, along: str, end: int):
    flush = 0.1 + 0.005  # radii of pulley and rope: straight links would dip into the pulley
    _, (problem,) = place_all(case_of(tmp_path, along.format(end * flush)))
    words = re.search(r"a point 105 mm from the axis of `wheel`.* move that point ([\d.]+) mm away", problem.message)
    assert words is not None, problem.message
    more = float(words[1]) / 1000
    assert place_all(case_of(tmp_path, along.format(end * (flush + more))))[1] == []
    assert place_all(case_of(tmp_path, along.format(end * (flush + more - 2e-4))))[1] != [], "not more than it needs"


def test_a_hinge_across_the_pulley_is_an_error(tmp_path: Path):
    _, (problem,) = place_all(case_of(tmp_path, "[[-0.105, 0, 0], {round: wheel}, [0.105, 0, 0]]", axis="y"))
    assert "goes round the z axis of `wheel`, whose own hinge has another `axis`" in problem.message


@pytest.mark.parametrize(
    ("along", "says"),
    [
        ("[[-0.105, 0, 0], {round: whel}, [0.105, 0, 0]]", "`whel`"),
        ("[{round: wheel}, [0.105, 0, 0]]", "along must begin and end with a point"),
        ("[[-0.105, 0, 0], [0.105, 0, 0]], length: 1", "give either length or along"),
    ],
)
def test_wrong_words_are_refused(tmp_path: Path, along: str, says: str):
    with pytest.raises(SpecError, match=says):
        compile_case(case_of(tmp_path, along), tmp_path / "program")


def test_a_rope_without_length_is_refused(tmp_path: Path) -> None:
    _, (problem,) = place_all(case_of(tmp_path, "[[0, 0, 1], [0, 0, 1]]"))
    assert "leads nowhere" in problem.message


@pytest.mark.parametrize(
    ("control", "rule", "words"),
    [
        ("{kind: attach, body: pail, to: cord}", "no-link", "from `cord.link_0` at its first end to `cord.link_17`"),
        ("{kind: attach, body: cord, to: world}", "no-link", "from `cord.link_0` at its first end to `cord.link_17`"),
        ("{kind: attach, body: pail, to: cord.end}", "unknown-link", "there are link_0, link_1, … link_17"),
        ("{kind: attach, body: pail, to: cord.link_17}", "", ""),
    ],
)
def test_a_rope_is_tied_by_one_of_its_links(control: str, rule: str, words: str) -> None:
    case = load_text(f"""
text2sim: 2
name: tied
scene: {{duration: 1}}
bodies:
  cord: {{kind: rope, length: 1, radius: 0.01, segments: 18, pose: {{pos: [0, 0, 2]}}}}
  pail: {{kind: rigid, shape: {{kind: box, size: [0.1, 0.1, 0.1]}}, pose: {{pos: [0, 0, 0.9]}}}}
actions: {{controls: {{tie: {control}}}}}
""")
    if not rule:
        plan_case(case)
        return
    with pytest.raises(SpecError) as caught:
        plan_case(case)
    (problem,) = caught.value.problems
    assert problem.rule == rule
    assert words in problem.message
