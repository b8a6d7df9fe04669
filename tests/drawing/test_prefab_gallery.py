"""Page and pictures of the built-in prefabs: complete and up to date."""

from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from freshness import assert_fresh
from PIL import Image

from text2sim.compiler.build import resolve_case
from text2sim.drawing import gallery
from text2sim.drawing.stage import stage
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.reuse.catalogue import built_in, example_case, examples, param_rows

DOCS = Path(gallery.__file__).resolve().parents[2] / "docs"
NAMES = tuple(built_in())


def test_the_page_is_fresh():
    assert_fresh(DOCS / "prefabs.md", gallery.page(), gallery.COMMAND)


def test_the_page_has_every_parameter():
    text = gallery.page()
    for name, definition in built_in().items():
        section = text.partition(f"\n## {name}\n")[2].partition("\n## ")[0]
        for row in param_rows(definition):
            assert f"| `{row.name}` | {row.takes} |" in section


@pytest.mark.parametrize("name", NAMES)
def test_its_picture_is_fresh_and_small(name: str):
    content = (DOCS / "prefabs" / f"{name}.png").read_bytes()
    assert gallery.digest_of(content) == gallery.digest(name), f"write it: {gallery.COMMAND}"
    assert len(content) <= gallery.MAX_PICTURE_SIZE
    assert Image.open(BytesIO(content)).size == gallery.SIZE


def test_no_picture_is_left_over():
    assert {path.stem for path in (DOCS / "prefabs").iterdir()} == set(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_its_picture_shows_something(name: str):
    pixels = np.asarray(Image.open(DOCS / "prefabs" / f"{name}.png").convert("RGB"), float)
    differs = np.abs(pixels - pixels[:4, :4].mean(axis=(0, 1))).max(axis=2) > 40
    assert 0.015 < differs.mean() < 0.6
    rows, columns = np.flatnonzero(differs.any(axis=1)), np.flatnonzero(differs.any(axis=0))
    # Well framed: nothing is cut off, and it fills most of the picture in one direction.
    assert max(np.ptp(rows) / gallery.SIZE[1], np.ptp(columns) / gallery.SIZE[0]) > 0.7


@pytest.mark.parametrize("name", NAMES)
def test_the_bodies_of_a_prefab_are_drawn(name: str):
    resolution = resolve_case(load_text(example_case(examples()[name])))
    drawn = {prop.name for prop in stage(resolution, 5000) if len(prop.triangles)}
    assert drawn == {copy.name for copies in resolution.placed.values() for copy in copies}


def test_a_picture_is_drawn_anew():
    # What lies in the documentation was made by the same program.
    old = np.asarray(Image.open(DOCS / "prefabs" / "fork.png").convert("RGB"), float)
    new = np.asarray(Image.open(BytesIO(gallery.picture("fork"))).convert("RGB"), float)
    assert np.abs(new - old).mean() < 4
