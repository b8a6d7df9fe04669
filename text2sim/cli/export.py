"""The command `text2sim export`."""

from pathlib import Path
from typing import Annotated

import typer

from text2sim.cli.options import AsJson, RunsFolder
from text2sim.cli.output import say, say_json
from text2sim.cli.recorded import run_folder
from text2sim.service.phrases import display_path


def export(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="A run folder, or a case with a run.")],
    usd: Annotated[
        list[Path] | None, typer.Option("--usd", metavar="FILE", help="Write a .usdc, .usda or .usdz file.")
    ] = None,
    gltf: Annotated[list[Path] | None, typer.Option("--gltf", metavar="FILE", help="Write a .glb file.")] = None,
    every: Annotated[int, typer.Option("--every", min=1, help="Only every N-th recorded frame, and the last.")] = 1,
    runs: RunsFolder = Path("runs"),
    as_json: AsJson = False,
) -> None:
    """Export a recorded run for other programs, for rendering or interactive viewing."""
    from text2sim.exchange.gltf import write_gltf
    from text2sim.exchange.usd import write_usd

    wanted = [*((path, write_usd) for path in usd or []), *((path, write_gltf) for path in gltf or [])]
    if not wanted:
        raise typer.BadParameter("name a file to write: --usd FILE, --gltf FILE", param_hint="'--usd'")
    folder = run_folder(run, runs)
    rows = []
    for path, write in wanted:
        counts = write(folder, path, every=every)
        rows.append({"file": str(path), "bytes": path.stat().st_size, **counts})
        if not as_json:
            size = f"{path.stat().st_size / 1e6:.1f} MB"
            say(f"{display_path(path)}: {counts['bodies']} bodies in {counts['frames']} frames, {size}")
    if as_json:
        say_json({"ok": True, "files": rows})
