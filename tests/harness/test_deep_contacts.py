"""Contacts that are deeper than a wall: the recording says so, asked or not."""

from typing import Any

import pytest

from text2sim.evidence.deep_contacts import DeepContact, deepest_contact
from text2sim.evidence.recorded_case import RecordedCase


def said(new_run: Any, make_case: Any, *touches: tuple[str, str, int, float]) -> DeepContact | None:
    """What is said of touches of a floor, a bin 20 mm thick, and a mug with a wall of 4 mm: pair, step, depth [m]."""
    run = new_run()
    links = {name: run.add_link(name, fixed=name != "mug") for name in ("floor", "bin", "mug")}
    run.add_box(links["bin"], [0.2, 0.2, 0.01])
    run.add_box(links["mug"], [0.04, 0.04, 0.01])
    run.add_box(links["mug"], [0.002, 0.04, 0.05])
    for a, b, step, depth in touches:
        run.touch(links[a], links[b], [step], [0, 0, 1], depth=depth)
    plane, box = {"shape": {"kind": "plane"}}, {"shape": {"kind": "box", "size": [0.4, 0.4, 0.02]}}
    case = make_case(bodies=("mug",), statics=("floor", "bin"), scene={"statics": {"floor": plane, "bin": box}})
    return deepest_contact(RecordedCase.load(run.write(), case))


@pytest.mark.parametrize(
    ("touches", "words"),
    [
        ([], None),
        ([("bin", "mug", 50, 0.0039)], None),
        (
            [("bin", "mug", 40, 0.0041), ("bin", "mug", 50, 0.0079)],
            "`bin` and `mug` overlap by 7.9 mm at 0.5 s, and their thinnest part is 4 mm thick: use more substeps "
            "(scene.substeps; 4 times as many for an impact) or thicker walls",
        ),
        ([("floor", "mug", 50, 0.005)], "`floor` and `mug` overlap by 5 mm at 0.5 s"),  # a plane has no thickness
        ([("bin", "mug", 1, 0.0079), ("bin", "mug", 50, 0.0079)], None),  # placed so: what the lint tells
    ],
)
def test_an_overlap_deeper_than_a_wall_is_told(
    new_run: Any, make_case: Any, touches: list[tuple[str, str, int, float]], words: str | None
) -> None:
    found = said(new_run, make_case, *touches)
    assert (found is not None) == (words is not None)
    assert found is None or found.message.startswith(words or "")
