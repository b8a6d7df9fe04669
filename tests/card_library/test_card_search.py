"""Order of the cards that are found."""

from typing import Any

import pytest

from text2sim.card_library.library import BUILT_IN, load_library
from text2sim.card_library.retrieval import find_cards, index_words

LIBRARY = load_library([BUILT_IN])


def ids(**query: Any) -> list[str]:
    return [match.entry.id for match in find_cards(LIBRARY, **query)]


@pytest.mark.parametrize(
    ("text", "first"),
    [
        ("the cannon ball passes through the thin plate although it is pushed against it", "force-makes-it-tunnel"),
        ("Newton's cradle: the balls move on together after the blow", "collisions-without-restitution"),
        ("the ball rolls on for ever and never comes to rest", "no-rolling-resistance"),
        ("the gripper closes but the brick slips out of its jaws when it is lifted", "grip-slips"),
        ("the rope hangs in the air instead of falling to the floor", "rope-hangs-in-the-air"),
        ("dominoes stop falling after the first one", "dominoes-too-far-apart"),
        ("the chain explodes", "chain-without-damping-explodes"),
    ],
)
def test_a_failure_in_words_finds_its_card(text: str, first: str) -> None:
    assert first in ids(text=text)[:2]


def test_only_cards_for_the_role() -> None:
    found = find_cards(LIBRARY, text="the ball is thrown and the camera sees nothing", role="render", limit=100)
    assert found
    assert all("render" in match.entry.card.applies.roles for match in found)


def test_signatures_count_more_than_words() -> None:
    assert (
        ids(text="the ball rolls on a ramp and falls", signatures=["diverged"])[0] == "chain-without-damping-explodes"
    )
    (first, *_) = find_cards(LIBRARY, text="", signatures=["lint:undamped-joints"])
    assert first.entry.id == "chain-without-damping-explodes"
    assert first.signatures == ("undamped-joints",)


def test_modes_bring_cards_forward() -> None:
    text = "it is stiff and stands up like a board"
    places = [ids(text=text, modes=modes, limit=100).index("cloth-like-card") for modes in ((), ("cloth",))]
    assert places[1] < places[0] or places == [0, 0]
    assert "cloth-like-card" in ids(text="", modes=["cloth"], limit=100)


def test_nothing_fits_nothing() -> None:
    assert ids(text="") == []
    assert ids(text="zyzzyva quux") == []
    assert ids(text="the ball", limit=0) == []


def test_order_is_the_same_each_time_and_limited() -> None:
    query = {"text": "the body falls through the floor, " * 400, "limit": 4}
    assert ids(**query) == ids(**query)
    assert len(ids(**query)) == 4
    scores = [match.score for match in find_cards(LIBRARY, text="ball on a ramp", limit=100)]
    assert scores == sorted(scores, reverse=True)


def test_forms_of_a_word_meet() -> None:
    assert index_words("Tunnels, tunnelled; the tunnelling") == ["tunnel"] * 3
    assert index_words("slips slipping slipped") == ["slip"] * 3
    assert index_words("gas is a") == ["gas"]
