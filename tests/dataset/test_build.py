"""A dataset that is really built: drawn, refused, simulated, filmed, and loaded."""

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pyarrow.parquet as pq
import pytest
from crates import CASE as CRATE
from crates import Take

from text2sim.cluster.run import Placement
from text2sim.cluster.task import STOPPED
from text2sim.dataset import simulate
from text2sim.dataset.annotations import Annotator, Seen
from text2sim.dataset.build import Tally, build, jobs_of
from text2sim.dataset.check import check_dataset
from text2sim.dataset.item import Item, make_item
from text2sim.dataset.recipe import Recipe, parse_recipe
from text2sim.dataset.simulate import DrawResult
from text2sim.runtime.stop import Stop
from text2sim.spec_schema.errors import MachineError, RunError, SpecError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.text.source import Source

CASE = """
text2sim: 2
name: drop
prompt: A ball falls beside a post.
scene: {duration: 0.4, dt: 0.01, statics: {floor: {shape: {kind: plane}}}}
bodies:
  ball:
    kind: rigid
    shape: {kind: sphere, radius: 0.1}
    material: {density: 500}
    pose: {pos: [0, 0, 0.4]}
  post:
    kind: rigid
    shape: {kind: box, size: [0.2, 0.2, 0.4]}
    mount: {kind: fixed}
    pose: {pos: [0.5, 0, 0.2]}
actions:
  measures: {height: {kind: position, of: ball, axis: z}}
  events: {lands: {kind: contact, between: [ball, floor]}}
  expect: {lands_in_time: {event: lands, within: [0.1, 0.35]}}
"""
RECIPE = """
text2sim_dataset: 1
name: drops
film: {quality: preview, size: [64, 36], fps: 10}
annotations: [cameras, depth, instances, flow, boxes, visibility]
tries: 20
sources:
  drops:
    cases: [case.yaml]
    draws: 2
    films: 2
    physics:
      bodies.ball.pose.pos[0]: {choice: [0.45, 0.0]}
      bodies.ball.pose.pos[2]: {uniform: [0.3, 1.6]}
    looks: {bodies.ball.look.color: {choice: ["#c23b34", "#2a9d8f"]}}
    counterfactuals: {no_gravity: {scene.gravity: {choice: [[0, 0, 0]]}}}
    holds: [lands_in_time]
"""


@pytest.fixture
def recipe_folder(tmp_path: Path) -> Path:
    (tmp_path / "case.yaml").write_text(CASE)
    return tmp_path


def test_draws_are_made_until_they_fit_and_pairs_are_linked(recipe_folder: Path, engine: None) -> None:
    recipe, told = parse_recipe(Source(RECIPE, "recipe.yaml")), []
    target = recipe_folder / "drops"

    def tell(tally: Tally, made: DrawResult) -> None:
        told.append((tally.done, tally.fresh))

    def complete(folder: Path) -> None:
        (folder / "benchmarks/drop").mkdir(parents=True)
        (folder / "benchmarks/drop/benchmark.json").write_text("{}")

    runs = recipe_folder / "runs"
    tally = build(recipe, recipe_folder, target, runs, where=Placement(), tell=tell, complete=complete)
    assert "for other simulators: `drop`" in (target / "README.md").read_text()
    assert told == [(1, 1), (2, 2)]
    assert check_dataset(target) == []
    items = {row["key"]: row for row in pq.read_table(target / "items").to_pylist()}
    assert [*items] == [
        f"drops-drop-{k:03d}{what}" for k in (0, 1) for what in ("", "-film1", "-no_gravity", "-no_gravity-film1")
    ]
    for k in ("000", "001"):
        base, film, other = (items[f"drops-drop-{k}{what}"] for what in ("", "-film1", "-no_gravity"))
        assert film["same_physics_as"] == base["key"] and film["states_digest"] == base["states_digest"]
        assert film["film_digest"] != base["film_digest"]
        assert other["counterfactual_of"] == base["key"] and other["cause"] == "scene.gravity"
        assert [row["ok"] for row in base["expectations"]] == [True]
        assert [row["ok"] for row in other["expectations"]] == [False]
        heights = {row["path"]: json.loads(row["value"]) for row in base["drawn"]}
        assert heights["bodies.ball.pose.pos[0]"] == 0.0
        # A fall from rest takes sqrt(2 h / g): what lies beyond the time that is expected was drawn again.
        assert (2 * (heights["bodies.ball.pose.pos[2]"] - 0.1) / 9.81) ** 0.5 <= 0.36
    refused = [json.loads(line) for line in (target / "refused.jsonl").read_text().splitlines()]
    stages = {row["stage"] for row in refused}
    assert "check" in stages, "a ball in the post is refused by the check"
    assert tally.refused.total() == len(refused)
    assert all(row["why"] and row["drawn"] for row in refused)


def test_a_recipe_must_fit_its_cases(recipe_folder: Path) -> None:
    recipe = parse_recipe(Source(RECIPE.replace("draws: 2", "variants: [heavy]"), "recipe.yaml"))
    with pytest.raises(SpecError, match="has no variant `heavy`"):
        jobs_of(recipe, recipe_folder, recipe_folder, recipe_folder)


def test_a_dataset_that_is_there_is_not_overwritten(recipe_folder: Path) -> None:
    recipe = parse_recipe(Source(RECIPE, "recipe.yaml"))
    (recipe_folder / "drops").mkdir()
    with pytest.raises(RunError, match="already exists"):
        build(
            recipe,
            recipe_folder,
            recipe_folder / "drops",
            recipe_folder,
            where=Placement(),
            tell=lambda *_: None,
        )


def test_a_warning_that_a_source_refuses_is_drawn_again_without_being_simulated(
    recipe_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The ball is 0.1 m wide and the post begins at 0.4 m: at 0.31 m they overlap by a centimetre."""

    def simulated(loaded: LoadedCase, **_: object) -> SimpleNamespace:
        tried.append(loaded.data["bodies"]["ball"]["pose"]["pos"][0])
        return SimpleNamespace(evidence=None, state="failed", message="no engine here")

    monkeypatch.setattr(simulate, "run_case", simulated)
    text = RECIPE.replace("[0.45, 0.0]", "[0.31, 0.0]").replace("{uniform: [0.3, 1.6]}", "{choice: [0.2]}")
    rows = {}
    for refuse in ("", "    refuse: [overlap]\n"):
        tried: list[float] = []
        recipe, made = parse_recipe(Source(text + refuse, "recipe.yaml")), recipe_folder / f"made{len(rows)}"
        simulate.make(jobs_of(recipe, recipe_folder, recipe_folder, made)[0])
        rows[refuse] = {*tried}, json.loads((made / "drops-drop-000.json").read_text())["refused"]
    (loose, _), (strict, refused) = rows.values()
    assert (loose, strict) == ({0.31, 0.0}, {0.0})
    assert {row["stage"] for row in refused} == {"check", "run"}
    assert all("[overlap]" in row["why"][0] for row in refused if row["stage"] == "check")


def test_a_failure_of_the_machine_is_no_reason_to_draw_again(
    recipe_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def busy(*_: object, **__: object) -> None:
        raise MachineError("drop is being run by another text2sim")

    monkeypatch.setattr(simulate, "run_case", busy)
    job, *_ = jobs_of(parse_recipe(Source(RECIPE, "recipe.yaml")), recipe_folder, recipe_folder, recipe_folder / "made")
    with pytest.raises(MachineError, match="by another"):
        simulate.make(job)
    assert not [*(recipe_folder / "made").iterdir()], "it is done by the next build"


def test_a_stopped_job_films_nothing_and_is_done_by_the_next_build(
    recipe_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stop = Stop()

    def interrupted(*_: object, **__: object) -> SimpleNamespace:
        stop.request()
        return SimpleNamespace(evidence={"verdict": "failed"}, state="interrupted")

    monkeypatch.setattr(simulate, "run_case", interrupted)
    monkeypatch.setattr(simulate, "make_item", lambda *_: pytest.fail("what was stopped is filmed"))
    job, *_ = jobs_of(parse_recipe(Source(RECIPE, "recipe.yaml")), recipe_folder, recipe_folder, recipe_folder / "made")
    with pytest.raises(RunError, match=STOPPED):
        simulate.make(replace(job, stop=stop))
    assert stop.count == 1
    assert not [*(recipe_folder / "made").iterdir()]


def test_an_unfinished_job_of_another_recipe_does_not_count_as_done(
    recipe_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Made, begun again at another size, stopped, and made by the first recipe again."""
    stop, failed = Stop(), SimpleNamespace(evidence=None, state="failed", message="no engine here")
    monkeypatch.setattr(simulate, "run_case", lambda *_, **__: failed)
    made = recipe_folder / "made"
    first, second = (
        jobs_of(parse_recipe(Source(text, "recipe.yaml")), recipe_folder, recipe_folder, made)[0]
        for text in (RECIPE, RECIPE.replace("[64, 36]", "[96, 54]"))
    )
    assert simulate.make(first) and not simulate.make(first)
    stop.request()
    with pytest.raises(RunError, match=STOPPED):
        simulate.make(replace(second, stop=stop))
    assert simulate.make(first)


def test_a_stopped_film_ends_at_its_next_picture_and_is_not_refused(
    recipe_folder: Path, take: Take, recipe: Recipe, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    take("a")
    run, out, stop = tmp_path / "a" / "case_one", tmp_path / "item", Stop()
    show = Annotator.preview

    def one(self: Annotator, seen: Seen) -> Any:
        stop.request()
        return show(self, seen)

    monkeypatch.setattr(Annotator, "preview", one)
    loaded = load_text(CRATE.format(name="case_one"), tmp_path / "case.yaml")
    with pytest.raises(RunError, match=STOPPED):
        make_item("a", run, None, loaded, recipe, out, stop)
    assert stop.count == 1, "no second picture"
    monkeypatch.setattr(simulate, "make_item", lambda *_: make_item("a", run, None, loaded, recipe, out, stop))
    ended = SimpleNamespace(evidence={}, expectations={"lands_in_time": {"ok": True}}, folder=run)
    monkeypatch.setattr(simulate._DrawMaker, "_run", lambda *_: ended)
    job, *_ = jobs_of(parse_recipe(Source(RECIPE, "recipe.yaml")), recipe_folder, recipe_folder, recipe_folder / "made")
    with pytest.raises(RunError, match=STOPPED):
        simulate.make(replace(job, stop=stop))
    assert not [*(recipe_folder / "made").iterdir()]


def test_a_counterfactual_whose_first_film_is_refused_answers_questions(
    recipe_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ended, asked = SimpleNamespace(expectations={"lands_in_time": {"ok": True}}, folder=recipe_folder), []

    def filmed(key: str, *_: object) -> Item:
        row = {"key": key, "prompt": "", "suspicions": [], "energy_gain": None, "penetration": None}
        return Item(key, recipe_folder, row)

    def what_if(base: dict[str, Any], other: dict[str, Any], *_: object) -> list[Any]:
        asked.append((base["key"], other["key"]))
        return []

    monkeypatch.setattr(simulate._DrawMaker, "_run", lambda *_: ended)
    monkeypatch.setattr(simulate, "make_item", filmed)
    monkeypatch.setattr(simulate, "refusals", lambda item, _: ["dull"] if item.key.endswith("no_gravity") else [])
    monkeypatch.setattr(simulate, "candidate_questions", lambda *_: [])
    monkeypatch.setattr(simulate, "what_if", what_if)
    recipe = parse_recipe(Source(RECIPE.replace("[0.45, 0.0]", "[0.0]"), "recipe.yaml"))
    assert simulate.make(jobs_of(recipe, recipe_folder, recipe_folder, recipe_folder / "made")[0])
    other = "drops-drop-000-no_gravity-film1"
    assert asked == [("drops-drop-000", other), ("drops-drop-000-film1", other)]


def test_the_keys_of_a_job_are_those_of_its_items(recipe_folder: Path) -> None:
    job, *_ = jobs_of(parse_recipe(Source(RECIPE, "recipe.yaml")), recipe_folder, recipe_folder, recipe_folder)
    assert job.item_keys == [f"drops-drop-000{what}" for what in ("", "-film1", "-no_gravity", "-no_gravity-film1")]


def test_a_counterfactual_changes_something_and_is_drawn_once(
    recipe_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of the two draws of a density of 300, one is that of the base; a draw of another replaces it in `drawn`."""
    ran, ended = [], SimpleNamespace(expectations={}, folder=recipe_folder)

    def filmed(key: str, *_: object) -> Item:
        row = {"key": key, "prompt": "", "suspicions": [], "energy_gain": None, "penetration": None}
        return Item(key, recipe_folder, row)

    monkeypatch.setattr(simulate._DrawMaker, "_run", lambda _, __, key, *___: ran.append(key) or ended)
    monkeypatch.setattr(simulate, "make_item", filmed)
    monkeypatch.setattr(simulate, "refusals", lambda *_: [])
    monkeypatch.setattr(simulate, "candidate_questions", lambda *_: [])
    monkeypatch.setattr(simulate, "what_if", lambda *_: [])
    text = """
text2sim_dataset: 1
name: drops
sources:
  drops:
    cases: [case.yaml]
    physics: {bodies.ball.material.density: {choice: [300]}}
    counterfactuals:
      same: {bodies.ball.material.density: {choice: [300]}}
      light: {/bodies/ball/material/density: {choice: [100]}}
"""
    job, *_ = jobs_of(parse_recipe(Source(text, "r.yaml")), recipe_folder, recipe_folder, recipe_folder / "made")
    simulate.make(job)
    assert ran == ["drops-drop-000", "drops-drop-000-light"]
    made = simulate.read_made(job)
    assert [row["value"] for row in made.items[1].row["drawn"]] == ["100"]
    assert [(row["key"], row["stage"]) for row in made.refused] == [("drops-drop-000-same", "item")]
    why = "duplicate: bodies.ball.material.density=300 does not change the simulation of drops-drop-000"
    assert made.refused[0]["why"] == [why]
