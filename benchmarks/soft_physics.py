"""Bodies that deform, against equations: a table of what was measured beside what theory says.

    python -m benchmarks.soft_physics                   every check that was not run yet, then the whole table
    python -m benchmarks.soft_physics --only press …    these again
    python -m benchmarks.soft_physics --all --docs      all again, and the table into docs/soft.md

Run in the repository's root. A check is a module in `benchmarks/softlab/checks`; its docstring has the equation and its
source.
"""

import argparse
import sys
import time
from dataclasses import asdict
from importlib import import_module

from benchmarks.softlab.documents import engine, keep, known, paste
from benchmarks.softlab.lab import Lab
from benchmarks.softlab.row import Row, table

CHECKS = ("own_weight", "cantilever", "press", "collision", "catenary", "rest", "repose", "dam_break")


def main() -> None:
    """Run what is wanted and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", choices=CHECKS, help="run these again")
    parser.add_argument("--all", action="store_true", help="run all again")
    parser.add_argument("--docs", action="store_true", help="put the table into docs/soft.md")
    options = parser.parse_args()
    results = known("soft_physics")
    with Lab() as lab:
        for name in options.only or [name for name in CHECKS if options.all or name not in results]:
            began = time.monotonic()
            rows = import_module(f"benchmarks.softlab.checks.{name}").check(lab)
            results[name] = [asdict(row) for row in rows]
            keep("soft_physics", results)
            print(f"{name}: {time.monotonic() - began:.0f} s\n{table(rows)}\n", file=sys.stderr, flush=True)
    rows = [Row(**row) for name in CHECKS for row in results.get(name, [])]
    text = f"{table(rows)}\n\nMeasured with {engine()}."
    print(text)
    if options.docs:
        paste("soft.md", "figures", text)


if __name__ == "__main__":
    main()
