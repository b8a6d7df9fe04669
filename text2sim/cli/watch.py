"""The command `text2sim watch`."""

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from text2sim.cli.options import Sets, Variants, overlay_of
from text2sim.cli.output import expectation_rows, say, say_problems
from text2sim.cli.verdict import MARKS
from text2sim.runtime.stop import Stop
from text2sim.service import exits
from text2sim.service.phrases import display_path
from text2sim.spec_schema.errors import MachineError, Problem, RunError
from text2sim.watching.page_state import PageState

if TYPE_CHECKING:
    from text2sim.service.examined import Examined
    from text2sim.spec_schema.reuse.overlay import CaseOverlay
    from text2sim.watching.live_run import LiveRun
    from text2sim.watching.protocols import Checked


def watch(
    case: Annotated[Path, typer.Argument(help="A case folder, or a case.yaml file.")],
    variants: Variants = None,
    sets: Sets = None,
    port: Annotated[int, typer.Option("--port", min=0, max=65535, help="Port of the page; 0 takes a free one.")] = 0,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page in the browser.")] = True,
    runs: Annotated[Path, typer.Option("--runs", help="Folder for the folder watch-<case>.")] = Path("runs"),
    timeout: Annotated[
        float, typer.Option("--timeout", min=1.0, help="Limit of a simulation's wall time in seconds.")
    ] = 60.0,
    memory: Annotated[
        float, typer.Option("--memory", min=1.0, help="Memory in GB above which the engine is restarted.")
    ] = 3.0,
) -> None:
    """Check a case whenever it is saved, simulate it in a warm engine, and show the simulation in 3D in the browser.

    The page is updated during the simulation. runs/watch-<case> is not a run folder: `text2sim run` makes those.

    Ctrl-C ends it.
    """
    from text2sim.runtime.lock import RunLock
    from text2sim.service.examined import case_file
    from text2sim.watching.server import PageServer
    from text2sim.watching.session import Options, WatchSession

    path = case_file(case)
    if not path.is_file():
        raise RunError(f"{display_path(path)}: there is no such case")
    overlay = overlay_of(variants, sets)
    name = "-".join(["watch", _folder_name(path), *overlay.variants])
    folder = (runs / name).absolute()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RunError(f"{display_path(folder)}: cannot write there: {error.strerror}") from error
    with RunLock(runs, name), Stop() as stop, stop.gently():
        state = PageState(
            case=path.parent.name,
            file=" ".join([display_path(path), *overlay.words]),
            words="starting",
            tone="busy",
            mark="…",
        )
        try:
            server = PageServer(state, port)
        except OSError as error:
            raise RunError(f"the page cannot listen on port {port}: {error.strerror}") from error
        try:
            say(f"watching {display_path(path)}; Ctrl-C ends it")
            say(f"page: {server.url}")
            sys.stdout.flush()
            options = Options(timeout=timeout, memory=int(memory * 1e9))
            session = WatchSession(path, folder, lambda: _examine(path, overlay), state, _Terminal(), options)
            if browser:
                _open_page(server.url)
            session.run(lambda: stop.count)
        finally:
            server.close()
    raise typer.Exit(exits.INTERRUPTED)


def _examine(path: Path, overlay: "CaseOverlay") -> "Examined":
    """Read a case, and check that this machine can run it."""
    from text2sim.runtime.machine_check import check_ability
    from text2sim.service.examined import examine

    found = examine(path, overlay=overlay)
    if found.ok and found.loaded is not None:
        try:
            check_ability(found.loaded)
        except MachineError as error:
            found.blame(error)
    return found


class _Terminal:
    """Prints a line or two for each event."""

    def __init__(self) -> None:
        self._warnings: object = None

    def checked(self, case: "Checked", seconds: float) -> None:
        if case.failure:
            say(f"{case.name}: {case.failure}", to=sys.stderr)
        # Known warnings are not repeated at every save.
        if not case.ok or case.problems != self._warnings:
            say_problems(case.problems, case.sources)
        self._warnings = case.problems if case.ok else None
        count = len(case.problems)
        what = "ok" if case.ok else "not run"
        more = f", {count} {'warning' if case.ok else 'problem'}{'s' if count > 1 else ''}" if count else ""
        say(f"{case.name}: {what}{more} ({seconds:.2f} s)")
        sys.stdout.flush()

    def status(self, words: str) -> None:
        self._say(words)

    def trouble(self, words: str, problem: Problem | None) -> None:
        self._say(str(problem) if problem is not None else words, to=sys.stderr)

    def done(self, live_run: "LiveRun", evidence: dict[str, Any] | None, no_scene: str) -> None:
        from text2sim.watching.page_text import timing

        rows = expectation_rows((evidence or {}).get("expect", {}))
        for ok, name, words in rows:
            if ok is not True:
                self._say(f"  {MARKS[ok]:<4}  {name}  {words}")
        score = f", {sum(ok is True for ok, _, _ in rows)} of {len(rows)} expectations came true" if rows else ""
        none = f"; nothing to show: {no_scene}" if no_scene else ""
        self._say(f"{timing(live_run)}; {live_run.state.replace('_', ' ')}{score}{none}")

    def _say(self, words: str, to: Any = None) -> None:
        say(words, to=to)
        sys.stdout.flush()


def _folder_name(path: Path) -> str:
    """Name of the case's folder, or of its file, with characters that all file systems allow."""
    name = path.absolute().parent.name if path.name == "case.yaml" else path.stem
    return "".join(c if c.isascii() and (c.isalnum() or c in "_-") else "_" for c in name)[:60] or "case"


def _open_page(url: str) -> None:
    """Open a page in a browser with a window; one in the terminal would interfere with the output."""
    import webbrowser

    if sys.platform in ("darwin", "win32") or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
        webbrowser.open(url)
