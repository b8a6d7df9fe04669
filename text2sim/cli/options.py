"""Options that several commands share."""

from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from text2sim.spec_schema.reuse.overlay import Overlay

Variants = Annotated[
    list[str] | None,
    typer.Option("--variant", metavar="NAME", help="Lay this variant over the case; several in their order."),
]
Sets = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="PATH=VALUE", help="Set a value, as in bodies.ball.material.density=500."),
]


def overlay_of(variants: list[str] | None, sets: list[str] | None) -> "Overlay":
    """Overlay of a case that `--variant` and `--set` define."""
    from text2sim.spec_schema.reuse.overlay import Overlay

    return Overlay(tuple(variants or ()), tuple(sets or ()))
