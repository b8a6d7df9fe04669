"""New cases: a commented start, or a copy of a case."""

import errno
import re
from pathlib import Path

from text2sim.service.phrases import display_path
from text2sim.spec_schema.errors import RunError
from text2sim.spec_schema.text.source import read_source
from text2sim.spec_schema.whole_files import naming

STARTER = Path(__file__).with_name("starter.yaml")
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,47}\Z")
_NAME_LINE = re.compile(r"^name:[^\n]*$", re.MULTILINE)
_SCHEMA_LINE = re.compile(r"^# yaml-language-server: \$schema=[^\n]*\n", re.MULTILINE)


def make_case(name: str, source: Path | None, cases: Path) -> Path:
    """Write a new case and return its file.

    Args:
        name: Name of the case, and of its folder.
        source: Folder of a case to copy; None for the commented starter.
        cases: The folder for the new case's folder.

    Raises:
        RunError: if the name is invalid or taken.
    """
    from text2sim.harness.folder import staging

    if not _NAME.match(name):
        raise RunError(f"{name!r} is not a name: a letter, then letters, digits or underscores (48 at most)")
    folder = cases / name
    if folder.exists() or folder.is_symlink():
        raise RunError(f"{display_path(folder)} already exists")
    with staging(cases) as stage:
        staged = stage / name
        staged.mkdir()
        text = STARTER.read_text("utf-8") if source is None else _copy(source, staged)
        text = _NAME_LINE.sub(f"name: {name}", text, count=1)
        text = _schema_line(folder) + _SCHEMA_LINE.sub("", text)
        with naming(folder / "case.yaml"):
            (staged / "case.yaml").write_text(text, "utf-8")
        staged.rename(folder)
    return folder / "case.yaml"


def _copy(source: Path, target: Path) -> str:
    """Copy the files of a case, except links, and return its text."""
    import shutil

    text = read_source(source / "case.yaml").text

    def left_out(folder: str, names: list[str]) -> set[str]:
        skipped = {"case.yaml", "program", "runs"} if Path(folder) == source else set[str]()
        return {name for name in names if name in skipped or (Path(folder) / name).is_symlink()}

    try:
        shutil.copytree(source, target, ignore=left_out, dirs_exist_ok=True)
    except shutil.Error as error:
        raise OSError(errno.EIO, error.args[0][0][2]) from error
    return text


def _schema_line(folder: Path) -> str:
    """The line that tells an editor the path of the schema, if a parent folder has it."""
    for above in folder.absolute().parents[:4]:
        for place in ("spec_schema/case.schema.json", "text2sim/spec_schema/case.schema.json"):
            if (above / place).is_file():
                steps = len(folder.absolute().relative_to(above).parts)
                return f"# yaml-language-server: $schema={'../' * steps}{place}\n"
    return ""
