"""Facts that the program computes of runs, and what they do to a judgement."""

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from tests.agents.test_criticism import judged
from tests.harness.conftest import WrittenRun
from text2sim.agents import facts
from text2sim.agents.color_terms import color_name, matches_color
from text2sim.agents.conversation import Wrong, typed_parser
from text2sim.agents.facts import _FACT_FUNCTIONS, Fact, claim_faults, compute_facts
from text2sim.agents.replies import FACTS, Claim
from text2sim.agents.roles import PROMPTS
from text2sim.compiler.build import resolve_case
from text2sim.spec_schema.load import load_text

CASE = """\
text2sim: 2
name: shove
prompt: A red ball shoves a tin.
scene:
  duration: 1.0
  statics: {floor: {shape: {kind: plane}}}
bodies:
  ball:
    kind: rigid
    shape: {kind: sphere, radius: 0.1}
    pose: {pos: [0, 0, 1]}
    look: {color: firebrick}
  tin:
    kind: rigid
    shape:
      kind: compound
      parts:
        can: {shape: {kind: cylinder, radius: 0.1, height: 0.2}}
        lid: {shape: {kind: box, size: [0.1, 0.1, 0.01]}, pose: {pos: [0, 0, 0.105]}, look: {color: gold}}
    pose: {pos: [1, 0, 1]}
    look: {color: [navy, black]}
    repeat: {kind: line, count: 2, step: [1, 0, 0]}
  cart:
    kind: articulated
    pose: {pos: [5, 0, 1]}
    look: {color: crimson}
    links:
      frame:
        shape:
          kind: compound
          parts:
            floor: {shape: {kind: box, size: [0.5, 0.3, 0.02]}}
            handle: {shape: {kind: box, size: [0.02, 0.3, 0.02]}, pose: {pos: [0.2, 0, 0.1]}, look: {color: black}}
      flap:
        parent: frame
        shape: {kind: compound, parts: {plate: {shape: {kind: box, size: [0.3, 0.3, 0.02]}, look: {color: gold}}}}
        pose: {pos: [0, 0, 0.3]}
        joint: {kind: hinge, axis: y}
actions:
  controls:
    push: {kind: force, body: ball, force: [5, 0, 0], during: [0, 0.2]}
    hold: {kind: attach, body: "tin[1]", to: world}
"""


@pytest.fixture
def told(tmp_path: Path) -> Any:
    """Return a function that tells one fact of a run in which `ball` touches a tin at 0.5 s, which then moves 1 m/s."""
    (tmp_path / "run").mkdir()
    run = WrittenRun(tmp_path / "run")
    along = np.maximum(run.time - 0.5, 0.0)
    moved = np.stack([1 + along, 0 * along, 1 + 0 * along], axis=1)
    early = np.stack([3 * run.time, 0 * along, 1 + 0 * along], axis=1)
    run.add_link("floor", fixed=True)
    ball, tin, other = run.add_link("ball"), run.add_link("tin[0]", pos=moved), run.add_link("tin[1]", pos=early)
    run.touch(ball, tin, range(50, 54), (50.0, 0, 0))
    run.touch(ball, other, range(90, 94), (50.0, 0, 0))
    run.write()
    seen = {
        "state": "finished",
        "legibility": {
            "films": {
                "main": {
                    "bodies": {"ball": {"share": {"max": 0.0003}}, "tin": {"share": {"max": 0.02}}},
                    "statics": {"post": 0.05, "peg": 0.0},
                }
            }
        },
    }
    (run.folder / "evidence.json").write_text(json.dumps(seen))
    samples = [
        {"t": 0.0, "shares": {"rail[0]": 0.001}},
        {"t": 1.0, "shares": {"rail[0]": 0.002, "rail[1]": 0.001, "dot": 0.0001}},
    ]
    (run.folder / "visibility.json").write_text(json.dumps({"main": samples}))

    def tell(**claim: Any) -> Fact:
        (fact,) = compute_facts({"it": [Claim(**claim)]}, load_text(CASE, tmp_path / "case.yaml"), run.folder)
        return fact

    return tell


@pytest.mark.parametrize(("part", "ok"), [(0.83, False), (0.98, True)])
def test_what_is_wanted_whole_is_never_cut_by_an_edge(part: float, ok: bool) -> None:
    run: Any = SimpleNamespace(least_inside={"pit": part})
    told = facts._is_seen(Claim(seen="pit", whole=True), run)
    assert told == (ok, f"{100 * part:.0f} % of `pit` at least is within the picture, wanted all of it")
    with pytest.raises(ValidationError, match="`whole` goes with `seen`"):
        Claim(count="pit", equals=1, whole=True)


def test_a_claim_says_which_of_its_fields_need_each_other() -> None:
    with pytest.raises(ValidationError, match="`by` and `moved` or `touched` need each other"):
        Claim(moved="tin")


def test_the_size_of_a_body_with_links_is_that_of_all_of_them() -> None:
    """A chain of five links of 0.1 m each, with round ends, is half a metre long and a little more."""
    text = """
text2sim: 2
name: hanging
prompt: A chain.
scene: {duration: 1}
bodies:
  chain: {kind: chain, links: 5, link_length: 0.1, radius: 0.01, pose: {pos: [0, 0, 1]}}
  arm:
    kind: articulated
    links:
      post: {shape: {kind: box, size: [0.1, 0.1, 0.3]}}
      hand: {parent: post, joint: {kind: hinge, axis: y}, pose: {pos: [0, 0, 0.2]}, shape: {kind: sphere, radius: 0.05}}
    pose: {pos: [1, 0, 0.2]}
"""
    run: Any = SimpleNamespace(resolution=resolve_case(load_text(text, Path("case.yaml"))))
    target: Any = SimpleNamespace(label="chain", copy="chain")
    assert 0.5 <= facts._size(target, run) <= 0.52
    target = SimpleNamespace(label="arm.hand", copy="arm")
    assert facts._size(target, run) == pytest.approx(0.1)


def test_the_mass_of_what_deforms_is_that_of_its_volume() -> None:
    text = """
text2sim: 2
name: balls
scene: {duration: 1, statics: {floor: {shape: {kind: plane}}}}
bodies:
  clay:
    kind: soft
    shape: {kind: box, size: [0.1, 0.1, 0.2]}
    solver: mpm
    material: {density: 1500}
    place: {on: floor}
"""
    run: Any = SimpleNamespace(resolution=resolve_case(load_text(text, Path("case.yaml"))))
    target: Any = SimpleNamespace(label="clay", copy="clay", soft=object())
    assert facts._mass(target, run) == pytest.approx(3.0)


@pytest.mark.parametrize(
    ("claim", "ok", "said"),
    [
        ({"count": "tin", "equals": 2}, True, "there are 2"),
        ({"count": "tin", "equals": 3}, False, "there are 2 `tin`, wanted 3"),
        ({"color": "ball", "like": "red"}, True, "red (#b22222)"),
        ({"color": "ball", "like": "blue"}, False, "wanted blue"),
        ({"color": "tin.lid", "like": "yellow"}, True, "(#ffd700)"),
        ({"color": "tin.can", "like": "yellow"}, False, "wanted yellow"),
        ({"color": "tin[1]", "like": "black"}, True, "black"),
        ({"color": "tin", "like": "blue"}, False, "wanted blue"),
        ({"color": "tin.foot", "like": "blue"}, None, "no part `foot`"),
        ({"color": "cart.frame", "like": "red"}, True, "black (#000000)"),  # but for its handle, which is black
        ({"color": "cart.flap", "like": "red"}, False, "wanted red"),
        ({"seen": "tin"}, True, "2 %"),
        ({"seen": "ball"}, False, "0.03 %"),
        ({"seen": "lamp"}, None, "not measured"),
        ({"seen": "post"}, True, "5 %"),
        ({"seen": "peg"}, False, "0 %"),
        ({"seen": "rail"}, True, "0.3 %"),  # of statics, all copies in one picture
        ({"seen": "dot"}, False, "0.01 %"),
        ({"seen": "tin.lid"}, None, "has no link `lid`"),
        ({"moved": "tin", "by": "ball"}, True, "first touches `tin[0]` at 0.5 s"),
        ({"moved": "tin[1]", "by": "ball"}, False, "which moved 2.7 m"),
        ({"moved": "tin", "by": "floor"}, False, "never touches"),
        ({"moved": "tin", "by": ["floor", "ball"]}, True, "`floor` or `ball` first touches `tin[0]` at 0.5 s"),
        ({"touched": "tin", "by": ["ball", "floor"], "lasting": 0.1}, False, "for 0.08 s in all, wanted 0.1 s"),
        ({"moved": "tin", "by": "lamp"}, None, "`lamp` was not recorded"),
        ({"touched": "tin[0]", "by": "ball"}, True, "first at 0.5 s, for 0.04 s in all"),  # steps 50 to 53 of 0.01 s
        ({"touched": "tin", "by": "ball"}, True, "first at 0.5 s, for 0.08 s in all"),
        ({"touched": "tin", "by": "ball", "lasting": 0.08}, True, "wanted 0.08 s"),
        ({"touched": "tin", "by": "ball", "lasting": 0.1}, False, "wanted 0.1 s"),
        ({"touched": "tin", "by": "ball", "never": True}, False, "wanted never"),
        ({"touched": "tin", "by": "floor"}, False, "never touches"),
        ({"touched": "tin", "by": "floor", "never": True}, True, "never touches"),
        ({"touched": "tin", "by": "lamp"}, None, "`lamp` was not recorded"),
        ({"same": "mass", "of": ["ball", "tin"]}, True, "`ball` 1 kg, `tin[0]` 1 kg, `tin[1]` 1 kg"),
        ({"same": "size", "of": ["tin"]}, True, "`tin[1]` 0.21 m"),  # can and lid: -0.1 to 0.11
        ({"same": "size", "of": ["ball", "tin"]}, False, "`ball` 0.2 m"),
        ({"same": "size", "of": ["floor", "ball"]}, None, "cannot be told"),
        ({"same": "mass", "of": ["ball"]}, None, "`ball` is only one body"),
        ({"same": "mass", "of": ["lamp", "ball"]}, None, "`lamp` was not recorded"),
        ({"passive": "tin"}, True, "no force, drive or start velocity acts on `tin`"),
        ({"passive": "ball"}, False, "`push` (force) acts on `ball`"),
    ],
)  # fmt: skip
def test_a_fact_is_true_false_or_open(told: Any, claim: dict[str, Any], ok: bool | None, said: str) -> None:
    fact = told(**claim)
    assert fact.ok is ok, fact.told
    assert said in fact.told


def test_what_never_touched_until_a_run_broke_off_is_open(told: Any, tmp_path: Path) -> None:
    evidence = tmp_path / "run" / "evidence.json"
    evidence.write_text(evidence.read_text("utf-8").replace("finished", "diverged"))
    fact = told(touched="tin", by="floor", never=True)
    assert fact.ok is None
    assert "before its end" in fact.told
    assert told(touched="tin", by="ball", never=True).ok is False, "what has happened has happened"


def test_what_moved_before_it_was_removed_has_moved(told: Any, tmp_path: Path) -> None:
    (tmp_path / "run" / "states" / "removed.json").write_text('{"tin[0]": 0.8}')
    fact = told(moved="tin", by="ball")
    assert fact.ok is True, fact.told
    assert "0.3 m and 0 deg after" in fact.told


def test_colours_go_by_everyday_words() -> None:
    assert matches_color((0.70, 0.13, 0.13), "red")
    assert matches_color((0.0, 0.45, 0.70), "blue")
    assert not matches_color((0.0, 0.45, 0.70), "green")
    assert not matches_color((0.5, 0.5, 0.5), "white")
    assert matches_color((0.56, 0.59, 0.62), "steel")
    assert color_name((0.0, 0.0, 0.0)) == "black (#000000)"


@pytest.mark.parametrize("claim", [{}, {"count": "tin"}, {"color": "tin", "like": "blurple"}, {"seen": "a", "by": "b"},
                                   {"count": "tin", "equals": 1, "seen": "tin"}, {"touched": "tin"}, {"seen": "tin", "never": True},
                                   {"touched": "tin", "by": "a", "never": True, "lasting": 1},
                                   {"same": "mass"}, {"of": ["tin"]}, {"same": "height", "of": ["tin"]}])  # fmt: skip
def test_what_is_no_fact_goes_back(claim: dict[str, Any]) -> None:
    with pytest.raises(Wrong):
        typed_parser(Claim)(claim)


def test_names_of_facts_are_those_of_the_plan() -> None:
    rows = {"many": [Claim(count="tins", equals=2)], "blue": [Claim(seen="net_rim")]}
    assert claim_faults(rows, ["many"], ["tin", "net"]) == [
        "/facts/blue: there is no requirement `blue`",
        "/facts/many: `tins` is not in `bodies`",
    ]


def test_a_false_fact_cannot_be_marked_away(tmp_path: Path) -> None:
    reply = "seen: It opens.\nverdict: pass\nrequirements: {red: 1, opens: 1}"
    passed, model = judged(tmp_path / "a", reply, facts=(Fact("red", True, "`lid` is red"),))
    assert passed.verdict == "pass"
    assert "  - fact, true: `lid` is red" in model.questions("critic")[0]
    failed, model = judged(tmp_path / "b", reply, facts=(Fact("red", False, "`lid` is blue, wanted red"),))
    assert (failed.verdict, failed.score) == ("repair", 87.5)
    assert failed.failures[0].what == "only half met: the lid is red (`lid` is blue, wanted red)"
    assert len(model.asked) == 1


@pytest.mark.parametrize("sort", FACTS)
def test_every_sort_of_fact_is_told_and_offered(sort: str) -> None:
    assert set(_FACT_FUNCTIONS) == set(FACTS)
    for prompt in ("plan", "open"):
        assert f"{{{sort}: " in (PROMPTS / f"{prompt}.md.j2").read_text("utf-8")
    assert sort in Claim.model_fields
    assert not FACTS[sort] or FACTS[sort] in Claim.model_fields
