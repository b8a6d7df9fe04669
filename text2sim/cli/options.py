"""Options that several commands share."""

from collections.abc import Callable
from dataclasses import fields
from functools import wraps
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from text2sim.spec_schema.reuse.overlay import CaseOverlay

AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON document.")]
RunsFolder = Annotated[Path, typer.Option("--runs", help="Folder of the runs of cases.")]
Variants = Annotated[
    list[str] | None,
    typer.Option("--variant", metavar="NAME", help="Apply this variant to the case; several in order."),
]
Sets = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="PATH=VALUE", help="Set a value, such as bodies.ball.material.density=500."),
]


def overlay_of(variants: list[str] | None, sets: list[str] | None) -> "CaseOverlay":
    """Return the overlay of a case that `--variant` and `--set` define."""
    from text2sim.spec_schema.reuse.overlay import CaseOverlay

    return CaseOverlay(tuple(variants or ()), tuple(sets or ()))


def with_options(group: type, **defaults: Any) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Give a command the fields of a dataclass as options, and pass them as its parameter `options`.

    Args:
        group: The dataclass, whose fields are annotated like parameters of commands. Defaults made by
            `default_factory` are not supported.
        **defaults: Defaults of this command, in place of the dataclass's.
    """

    def wrap(command: Callable[..., None]) -> Callable[..., None]:
        own = [parameter for parameter in signature(command).parameters.values() if parameter.name != "options"]
        shared = [
            Parameter(
                field.name,
                Parameter.KEYWORD_ONLY,
                default=defaults.get(field.name, field.default),
                annotation=field.type,
            )
            for field in fields(group)
        ]

        @wraps(command)
        def call(**given: Any) -> None:
            options = group(**{parameter.name: given.pop(parameter.name) for parameter in shared})
            command(**given, options=options)

        call.__signature__ = Signature([*own, *shared])  # type: ignore[attr-defined]
        call.__annotations__ = {parameter.name: parameter.annotation for parameter in (*own, *shared)}
        return call

    return wrap
