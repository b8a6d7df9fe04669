"""Commands that run the trials that were not run yet, and make a table of the docs of all."""

import argparse
from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import Any

from benchmarks.softlab.documents import engine, keep, known, paste
from benchmarks.softlab.lab import Lab


def tabulate(
    words: str | None, name: str, marker: str, trials: Sequence[tuple[Any, ...]], measure: Callable[..., Any],
    row: type[Any], table: Callable[[list[Any]], str], page: str = "soft.md",
) -> None:  # fmt: skip
    """Run what is wanted and print the table.

    Args:
        words: Help of the command.
        name: Of the file of results.
        marker: Of the table in the docs.
        trials: Arguments of `measure`, after the lab.
        measure: Runs one trial and returns a `row`, a dataclass.
        row: Its type.
        table: Makes Markdown of rows.
        page: Which page of the docs it is for.
    """
    parser = argparse.ArgumentParser(description=words, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--all", action="store_true", help="run all again")
    parser.add_argument("--docs", action="store_true", help=f"put the table into docs/{page}")
    options = parser.parse_args()
    results = {} if options.all else known(name)
    with Lab() as lab:
        for trial in trials:
            if (key := " ".join(map(str, trial))) not in results:
                results[key] = asdict(measure(lab, *trial))
                keep(name, results)
    rows = [row(**results[key]) for trial in trials if (key := " ".join(map(str, trial))) in results]
    text = f"{table(rows)}\n\nMeasured with {engine()}."
    print(text)
    if options.docs:
        paste(page, marker, text)
