"""The commands `text2sim dataset`: datasets of films with annotations and questions."""

import sys
from collections import Counter, defaultdict
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Annotated, Any

import typer

from text2sim.cli.benchmark import examined, exported
from text2sim.cli.many import Ray, StoreUrl, Workers, where_of
from text2sim.cli.options import AsJson
from text2sim.cli.output import say, say_json, say_problems
from text2sim.runtime.progress import duration_text
from text2sim.service import exits
from text2sim.service.phrases import display_path
from text2sim.spec_schema.errors import MachineError, RunError

if TYPE_CHECKING:
    from text2sim.cluster.task import Task
    from text2sim.dataset.build import Tally
    from text2sim.dataset.simulate import DrawResult

dataset = typer.Typer(
    help="Datasets of films with annotations and questions.",
    no_args_is_help=True,
)
Folder = Annotated[Path, typer.Argument(metavar="DATASET", help="Folder of a dataset.")]
Decisions = Annotated[
    Path | None,
    typer.Option("--decisions", help="Decisions from the page of `dataset review`; review.yaml, if it is there."),
]


@dataset.command("build")
def build_dataset(
    recipe: Annotated[Path, typer.Argument(metavar="RECIPE", help="The recipe of the dataset, in YAML.")],
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder of the dataset, which must not exist.")],
    runs: Annotated[Path, typer.Option("--runs", help="Folder of run folders.")] = Path("runs"),
    workers: Workers = 1,
    ray: Ray = "",
    store: StoreUrl = "",
    decisions: Decisions = None,
    as_json: AsJson = False,
) -> None:
    """Draw, check, simulate, film, annotate and write a dataset.

    Runs that exist in the runs folder are not simulated again.
    """
    _require()
    from text2sim.cli.cases import say_examined
    from text2sim.cluster.estimate import in_words
    from text2sim.cluster.run import Placement, capacity
    from text2sim.dataset.build import build
    from text2sim.dataset.recipe_fit import read_recipe
    from text2sim.evaluation.judging import scores_of_runs

    def tell(tally: "Tally", result: "DrawResult") -> None:
        if not as_json:
            keys = ", ".join(item.key for item in result.items) or "nothing"
            each = (monotonic() - begun) / tally.fresh if tally.fresh else 0.0
            left = f", {duration_text(each * (tally.jobs - tally.done))} left" if each else ""
            refused = f"; {len(result.refused)} refused" if result.refused else ""
            say(f"[{tally.done}/{tally.jobs}{left}] {keys}{refused}")

    def announce(tasks: "Sequence[Task]") -> None:
        if not as_json:
            say(f"simulations: {in_words(tasks, capacity(where))}")

    def complete(folder: Path) -> None:
        for row, _, scene in exported(*benchmarks, folder / "benchmarks", where, quiet=as_json):
            if scene is None:
                if row.exit == exits.INTERRUPTED:
                    raise KeyboardInterrupt
                say_examined(row)
                raise RunError(f"{row.title} could not be exported; the same command continues with what is left")

    begun = monotonic()
    wanted, warnings = read_recipe(recipe)
    say_problems(warnings, {})
    where = where_of(workers, ray, store, runs) or Placement()
    benchmarks = examined((recipe.parent / path for path in wanted.benchmarks), runs)
    for row in benchmarks[0]:
        if not row.ok:
            say_examined(row)
            raise typer.Exit(row.exit)
    scores: dict[str, list[dict[str, Any]]] = defaultdict(list)
    for path in wanted.judged:
        for digest, given in scores_of_runs(recipe.parent / path).items():
            scores[digest] += given
    callbacks = {"tell": tell, "announce": announce, "complete": complete}
    try:
        tally = build(wanted, recipe.parent, out, runs, where=where, decisions=decisions, scores=scores, **callbacks)
    except KeyboardInterrupt:
        _say_stopped(as_json=as_json)
        raise
    _say_built(tally, out, monotonic() - begun, as_json=as_json)


def _say_stopped(*, as_json: bool) -> None:
    message = "stopped on request; the same command continues with what is left"
    if as_json:
        say_json({"ok": False, "error": message})
    else:
        say(f"text2sim: {message}", to=sys.stderr)


def _say_built(tally: "Tally", folder: Path, took: float, *, as_json: bool) -> None:
    """Print the counts of a dataset, and the time, space and memory that it took."""
    import resource

    size = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)
    if as_json:
        cost = {"seconds": round(took, 1), "bytes": size, "memory": memory}
        say_json({"ok": True, "folder": str(folder), "items": tally.items, "refused": tally.refused, **cost})
        return
    counts = ", ".join(f"{count} {split}" for split, count in tally.items.items())
    say(f"{tally.items.total()} items ({counts}), {tally.refused.total()} refused: {display_path(folder)}")
    spent = f"{duration_text(round(took, 1))}, {size / 1e6:.0f} MB"
    say(f"{spent}; the process that wrote it used {memory / 1e6:.0f} MB of memory")


@dataset.command("check")
def check(folder: Folder, as_json: AsJson = False) -> None:
    """Check that a dataset is consistent and that no source is in two splits."""
    _require()
    from text2sim.dataset.check import check_dataset

    found = check_dataset(folder)
    if as_json:
        say_json({"ok": not found, "problems": found})
    else:
        for words in found or ["consistent, and without leaks"]:
            say(words)
    raise typer.Exit(exits.INPUT if found else exits.OK)


@dataset.command("questions")
def questions(folder: Folder, as_json: AsJson = False) -> None:
    """Count the questions, and report the accuracy of answers without seeing the film."""
    _require()
    from text2sim.dataset.balance import guess_by_words
    from text2sim.dataset.check import want_tables
    from text2sim.dataset.tables import read_rows

    want_tables(folder)
    cases = {row["key"]: row["case"] for _, row in read_rows(folder, "items", ["key", "case"])}
    asked = [*read_rows(folder, "questions")]
    rows = [row for _, row in asked]
    splits, kinds = Counter(split for split, _ in asked), Counter(row["kind"] for row in rows)
    found = guess_by_words(rows, [cases.get(row["key"], "") for row in rows])
    if as_json:
        say_json({"ok": True, "splits": splits, "kinds": kinds, **found})
    else:
        for kind, count in kinds.most_common():
            example = next(row for row in rows if row["kind"] == kind)
            say(f"{count:5} {kind.replace('_', ' ')}: {example['question']} {' / '.join(example['choices'])}")
        say(", ".join(f"{count} {split}" for split, count in splits.items()) or "no questions")
        say(f"correct by chance: {found['by_chance']:.2f}")
        say(f"by words, learned from other cases: {found['by_words']:.2f}")
        say(f"by the most frequent answer to each wording: {found['by_wording']:.2f}")


@dataset.command("review")
def review(
    folder: Folder,
    decisions: Decisions = None,
    everything: Annotated[bool, typer.Option("--all", help="Show all items, not only the doubtful ones.")] = False,
) -> None:
    """Write a page on which doubtful items are reviewed: kept or dropped."""
    _require()
    from text2sim.dataset.review import read_decisions, write_review

    place = folder.absolute()  # it may be `.`
    path = place.with_name(f"{place.name}-review.html")
    count = write_review(place, path, read_decisions(decisions), everything=everything)
    say(f"{count} items: {display_path(path)}")


def _require() -> None:
    """Check that the extra is installed.

    Raises:
        MachineError: if it is not installed.
    """
    if find_spec("pyarrow") is None:
        raise MachineError("datasets need the extra `data`: pip install 'text2sim[data]'")
