"""Entries that stand for several: parts, links, measures, events and expectations with `repeat`."""

import pytest
from small_case import problems_of

from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.names.references import check_references
from text2sim.spec_schema.reuse.overlay import CaseOverlay

WHEEL = """\
text2sim: 2
name: wheel
prompt: A wheel with spokes rolls.
params: {spokes: 6, bins: 3}
scene: {duration: 1.0, statics: {floor: {shape: {kind: plane}}}}
bodies:
  wheel:
    kind: rigid
    shape:
      kind: compound
      parts:
        rim: {shape: {kind: torus, radius: 0.3, bar_radius: 0.02}}
        spoke:
          repeat: ${spokes}
          shape: {kind: capsule, radius: 0.01, length: 0.26}
          pose: {pos: ["${0.1 * k}", 0, 0]}
    repeat: {kind: line, count: 2, step: ["${spokes}", 0, 0]}
  blind:
    kind: articulated
    links:
      slat:
        repeat: 4
        parent: "slat_${k - 1}"
        shape: {kind: box, size: [0.4, 0.02, "${0.1 + 0.01 * k}"]}
        joint: {kind: hinge, axis: x}
actions:
  measures:
    bin:
      repeat: ${bins}
      kind: count_in
      of: wheel
      region: {kind: box, min: ["${k - spokes}", -1, 0], max: [9, 1, 1]}
  expect:
    fills: {repeat: "${bins}", measure: "bin_${k}", at: end, above: "${0.5 * k}"}
  controls:
    shove: {repeat: 2, kind: impulse, body: "wheel[${k}]", impulse: [1, 0, 0], at: "${0.1 * k}"}
"""


def load(old="", new="", **overlay):
    assert old in WHEEL
    return load_text(WHEEL.replace(old, new), overlay=CaseOverlay(**overlay))


def test_each_gets_its_number():
    case = load().case
    parts = case.bodies["wheel"].shape.parts
    assert list(parts) == ["rim", *(f"spoke_{k}" for k in range(6))]
    assert parts["spoke_4"].pose.pos == (0.4, 0.0, 0.0)
    assert parts["spoke_4"].repeat is None
    assert list(case.actions.measures) == ["bin_0", "bin_1", "bin_2"]
    shoves = [(name, row.body, row.at) for name, row in case.actions.controls.items()]
    assert shoves == [("shove_0", "wheel[0]", 0.0), ("shove_1", "wheel[1]", 0.1)]
    assert case.actions.measures["bin_2"].region.min == (-4.0, -1.0, 0.0)
    assert [(e.measure, e.above) for e in case.actions.expect.values()] == [("bin_0", 0), ("bin_1", 0.5), ("bin_2", 1)]
    assert check_references(load()) == []


def test_colours_in_a_list_are_taken_in_turn():
    new = "joint: {kind: hinge, axis: x}\n        look: {color: [red, teal, cream]}"
    links = load("joint: {kind: hinge, axis: x}", new).case.bodies["blind"].links
    assert [link.look.color for link in links.values()] == ["red", "teal", "cream", "red"]


def test_links_hang_on_the_one_before_and_the_first_is_the_root():
    links = load().case.bodies["blind"].links
    assert [link.parent for link in links.values()] == [None, "slat_0", "slat_1", "slat_2"]
    assert [link.joint is None for link in links.values()] == [True, False, False, False]
    assert [link.shape.size[2] for link in links.values()] == pytest.approx([0.1, 0.11, 0.12, 0.13])


def test_copies_of_the_body_and_numbers_of_its_parts_are_two_things():
    loaded = load('"${0.1 * k}", 0, 0', '0, "${10 * i + k}", 0')
    second = loaded.body_copy("wheel", {"i": 1, "n": 2})
    assert second.shape.parts["spoke_3"].pose.pos[1] == 13.0


def test_the_number_of_entries_can_be_set():
    case = load(sets=("params.spokes=2", "actions.measures.bin.repeat=5")).case
    assert list(case.bodies["wheel"].shape.parts) == ["rim", "spoke_0", "spoke_1"]
    assert len(case.actions.measures) == 5


@pytest.mark.parametrize(
    ("old", "new", "line", "said"),
    [
        ("0.1 + 0.01 * k", "k - 2", 24, "must be greater than 0 (got -2) (`slat`, number 0)"),
        ("repeat: ${spokes}", "repeat: 0", 14, "from 1 to 500 (got 0)"),
        ("repeat: ${spokes}", "repeat: ${spike}", 14, "unknown name `spike`"),
        ("repeat: ${spokes}", "repeat: 5.5", 14, "a whole number"),
        ("rim:", "spoke_3:", 13, "`spoke_3` already exists"),
        ("{spokes: 6, bins: 3}", "{spokes: 6, bins: 3, k: 1}", 4, "choose another name"),
        ("rim: {", "rim: true\n        hub: {", 12, "needs a mapping (got true)"),
        ("measures:\n", "measures:\n    fast: speed\n", 28, "needs a mapping with a kind"),
        ('at: end, above: "${0.5 * k}"', 'at: end, above: "${q}"', 34, "unknown name `q`"),
    ],
)
def test_what_is_wrong_is_said_of_the_line(old, new, line, said):
    problems = problems_of(WHEEL.replace(old, new))
    first = next(problem for problem in problems if said in problem.message)
    assert first.line == line
    if "q" in said:  # the same of every number is said once
        assert len(problems) == 1
    # Nothing else is found wrong: what cannot be counted is judged as if there were one.
    assert {problem.line for problem in problems} <= {line}
