"""Positions and velocities at the start, at events and at the end, as the Critic and the Planner are told them."""

from collections.abc import Callable
from typing import Any

import numpy as np

from text2sim.agents.tracks import tracks_text
from text2sim.spec_schema.models.events import ContactEvent


def test_bodies_that_move_are_told_where_they_are_at_each_event(
    new_run: Callable[..., Any], make_case: Callable[..., Any]
) -> None:
    run = new_run()
    t = run.time
    run.add_link("ball", pos=np.outer(t, [2.0, 0, 0]) + (0, 0, 0.1), vel=np.tile([2.0, 0, 0], (len(t), 1)))
    run.add_link("post")
    folder = run.write()
    events = {"late": {"first": 0.5}, "hit": {"first": 0.25}, "never": {"first": None}}
    told = tracks_text(folder, make_case(("ball", "post")), events)
    assert told.splitlines()[-1] == (
        "- `ball`: start (0, 0, 0.1) v (2, 0, 0); hit (0.5, 0, 0.1) v (2, 0, 0); "
        f"late (1, 0, 0.1) v (2, 0, 0); end ({2 * t[-1]:g}, 0, 0.1) v (2, 0, 0)"
    )
    assert "post" not in told, "it never moves"


def test_of_a_contact_that_never_happened_the_nearest_moment_is_listed(
    new_run: Callable[..., Any], make_case: Callable[..., Any]
) -> None:
    run = new_run()
    t = run.time
    x = np.minimum(2.0 * t, 0.5)
    run.add_link("ball", pos=np.stack([x, 0 * t, 0 * t + 0.4], axis=1))
    run.add_link("post", pos=np.tile([0.5, 0, 0.1], (len(t), 1)))
    events = {"hit": ContactEvent(kind="contact", between=("ball", "post"))}
    told = tracks_text(run.write(), make_case(("ball", "post"), events=events), {"hit": {"first": None}})
    nearest = "were nearest at 0.25 s: 0.3 m between centres, at (0.5, 0, 0.4) and (0.5, 0, 0.1)"
    assert f"- `hit` never happened; `ball` and `post` {nearest}" in told
