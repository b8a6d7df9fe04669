"""The commands `text2sim dataset`: datasets of films, what happens in them, and questions about it."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from text2sim.service import exits

if TYPE_CHECKING:
    from text2sim.dataset.build import Tally
    from text2sim.dataset.simulate import Made

dataset = typer.Typer(
    help="Datasets of films, of what happens in them, and of questions about it.",
    no_args_is_help=True,
    context_settings={"help_option_names": ["-h", "--help"]},
)
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON document.")]
Folder = Annotated[Path, typer.Argument(metavar="DATASET", help="Folder of a dataset.")]


@dataset.command("build")
def build_dataset(
    recipe: Annotated[Path, typer.Argument(metavar="RECIPE", help="What to build, in YAML.")],
    out: Annotated[Path, typer.Option("--out", "-o", help="The dataset's folder, which must not be there.")],
    runs: Annotated[Path, typer.Option("--runs", help="Folder in which each run has its own.")] = Path("runs"),
    workers: Annotated[int, typer.Option("--workers", min=1, max=64, help="Draws that are made at a time.")] = 1,
    as_json: AsJson = False,
) -> None:
    """Draw, check, simulate, film, annotate and write a dataset.

    What lies in the runs folder already is not simulated again.
    """
    _require()
    from text2sim.cli.output import say, say_json
    from text2sim.dataset.build import build
    from text2sim.dataset.recipe import read_recipe
    from text2sim.service.wording import shown

    def tell(tally: "Tally", made: "Made") -> None:
        if not as_json:
            keys = ", ".join(item.key for item in made.items) or "nothing"
            say(f"[{tally.done}/{tally.jobs}] {keys}" + (f"; {len(made.refused)} refused" if made.refused else ""))

    wanted = read_recipe(recipe)
    tally = build(wanted, recipe.parent, out, runs, workers=workers, tell=tell)
    if as_json:
        say_json({"ok": True, "folder": str(out), "items": tally.items, "refused": tally.refused})
    else:
        counts = ", ".join(f"{count} {split}" for split, count in tally.items.items())
        say(f"{tally.items.total()} items ({counts}), {tally.refused.total()} refused: {shown(out)}")
    raise typer.Exit(exits.OK)


def _require() -> None:
    """Refuse to begin without the extra.

    Raises:
        MachineError: if it is not installed.
    """
    from importlib.util import find_spec

    from text2sim.spec_schema.errors import MachineError

    if find_spec("pyarrow") is None:
        raise MachineError("datasets need the extra `data`: pip install 'text2sim[data]'")
