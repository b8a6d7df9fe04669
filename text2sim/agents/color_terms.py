"""Everyday words for colours: what a request calls red, and what a rendered colour is called."""

from collections.abc import Mapping
from math import dist

from text2sim.spec_schema.models.colors import rgb

COLOR_DISTANCE, COLOR_MARGIN = 0.12, 0.06
"""Distances in Oklab: a colour matches a name within the first, or if no name is nearer by more than the second."""
COLOR_TERMS: Mapping[str, str] = {
    "red": "red crimson firebrick darkred #d62728 #c0392b tomato", "orange": "orange darkorange #e69f00 #d55e00 coral",
    "yellow": "yellow gold khaki mustard #f0e442", "pink": "pink hotpink deeppink #cc79a7",
    "green": "green lime limegreen forestgreen darkgreen seagreen olivedrab lightgreen emerald #009e73 turquoise",
    "blue": "blue navy royalblue dodgerblue steelblue skyblue lightblue #0072b2 #2a6fdb turquoise",
    "purple": "purple indigo rebeccapurple mediumpurple darkviolet orchid violet",
    "brown": "saddlebrown sienna chocolate walnut oak rust brown wood terracotta",
    "black": "black #1c1c1e #2b2b2d charcoal", "white": "white whitesmoke snow ivory marble",
    "grey": "grey silver dimgrey lightgrey steel", "gray": "grey silver dimgrey lightgrey steel",
}  # fmt: skip
"""Colours that an everyday colour word stands for."""


def matches_color(color: tuple[float, ...], word: str) -> bool:
    """Whether a colour (sRGB, 0 to 1) matches a name: it is near it, or the name is its nearest everyday word."""
    from text2sim.compiler.looks import oklab

    here = oklab(color)
    if dist(here, oklab(rgb(word))) < COLOR_DISTANCE:
        return True
    near = _color_distances(color)
    mine = near.get(word.lower())
    return mine is not None and mine <= min(near.values()) + COLOR_MARGIN


def color_name(color: tuple[float, ...]) -> str:
    """Return a colour's everyday name and its hex code."""
    near = _color_distances(color)
    digits = "".join(f"{round(255 * part):02x}" for part in color[:3])
    return f"{min(near, key=lambda term: near[term])} (#{digits})"


def _color_distances(color: tuple[float, ...]) -> dict[str, float]:
    """Distance of a colour to each everyday colour word."""
    from text2sim.compiler.looks import oklab

    here = oklab(color)
    return {term: min(dist(here, oklab(rgb(one))) for one in words.split()) for term, words in COLOR_TERMS.items()}
