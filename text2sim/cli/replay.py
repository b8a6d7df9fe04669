"""The command `text2sim replay`."""

from pathlib import Path
from typing import Annotated

import typer

from text2sim.cli.options import AsJson, RunsFolder
from text2sim.cli.output import say, say_json
from text2sim.cli.recorded import run_folder
from text2sim.recording.record import RunRecord
from text2sim.service.phrases import display_path
from text2sim.spec_schema.errors import RunError


def replay(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="A run folder, or a case with a run.")],
    runs: RunsFolder = Path("runs"),
    as_json: AsJson = False,
) -> None:
    """Write the page that shows a run in 3D.

    `text2sim run` writes it, too, unless there are too many states.
    """
    from text2sim.recording.inventory import first_fault
    from text2sim.replay.page import write_replay
    from text2sim.spec_schema.load import load_case

    run = run_folder(run, runs)
    case = run / "expanded.yaml"
    if not case.is_file():
        raise RunError(f"{run} is not a run folder: it has no expanded.yaml")
    record = RunRecord.read_whole(run)
    if record is not None and (damage := first_fault(run, record.judged)):
        raise RunError(f"{run}: {damage}; run the case again")
    path = write_replay(run, load_case(case).case)
    if as_json:
        say_json({"ok": True, "file": str(path), "bytes": path.stat().st_size})
    else:
        say(f"replay: {display_path(path)}, {path.stat().st_size / 1e6:.1f} MB")
