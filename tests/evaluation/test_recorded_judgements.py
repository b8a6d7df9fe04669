"""Recorded judgements, scored again from their replies: they give the table of docs/evaluation_results.md."""

import json
from pathlib import Path
from statistics import mean

import pytest

from tests.evaluation.recorded_scores import total as scored
from text2sim.card_library.library import load_library
from text2sim.evaluation.ledger import digest_of, read_ledger
from text2sim.evaluation.statistics import estimate
from text2sim.evaluation.suite import read_suite

HERE = Path(__file__).parent
RECORDED = json.loads((HERE / "recorded" / "judgements.json").read_text("utf-8"))
ROWS, NO_FILM = RECORDED["rows"], RECORDED["no_film"]
PAGE = (HERE.parents[1] / "docs" / "evaluation_results.md").read_text("utf-8")
PROMPTS = read_suite(Path("demonstrations"))[0].prompts
METHODS = ("text2sim-with-cards", "agent-no-cards")


def total(row):
    return scored(row, PROMPTS)


@pytest.mark.parametrize("prompt", sorted({row["prompt"] for row in ROWS}))
def test_kept_replies_give_the_table(prompt):
    cells = []
    for method in METHODS:
        for kind in ("physical", "visual"):
            marks = [
                total(row) for row in ROWS if (row["prompt"], row["method"], row["kind"]) == (prompt, method, kind)
            ]
            if kind == "visual" and [prompt, method] in NO_FILM:
                assert not marks, "nobody is asked about a film that does not exist"
                marks = [0.0]
            else:
                assert len(marks) == 3, "three judges"
            cells.append(f"{mean(marks):.1f}")
    line = next(line for line in PAGE.splitlines() if line.startswith(f"| `{prompt}` |"))
    assert [cell.strip() for cell in line.split("|")[2:6]] == cells


def test_the_arch_was_judged_once_more():
    again = [row for row in ROWS if row["method"] == "text2sim-again"]
    means = [mean(total(row) for row in again if row["kind"] == kind) for kind in ("physical", "visual")]
    assert len(again) == 6 and f"{means[0]:.1f} and {means[1]:.1f} by the same judges" in PAGE


@pytest.mark.parametrize("prompt", sorted({row["prompt"] for row in RECORDED["cards"]}))
def test_kept_replies_give_the_table_with_and_without_cards(prompt):
    cells = []
    for method in ("text2sim-with-cards", "text2sim-no-cards"):
        for kind in ("physical", "visual"):
            of = (prompt, method, kind)
            marks = [total(row) for row in RECORDED["cards"] if (row["prompt"], row["method"], row["kind"]) == of]
            assert len(marks) >= 2
            cells.append(f"{mean(marks):.1f}")
    assert f"| `{prompt}`, once more | {' | '.join(cells)} |" in PAGE


def test_films_were_drawn_and_judged_once_more():
    for prompt in ("bread_torn", "buoyant_blocks", "gel_between_rollers", "snowball_wall"):
        rows = [row for row in RECORDED["refilmed"] if row["prompt"] == prompt]
        cells = [f"{mean(total(row) for row in rows if row['kind'] == kind):.1f}" for kind in ("physical", "visual")]
        assert len(rows) == 6 and f"| `{prompt}`, drawn again | {' | '.join(cells)} |" in PAGE


ARMS = ("text2sim-with-cards", "text2sim-no-cards", "agent-no-cards")
KINDS = ("physical", "visual")
IN_THREE_ARMS = sorted({row["prompt"] for row in RECORDED["arms"]})


def score(prompt, method, kind):
    of = (prompt, method, kind)
    marks = [total(row) for row in RECORDED["arms"] if (row["prompt"], row["method"], row["kind"]) == of]
    no_film = [prompt, method] in NO_FILM
    assert len(marks) == (0 if no_film and kind == "visual" else 3)
    # Without a film, the program gives no marks for it and at most 20 for the physics.
    return mean(marks) if not no_film else min(20.0, mean(marks)) if marks else 0.0


@pytest.mark.parametrize("prompt", IN_THREE_ARMS)
def test_kept_replies_give_the_table_of_three_arms(prompt):
    cells = [score(prompt, method, kind) for method in ARMS for kind in KINDS]
    assert f"| `{prompt}` | {' | '.join(f'{cell:.1f}' for cell in cells)} |" in PAGE


def test_three_arms_have_the_means_and_differences_of_the_page():
    """Paired by prompt, with the bootstrap intervals of the report."""
    scores = {kind: {p: [score(p, method, kind) for method in ARMS] for p in IN_THREE_ARMS} for kind in KINDS}
    means = [mean(row[k] for row in scores[kind].values()) for k in range(3) for kind in KINDS]
    assert f"| mean | {' | '.join(f'{cell:.1f}' for cell in means)} |" in PAGE
    rows = (
        ("with cards − without |", 0, 1),
        ("second series | 9 |", 0, 2),
        ("without cards − bare agent |", 1, 2),
    )
    for label, one, other in rows:
        found = [estimate([row[one] - row[other] for row in scores[kind].values()]) for kind in KINDS]
        cells = [f"{x.mean:+.1f} [{x.low:+.1f}, {x.high:+.1f}]".replace("-", "−") for x in found]
        assert f"| {label} {' | '.join(cells)} |" in PAGE


SIX = (
    "cloth_over_sphere_spin", "rings_on_poles", "sand_column_collapse", "skirt_twirl", "sumo_bellies", "walking_toy",
)  # fmt: skip

FOUR = ("gel_between_rollers", "paper_strip_snap", "sheets_into_groove", "snowball_wall")

SEVEN = ("cantilever_bars", "cord_plectoneme", "foam_pie_slide", "mat_twist")

THREE = ("dam_break_posts", "sleeve_pushed_up", "tofu_wires")

FIVE = ("bread_torn", "buoyant_blocks", "hat_onto_rack", "ribbon_knot", "tablecloths_compared")


def mark(prompt, method, kind):
    if prompt in IN_THREE_ARMS:
        return score(prompt, method, kind)
    marks = [total(row) for row in ROWS if (row["prompt"], row["method"], row["kind"]) == (prompt, method, kind)]
    return mean(marks) if marks else 0.0


def test_differences_over_parts_and_all_prompts_are_those_of_the_page():
    everything = sorted({row["prompt"] for row in ROWS} | {*IN_THREE_ARMS})
    filmed = [prompt for prompt in everything if [prompt, METHODS[1]] not in NO_FILM]
    assert (len(everything), len(filmed)) == (42, 40)
    eleven = [prompt for prompt in everything if prompt not in (*IN_THREE_ARMS, *SIX, *FIVE, *THREE, *FOUR, *SEVEN)]
    for prompts, label in (
        (eleven, "first series | 11"),
        (SIX, "third series | 6"),
        (FIVE, "fourth series | 5"),
        (THREE, "fifth series | 3"),
        (FOUR, "sixth series | 4"),
        (SEVEN, "seventh series | 4"),
        (everything, "all | 42"),
        (filmed, "all for which the agent had a film | 40"),
    ):
        found = [estimate([mark(p, METHODS[0], k) - mark(p, METHODS[1], k) for p in prompts]) for k in KINDS]
        cells = [f"{x.mean:+.1f} [{x.low:+.1f}, {x.high:+.1f}]".replace("-", "−") for x in found]
        assert f"| {label} | {' | '.join(cells)} |" in PAGE
    for prompts, name in ((SIX, "six"), (FIVE, "five"), (THREE, "three"), (FOUR, "four"), (SEVEN, "last")):
        means = [mean(mark(p, method, k) for p in prompts) for method in METHODS for k in KINDS]
        assert f"| mean of the {name} | {' | '.join(f'{cell:.1f}' for cell in means)} |" in PAGE
    ahead = [sum(mark(p, METHODS[0], k) > mark(p, METHODS[1], k) for p in everything) for k in KINDS]
    assert f"in {ahead[0]} and {ahead[1]} of {len(everything)}" in PAGE


def test_three_prompts_were_answered_once_more_after_what_they_lacked_was_built():
    for prompt in THREE:
        rows = [row for row in RECORDED["later"] if row["prompt"] == prompt]
        cells = [f"{mean(total(row) for row in rows if row['kind'] == kind):.1f}" for kind in KINDS]
        assert len(rows) == 6 and f"| `{prompt}`, once more | {' | '.join(cells)} |" in PAGE


def test_learned_cards_are_those_of_the_page():
    folder = HERE / "recorded" / "learned"
    entries = load_library([folder]).entries
    for name, card in read_ledger(folder).cards.items():
        (tried,) = card.tried
        assert card.digest == digest_of(entries[name])
        assert card.state == "kept" and tried.dealt
        assert f"| `{name}` | {tried.before:.1f} | {tried.after:.1f} | {card.gain:+.1f} |" in PAGE
