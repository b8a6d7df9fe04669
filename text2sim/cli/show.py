"""The command `text2sim show`."""

import os
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from text2sim.cli.options import AsJson, Sets, Variants, overlay_of
from text2sim.cli.output import say, say_json
from text2sim.service.phrases import display_path
from text2sim.spec_schema.errors import Text2SimError, did_you_mean
from text2sim.spec_schema.whole_files import write_atomically

if TYPE_CHECKING:
    from text2sim.compiler.build import Resolution
    from text2sim.compiler.explicit import Explicit
    from text2sim.service.examined import Examined
    from text2sim.spec_schema.reuse.overlay import CaseOverlay


def show(
    case: Annotated[Path, typer.Argument(help="A case folder or case.yaml file.")],
    variants: Variants = None,
    sets: Sets = None,
    png: Annotated[
        Path | None, typer.Option("--png", help="File of the picture; runs/NAME-layout.png if left out.")
    ] = None,
    no_png: Annotated[bool, typer.Option("--no-png", help="Draw nothing.")] = False,
    body: Annotated[str, typer.Option("--body", metavar="NAME", help="Print only this body or static.")] = "",
    open_it: Annotated[bool, typer.Option("--open", help="Show the picture on the screen.")] = False,
    as_json: AsJson = False,
) -> None:
    """Print a case with all defaults and derived values, and draw its start."""
    from text2sim.cli.cases import say_examined
    from text2sim.compiler.explicit import explicit
    from text2sim.drawing.layout import layout
    from text2sim.service.examined import examine

    # Pictures are drawn in threads, with which those of the matrix library would compete.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    overlay = overlay_of(variants, sets)
    # Without the lint: a picture may help to fix what it finds.
    row = examine(case, to="resolved", overlay=overlay)
    resolution = row.resolution
    if resolution is None:
        say_examined(row) if not as_json else say_json(row.as_dict())
        raise typer.Exit(row.exit)
    found = explicit(resolution)
    if body:
        known = [*found.data["scene"].get("statics", {}), *found.data["bodies"]]
        if body not in known:
            raise typer.BadParameter(f"there is no body or static `{body}`{did_you_mean(body, known)}")
        found = found.only(body)
    target = png if png is not None else Path("runs") / f"{resolution.plan.case}-layout.png"
    if not no_png:
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            write_atomically(target, layout(resolution, _title(overlay)))
        except (Text2SimError, OSError) as error:
            row.blame(error)
    _print(row, resolution, found, None if no_png or not row.ok else target, overlay, as_json)
    if open_it and not no_png and row.ok:
        _open_file(target)
    raise typer.Exit(row.exit)


def _title(overlay: "CaseOverlay") -> str:
    """Description of the overlay."""
    names = [f"variant {' + '.join(overlay.variants)}"] if overlay.variants else []
    return ", ".join([*names, *overlay.sets])


def _print(
    row: "Examined",
    resolution: "Resolution",
    found: "Explicit",
    picture: Path | None,
    overlay: "CaseOverlay",
    as_json: bool,
) -> None:
    from text2sim.cli.cases import say_examined

    if as_json:
        document: dict[str, Any] = {
            "overlay": {"variants": list(overlay.variants), "set": list(overlay.sets)},
            "resolved": found.data,
            "comments": {"/" + "/".join(map(str, path)): text for path, text in found.comments.items()},
            "digest": resolution.plan.sim_digest,
            "png": None if picture is None else str(picture),
        }
        say_json(row.as_dict() | document)
        return
    over = f" with {_title(overlay)}" if overlay else ""
    say(found.text([f"# {display_path(row.path)}{over}, with nothing left out."]).removesuffix("\n"))
    say_examined(row)
    if picture is not None:
        say(display_path(picture), to=sys.stderr)


def _open_file(picture: Path) -> None:
    """Ask the desktop to show a file."""
    import webbrowser

    command = {"darwin": ["open"], "win32": ["cmd", "/c", "start", ""]}.get(sys.platform, ["xdg-open"])
    try:
        subprocess.Popen([*command, str(picture)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    except OSError:
        webbrowser.open(picture.absolute().as_uri())
