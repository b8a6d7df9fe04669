"""The command `text2sim schema`."""

from pathlib import Path
from typing import Annotated

import typer

from text2sim.cli.output import say
from text2sim.service.phrases import display_path
from text2sim.spec_schema.errors import RunError
from text2sim.spec_schema.whole_files import write_atomically


def schema(
    out: Annotated[Path | None, typer.Option("-o", "--out", help="File to write; printed if left out.")] = None,
) -> None:
    """Print the JSON Schema of the language, for editors and for models."""
    from text2sim.spec_schema.published.json_schema import schema_text

    text = schema_text()
    if out is None:
        print(text, end="")
        return
    if out.is_dir() or not out.absolute().parent.is_dir():
        raise RunError(f"{display_path(out)}: {'is a folder' if out.is_dir() else 'there is no such folder'}")
    write_atomically(out, text)
    say(display_path(out))
