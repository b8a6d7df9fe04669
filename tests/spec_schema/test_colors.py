"""Colours by name, by number, and by mistake."""

import pytest

from text2sim.spec_schema.models.colors import NAMED, ColorError, rgb


def test_the_ways_to_say_a_colour():
    assert rgb("red") == rgb("#ff0000") == rgb("#f00") == (1.0, 0.0, 0.0)
    assert rgb("Light Blue") == rgb("light_blue") == rgb("lightblue")
    assert rgb((0.1, 0.2, 0.3)) == (0.1, 0.2, 0.3)


def test_every_name_has_a_colour():
    assert len(NAMED) > 180
    assert all(0 <= channel <= 1 for name in NAMED for channel in rgb(name))


@pytest.mark.parametrize("word", ["terracota", "#12345", "#gggggg", "", "rgb(1, 2, 3)"])
def test_other_words_are_none(word):
    with pytest.raises(ColorError):
        rgb(word)


def test_the_nearest_colour_is_named():
    assert ColorError("terracota").hint == "terracotta"
