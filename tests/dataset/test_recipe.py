"""Recipes: located problems, and draws that depend only on their seed."""

from pathlib import Path

import numpy as np
import pytest

from text2sim.dataset.draws import draw, generator, overlay_of
from text2sim.dataset.recipe import Draw, ItemLimits, parse_recipe
from text2sim.spec_schema.errors import RunError, SpecError
from text2sim.spec_schema.text.source import Source


def problems(body: str) -> str:
    with pytest.raises(SpecError) as caught:
        parse_recipe(Source(f"text2sim_dataset: 1\nname: x\nsources:\n  a:\n    cases: [c]\n{body}", "r.yaml"))
    return str(caught.value)


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("    physics: {params.speed: {unifrom: [1, 2]}}\n", "r.yaml:6:30: error: "),
        ("    physics: {params.speed: {uniform: [1, 2], choice: [3]}}\n", "has one of the keys uniform"),
        ("    physics: {params.speed: {integer: [3, 1]}}\n", "must not be smaller than the first"),
        ("    physics: {bodies.ball.look.color: {choice: [red]}}\n", "changes the film: draw it under `looks`"),
        ("    physics: {render.lights.sun.strength: {choice: [2]}}\n", "changes the film: draw it under `lights`"),
        ("    physics: {render.fps: {choice: [12]}}\n", "changes the film, and cannot be drawn"),
        (
            "    looks: {params.speed: {uniform: [1, 2]}}\n",
            "r.yaml:6:13: error: `params.speed` does not belong to looks",
        ),
        ("    cameras: {render.lights.sun.strength: {uniform: [1, 2]}}\n", "begins with render.cameras"),
        ("    physics: {bodies..density: {uniform: [1, 2]}}\n", "a path has the form"),
        ("    films: 3\n", "need draws in `looks`, `lights` or `cameras`"),
        ("    plain: false\n", "the source needs `variants` or a `sweep`"),
        ("    counterfactuals: {two: {params.a: {choice: [1]}, params.b: {choice: [1]}}}\n", "r.yaml:6:"),
        ("    annotations: [depth]\n", "annotations"),
        ("annotations: [dept]\n", "did you mean `depth`?"),
        ("film: {size: [15, 20]}\n", "r.yaml:6:"),
        ("film: {size: [127, 72]}\n", "r.yaml:6:15: error: needs an even number from 16 to 4096 (got 127)"),
        ("film: {size: [128, 5000]}\n", "must be from 16 to 4096 (got 5000)"),
        ("film: {size: [128]}\n", "needs 2 even numbers from 16 to 4096"),
        ("splits: {train: 0.5, test: 0.9}\n", "r.yaml:6:9: error: the shares must add up to at most 1 (got 1.4)"),
        (
            "splits: {tset: 0.5}\n",
            "r.yaml:6:10: error: unknown key `tset`; `splits` takes train, validation, test; did you mean `test`?",
        ),
    ],
)
def test_problems_are_located(body: str, said: str) -> None:
    assert said in problems(body)


def test_draws_follow_their_distributions_and_their_seed() -> None:
    case = {"params": {"speed": 4.0}, "bodies": {"ball": {"pose": {"pos": [0, 0, 2]}}}}
    table = {
        "params.a": Draw(uniform=(2, 3)),
        "params.b": Draw(log_uniform=(1, 100)),
        "params.c": Draw(integer=(1, 3)),
        "params.d": Draw(choice=["red", None]),
        "params.speed": Draw(times=(0.5, 1.5)),
        "/bodies/ball/pose/pos/2": Draw(plus=(1, 2)),
        "params.e": Draw(normal=(5, 0.5)),
    }
    rows = [draw(table, generator(7, "key", k), case) for k in range(400)]
    assert rows[3] == draw(table, generator(7, "key", 3), case) != rows[4]
    columns = {name: [row[name] for row in rows] for name in rows[0]}
    assert np.mean(columns["params.a"]) == pytest.approx(2.5, abs=0.05)
    assert np.median(columns["params.b"]) == pytest.approx(10, rel=0.35)
    assert {*columns["params.c"]} == {1, 2, 3} and {*columns["params.d"]} == {"red", None}
    assert np.mean(columns["params.speed"]) == pytest.approx(4, rel=0.05)
    assert 3 <= min(columns["bodies.ball.pose.pos[2]"]) < max(columns["bodies.ball.pose.pos[2]"]) <= 4
    assert np.std(columns["params.e"]) == pytest.approx(0.5, rel=0.1)
    assert overlay_of({"params.d": "red", "params.c": 2}).sets == ('params.d="red"', "params.c=2")
    with pytest.raises(RunError, match="need a number"):
        draw({"bodies.ball": Draw(times=(1, 2))}, generator(1), case)


def test_the_page_lists_all_limits_with_their_defaults() -> None:
    page = (Path(__file__).parents[2] / "docs/dataset.md").read_text()
    assert all(f"\n| `{name}` | {value:g} |" in page for name, value in ItemLimits())
