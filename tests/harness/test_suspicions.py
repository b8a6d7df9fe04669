"""What looks wrong in a run with bodies that deform."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from text2sim.evidence.suspicions import suspicions


def recording(path: list[float], solver: str = "mpm") -> Any:
    """A body that deforms, in a space of 1 m, and a ball that goes along x."""
    soft = SimpleNamespace(body="gel[1]", solver=solver, spacing=0.01, domain=((-1.0, -1, -1), (1.0, 1, 1)))
    places = np.zeros((len(path), 1, 3))
    places[:, 0, 0] = path
    states = SimpleNamespace(deformables=[soft], frames=len(path), pos=places, time=0.1 * np.arange(len(path)))
    names = SimpleNamespace(loose=[SimpleNamespace(soft=None, copy="ball", root=0)], touches_soft=lambda name: True)
    return SimpleNamespace(states=states, names=names)


def row(**values: Any) -> dict[str, Any]:
    found: dict[str, Any] = {"kind": "soft", "solver": "mpm", "every": 1}
    return {
        "gel": found | {key: {"value": v, "at": 0.25, "copy": "gel[1]", "in": "plate"} for key, v in values.items()}
    }


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"volume": 0.3}, "0.3 times the volume"),
        ({"inverted": 0.2}, "20 % of its tetrahedra"),
        ({"penetration": 0.03}, "30 mm deep in `plate`"),
        ({"torn": 0.3}, "is torn (up to 30 % of it were off the largest piece)"),
        ({"against_bounds": 0.05}, "5 % of its points at the walls of the space of mpm"),
    ],
)
def test_what_is_wrong_is_said_of_a_copy_and_a_time(values: dict[str, float], said: str) -> None:
    (words,) = suspicions(recording([0.0, 0.5]), row(**values))
    assert said in words
    assert words.startswith("`gel[1]`")
    assert words.endswith("at 0.25 s")


def test_an_ordinary_run_is_not_suspicious() -> None:
    usual = row(volume=0.85, inverted=0.0, penetration=0.02, against_bounds=0.001, stretch=2.0)
    assert suspicions(recording([0.0, 0.5]), usual) == []
    assert suspicions(recording([3.0, 3.5]), {}) == [], "what never was in the grid did not leave it"


def test_a_rigid_body_that_leaves_the_grid_is_named() -> None:
    (words,) = suspicions(recording([0.0, 0.9, 1.1]), {})
    assert words == "`ball` leaves the grid of mpm, and touches nothing in it any more, at 0.2 s"
