"""The command `text2sim new`."""

from pathlib import Path
from typing import Annotated

import typer

from text2sim.cli.options import AsJson
from text2sim.cli.output import say, say_json
from text2sim.service.phrases import display_path
from text2sim.spec_schema.errors import RunError


def new(
    name: Annotated[str, typer.Argument(help="Name of the case: a letter, then letters, digits or underscores.")],
    source: Annotated[
        Path | None, typer.Option("--from", help="Copy this case (a folder, or the name of one in --cases).")
    ] = None,
    cases: Annotated[Path, typer.Option("--cases", help="Folder of cases.")] = Path("cases"),
    as_json: AsJson = False,
) -> None:
    """Write a new commented case: a ball that drops on a stack of boxes."""
    from text2sim.service.new_case import make_case

    folder = cases / name
    file = make_case(name, None if source is None else _find(source, cases), cases)
    if as_json:
        say_json({"ok": True, "case": name, "file": str(file)})
        return
    say(display_path(file))
    say(f"next: text2sim run {display_path(folder)}")


def _find(source: Path, cases: Path) -> Path:
    for folder in (source.parent if source.is_file() else source, cases / source):
        if (folder / "case.yaml").is_file():
            return folder
    raise RunError(f"{display_path(source)}: no case.yaml there")
