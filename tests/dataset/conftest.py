"""Items and datasets of hand-written runs."""

from pathlib import Path
from typing import Any

import pytest
from crates import CASE, RECIPE, Take, write_run

from text2sim.dataset.build import Writer
from text2sim.dataset.curation import refusals
from text2sim.dataset.item import Item, make_item
from text2sim.dataset.recipe import Recipe, parse_recipe
from text2sim.dataset.simulate import DrawResult
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.text.source import Source


@pytest.fixture
def recipe() -> Recipe:
    return parse_recipe(Source(RECIPE, "recipe.yaml"))


@pytest.fixture
def take(tmp_path: Path, recipe: Recipe) -> Take:
    """Make an item: name of its case, its source, speed of the crate, further columns."""

    def take(key: str, source: str = "one", speed: float = 1.0, case: str = "", **row: Any) -> Item:
        case = case or f"case_{source}"
        run = write_run(tmp_path / key / case, speed, **row.pop("evidence", {}))
        loaded = load_text(CASE.format(name=case), tmp_path / "case.yaml")
        item = make_item(key, run, None, loaded, recipe, tmp_path / "items" / key)
        assert refusals(item, recipe.limits) == row.pop("refused", [])
        item.glance = [[number % 256 for number in key.encode()]] if row.pop("other_look", False) else item.glance
        item.row |= {
            "source": source,
            "variant": "",
            "draw": 0,
            "drawn": [],
            "same_physics_as": None,
            "doubtful": False,
        }
        item.row |= row
        return item

    return take


@pytest.fixture
def dataset(tmp_path: Path, recipe: Recipe, take: Take) -> Path:
    """A dataset of three items: two of a simulation, one of another source."""
    from text2sim.dataset.card import write_card

    folder = tmp_path / "dataset"
    writer = Writer(recipe, folder, {"one": "train", "two": "test"})
    writer.add(DrawResult([take("a"), take("a-film1", same_physics_as="a", other_look=True)], []))
    writer.add(DrawResult([take("b", "two", 1.5)], [{"key": "b", "stage": "check", "why": ["overlap"], "drawn": []}]))
    writer.close()
    write_card(folder, recipe, writer.tally.tables)
    return folder
