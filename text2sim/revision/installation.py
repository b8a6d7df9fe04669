"""Setting git up, so that it shows and merges cases by meaning."""

import os
import shlex
import shutil
import sys
from pathlib import Path

import text2sim
from text2sim.revision.repository import run_git, run_git_status
from text2sim.spec_schema.errors import RunError
from text2sim.spec_schema.whole_files import write_atomically

LINES = tuple(f"{pattern} diff=text2sim merge=text2sim" for pattern in ("case.yaml", "**/prefabs/*.yaml"))
"""Of `.gitattributes`: cases, and the prefabs beside them."""
CONFLICT = 10
"""Exit code of a merge with conflicts: no other failure has it."""
_SECTIONS = ("diff.text2sim", "merge.text2sim")


def settings(command: str) -> dict[str, str]:
    """Return the keys and values of git's configuration."""
    return {
        # If it does not even start, say because its environment is gone, git shows what it would without it.
        "diff.text2sim.command": f'show() {{ {command} git diff "$@" || test $# -lt 7 || '
        'git --no-pager diff --no-index --no-ext-diff --no-textconv "$2" "$5"; true; }; show',
        "diff.text2sim.textconv": f'show() {{ {command} git textconv "$1" || cat "$1"; }}; show',
        "merge.text2sim.name": "text2sim: a merge of meaning",
        # If it does not even start, git must not take our version for the merge of both.
        "merge.text2sim.driver": f"{command} git merge %O %A %B %P %L; code=$?; "
        f"test $code -eq 0 && exit 0; test $code -eq {CONFLICT} && exit 1; git merge-file --marker-size=%L %A %O %B",
    }


def own_command() -> str:
    """Return how a shell calls this text2sim from anywhere."""
    beside = Path(sys.executable).parent / "text2sim"
    script = str(beside) if beside.is_file() else shutil.which("text2sim")
    if script is not None:
        return shlex.quote(os.path.abspath(script))
    # Not installed. With -P a repository that has a folder `text2sim` of its own does not get in between.
    home = Path(text2sim.__file__).resolve().parents[1]
    return f"PYTHONPATH={shlex.quote(str(home))} {shlex.quote(sys.executable)} -P -m text2sim"


def install(folder: Path, *, everywhere: bool = False) -> tuple[Path, bool]:
    """Set git up in the repository of a folder, or for all repositories of this user.

    Returns:
        The file of attributes, and whether it was changed.

    Raises:
        RunError: If the folder is in no repository, or git cannot be set up.
    """
    file = _attributes(folder, everywhere)
    for key, value in settings(own_command()).items():
        run_git(["config", _scope(everywhere), key, value], folder)
    rows = _rows(file)
    missing = [line for line in LINES if line not in rows]
    if not missing:
        return file, False
    file.parent.mkdir(parents=True, exist_ok=True)
    _write(file, [*rows, *missing])
    return file, True


def uninstall(folder: Path, *, everywhere: bool = False) -> tuple[Path, bool]:
    """Undo `install`; see there."""
    file = _attributes(folder, everywhere)
    for section in _SECTIONS:
        # It is no error if there is none.
        run_git_status(["config", _scope(everywhere), "--remove-section", section], folder)
    rows = _rows(file)
    rest = [row for row in rows if row not in LINES]
    if rest == rows:
        return file, False
    if rest or file.is_symlink():
        _write(file, rest)
    else:
        file.unlink()
    return file, True


def _scope(everywhere: bool) -> str:
    return "--global" if everywhere else "--local"


def _attributes(folder: Path, everywhere: bool) -> Path:
    if not everywhere:
        try:
            root = run_git(["rev-parse", "--show-toplevel"], folder).decode().rstrip("\n")
        except RunError as error:
            raise RunError(f"{folder.absolute()} is in no git repository ({error})") from None
        file = Path(root) / ".gitattributes"
        if file.is_symlink():
            raise RunError(f"{file}: a symbolic link, which git does not follow, and neither do we")
        return file
    answer, code = run_git_status(["config", "--global", "--type=path", "--get", "core.attributesFile"], folder)
    if code == 0 and answer.strip():
        return Path(answer.decode().rstrip("\n"))
    home = os.environ.get("XDG_CONFIG_HOME")
    return (Path(home) if home else Path.home() / ".config") / "git" / "attributes"


def _rows(file: Path) -> list[str]:
    try:
        return file.read_text("utf-8", "surrogateescape").splitlines()
    except FileNotFoundError:
        return []


def _write(file: Path, rows: list[str]) -> None:
    # A link of the user's own configuration stays one.
    write_atomically(file.resolve(), "".join(f"{row}\n" for row in rows).encode("utf-8", "surrogateescape"))
