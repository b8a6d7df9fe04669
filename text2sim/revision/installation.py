"""Configuration of git, so that it compares and merges cases by meaning."""

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
"""Lines of `.gitattributes` for cases and the prefabs beside them."""
CONFLICT = 10
"""Exit code of a merge with conflicts; no other failure uses it."""
_SECTIONS = ("diff.text2sim", "merge.text2sim")


def settings(command: str) -> dict[str, str]:
    """Return the keys and values of git's configuration.

    The commands fall back to git's own behaviour if text2sim does not start, for example because its environment is
    gone. Git must then not take our version for the merge of both.
    """
    return {
        "diff.text2sim.command": f'show() {{ {command} git diff "$@" || test $# -lt 7 || '
        'git --no-pager diff --no-index --no-ext-diff --no-textconv "$2" "$5"; true; }; show',
        "diff.text2sim.textconv": f'show() {{ {command} git textconv "$1" || cat "$1"; }}; show',
        "merge.text2sim.name": "text2sim: a merge of meaning",
        "merge.text2sim.driver": f"{command} git merge %O %A %B %P %L; code=$?; "
        f"test $code -eq 0 && exit 0; test $code -eq {CONFLICT} && exit 1; git merge-file --marker-size=%L %A %O %B",
    }


def own_command() -> str:
    """Return the shell command that runs this text2sim from any folder."""
    beside = Path(sys.executable).parent / "text2sim"
    script = str(beside) if beside.is_file() else shutil.which("text2sim")
    if script is not None:
        return shlex.quote(os.path.abspath(script))
    # Not installed. Without -P, a folder `text2sim` in the user's repository would be imported instead.
    home = Path(text2sim.__file__).resolve().parents[1]
    return f"PYTHONPATH={shlex.quote(str(home))} {shlex.quote(sys.executable)} -P -m text2sim"


def install(folder: Path, *, everywhere: bool = False) -> tuple[Path, bool]:
    """Configure git in the repository of a folder, or for all repositories of this user.

    Returns:
        The attributes file, and whether it was changed.

    Raises:
        RunError: If the folder is not in a repository, or git cannot be configured.
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
    """Undo `install`, with the same arguments and results."""
    file = _attributes(folder, everywhere)
    for section in _SECTIONS:
        # The exit code is ignored, because the section may be absent.
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
            raise RunError(f"{folder.absolute()} is not in a git repository ({error})") from None
        file = Path(root) / ".gitattributes"
        if file.is_symlink():
            raise RunError(f"{file}: is a symbolic link, which neither git nor text2sim follows")
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
    # Users may keep their configuration behind a symbolic link.
    write_atomically(file.resolve(), "".join(f"{row}\n" for row in rows).encode("utf-8", "surrogateescape"))
