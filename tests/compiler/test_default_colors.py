"""Colours of bodies that were given none."""

from text2sim.compiler.default_colors import PALETTE, default_colors
from text2sim.spec_schema.load import load_text

BALL = "{kind: rigid, shape: {kind: sphere, radius: 0.1}"


def colors_of(bodies: str) -> dict[str, str]:
    text = f"text2sim: 2\nname: colours\nscene: {{duration: 1}}\nbodies: {{{bodies}}}"
    return default_colors(load_text(text).case)


def test_bodies_differ_while_colours_last() -> None:
    names = ("ball", "pin", "dough", "stamp", "llab", "nip", "abll")
    colors = colors_of(", ".join(f"{name}: {BALL}}}" for name in names))
    assert sorted(colors.values()) == sorted(PALETTE)
    more = colors_of(", ".join(f"{name}: {BALL}}}" for name in (*names, "labl")))
    assert more == colors | {"labl": more["labl"]}, "one more body changes no other"


def test_a_colour_that_the_case_gives_takes_none() -> None:
    same = colors_of(f"ball: {BALL}, look: {{color: red}}}}, llab: {BALL}}}")
    assert same["llab"] == colors_of(f"llab: {BALL}}}")["llab"]


def test_material_comes_before_the_name() -> None:
    sand = "{kind: granular, shape: {kind: box, size: [0.1, 0.1, 0.1]}}"
    colors = colors_of(f"a: {sand}, b: {sand}, c: {BALL}}}")
    assert colors["a"] == colors["b"] != colors["c"]
