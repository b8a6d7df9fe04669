"""The commands `text2sim git`: cases in a git repository."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from text2sim.cli.diff import report_lines, say_line
from text2sim.cli.output import say
from text2sim.service import exits
from text2sim.service.phrases import display_path
from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.plain import plain
from text2sim.spec_schema.text.source import read_source
from text2sim.spec_schema.whole_files import write_atomically

git = typer.Typer(
    help="Let git show and merge cases by meaning.",
    no_args_is_help=True,
)
_Global = Annotated[bool, typer.Option("--global", help="For all repositories of this user, not only the current one.")]
_Name = Annotated[str, typer.Argument()]
_File = Annotated[Path, typer.Argument()]


@git.command("install")
def install(everywhere: _Global = False) -> None:
    """Set up a repository: `git diff` shows changes of meaning, and edits of different values merge cleanly."""
    from text2sim.revision.installation import LINES, install, settings

    file, changed = install(Path.cwd(), everywhere=everywhere)
    for row in LINES if changed else ("unchanged",):
        say(f"{display_path(file)}: {row}")
    say(f"git config: {', '.join(settings(''))}")


@git.command("uninstall")
def uninstall(everywhere: _Global = False) -> None:
    """Undo what `install` did."""
    from text2sim.revision.installation import uninstall

    file, changed = uninstall(Path.cwd(), everywhere=everywhere)
    say(f"{display_path(file)}: {'without text2sim' if changed else 'unchanged'}")


@git.command("diff", hidden=True)
def diff(name: _Name, files: Annotated[list[str] | None, typer.Argument()] = None) -> None:
    """Command that git calls as `diff.text2sim.command`: PATH OLD HEX MODE NEW HEX MODE."""
    from text2sim.cli.failure import fail
    from text2sim.revision.driver import text_difference

    try:
        lines = _difference(name, files or [])
    except Exception as error:
        # git would stop and skip all other files.
        fail(error, as_json=False)
        lines = text_difference(Path(files[0]), Path(files[3]), name) if files else []
    for line in lines:
        say_line(line)


@git.command("textconv", hidden=True)
def textconv(file: _File) -> None:
    """Command that git calls as `diff.text2sim.textconv`."""
    from text2sim.cli.failure import fail
    from text2sim.revision.driver import flat_text

    try:
        text = flat_text(read_source(file))
    except Exception as error:
        if not isinstance(error, SpecError):
            fail(error, as_json=False)
        text = file.read_bytes().decode("utf-8", "replace")
    print(plain(text), end="")


@git.command("merge", hidden=True)
def merge(base: _File, ours: _File, theirs: _File, name: _Name, marker: Annotated[int, typer.Argument()] = 7) -> None:
    """Command that git calls as `merge.text2sim.driver`: %O %A %B %P %L. The result goes to the second file."""
    from text2sim.revision.installation import CONFLICT
    from text2sim.revision.merging import merge_files

    result = merge_files(base, ours, theirs, name, max(1, min(marker, 100)))
    write_atomically(ours, result.text)
    for remark in result.remarks:
        say(f"{name}: {remark}", to=sys.stderr)
    raise typer.Exit(exits.OK if result.clean else CONFLICT)


def _difference(name: str, files: list[str]) -> list[str]:
    from text2sim.revision.compare import compare
    from text2sim.revision.driver import driver_side, text_difference
    from text2sim.spec_schema.load import CASE_FILE

    if len(files) < 6:
        return [f"{name}: not merged yet"]
    old, new = Path(files[0]), Path(files[3])
    title = f"{name} → {files[6]}" if len(files) > 6 else name
    thing = "case" if Path(name).name == CASE_FILE else "prefab"
    if "/dev/null" in (files[0], files[3]):
        return [title, f"  a new {thing}" if files[0] == "/dev/null" else f"  the {thing} was deleted"]
    one, other = driver_side(old, name, f"a/{name}"), driver_side(new, name, f"b/{name}")
    if one is None or other is None:
        return text_difference(old, new, name)
    found = compare(one, other)
    if found.same:
        return [f"{title}: the meaning is the same", *text_difference(old, new, name)]
    return [title, *(f"  {f'{thing}:' if line == 'case:' else line}" for line in report_lines(found))]
