"""New cases: a commented start, or a copy of a case."""

import errno
import re
from pathlib import Path

from text2sim.service.phrases import shown

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,47}\Z")
_NAME_LINE = re.compile(r"^name:[^\n]*$", re.MULTILINE)
_SCHEMA_LINE = re.compile(r"^# yaml-language-server: \$schema=[^\n]*\n", re.MULTILINE)


def make_case(name: str, source: Path | None, cases: Path) -> Path:
    """Write a new case and return its file.

    Args:
        name: Of the case, and of its folder.
        source: Folder of the case to copy; the commented start if left out.
        cases: The folder to put it in.

    Raises:
        RunError: if the name is none, or taken.
    """
    from text2sim.harness.folder import staging
    from text2sim.spec_schema.errors import RunError
    from text2sim.spec_schema.whole_files import naming

    if not _NAME.match(name):
        raise RunError(f"{name!r} is not a name: a letter, then letters, digits or underscores (48 at most)")
    folder = cases / name
    if folder.exists() or folder.is_symlink():
        raise RunError(f"{shown(folder)} is there already")
    with staging(cases) as stage:
        staged = stage / name
        staged.mkdir()
        text = _starter() if source is None else _copy(source, staged)
        text = _NAME_LINE.sub(f"name: {name}", text, count=1)
        text = _schema_line(folder) + _SCHEMA_LINE.sub("", text)
        with naming(folder / "case.yaml"):
            (staged / "case.yaml").write_text(text, "utf-8")
        staged.rename(folder)
    return folder / "case.yaml"


def _starter() -> str:
    return (Path(__file__).parent / "starter.yaml").read_text("utf-8")


def _copy(source: Path, target: Path) -> str:
    """Copy what belongs to a case, never what a link points at, and return its text."""
    import shutil

    from text2sim.spec_schema.text.source import read_source

    text = read_source(source / "case.yaml").text

    def left_out(folder: str, names: list[str]) -> set[str]:
        at_top = Path(folder) == source
        return {
            name
            for name in names
            if (Path(folder) / name).is_symlink() or (at_top and name in ("case.yaml", "program", "runs"))
        }

    try:
        shutil.copytree(source, target, ignore=left_out, dirs_exist_ok=True)
    except shutil.Error as error:
        raise OSError(errno.EIO, error.args[0][0][2]) from error
    return text


def _schema_line(folder: Path) -> str:
    """The line that tells an editor where the schema is, if it lies somewhere above the new case."""
    for above in (folder.absolute().parents)[:4]:
        for place in ("spec_schema/case.schema.json", "text2sim/spec_schema/case.schema.json"):
            if (above / place).is_file():
                steps = len(folder.absolute().relative_to(above).parts)
                return f"# yaml-language-server: $schema={'../' * steps}{place}\n"
    return ""
