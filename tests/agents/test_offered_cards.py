"""Cards are offered by what failed, not by words that happen to be shared."""

from typing import Any

from text2sim.agents.offered_cards import OfferedCards, failure_signatures
from text2sim.agents.replies import Fragments
from text2sim.card_library.library import load_library


def emit(event: str, /, *, live: bool = False, **what: Any) -> None:
    """Nobody listens."""


CHECKS = Fragments(
    measures={"sag": {"kind": "extent", "of": "net", "axis": "z", "stat": "min"}, "n": {"kind": "count_in", "of": "doll"}},
    events={"lands": {"kind": "contact", "between": ["doll", "net"]}},
    expect={
        "lands": {"event": "lands", "within": [0, 1]}, "deep": {"measure": "sag", "below": 0.5, "at": "end"},
        "all": {"measure": "n", "above": 4, "at": "end"},
    },
)  # fmt: skip


def test_how_a_failure_shows_follows_from_what_was_missed() -> None:
    missed = {name: {"ok": False, "why": "never happened" if name == "lands" else "3 at 2 s"} for name in CHECKS.expect}
    found = failure_signatures(CHECKS, missed, "`doll` leaves the picture at 0.8 s")
    assert {"event never happens", "count too small", "height too large", "leaves-picture"} <= found
    assert failure_signatures(CHECKS, {name: {"ok": True} for name in CHECKS.expect}, "") == set()


def test_cards_about_other_things_are_not_offered() -> None:
    cards = OfferedCards(load_library(), emit)
    text = "The net turns the wrong way up and the dolls roll backwards off it; its sign of curvature is wrong."
    offered = cards.offer(text, ["rope", "rigid", "articulated"], {"finished"}, "dolls fall into a net")
    assert "wheels-turn-backwards" not in offered
    wheels = cards.offer(
        "the cart drives backwards: its wheels turn the wrong way", ["articulated"], set(), "a cart on wheels"
    )
    assert "wheels-turn-backwards" in wheels
    assert "ends-before-it-happens" in cards.offer("it is late", ["rigid"], {"event never happens"}, "a ball")
