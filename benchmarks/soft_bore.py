"""How `soft_reach` and the cell change a bore, measured: the table in docs/soft.md.

python -m benchmarks.soft_bore            what was not run yet, then the table
python -m benchmarks.soft_bore --all      all again
python -m benchmarks.soft_bore --docs     and put it into docs/soft.md
"""

import argparse
from dataclasses import asdict

from benchmarks.softlab.bore import TRIALS, Bore, measure, table
from benchmarks.softlab.documents import engine, keep, known, paste
from benchmarks.softlab.lab import Lab


def main() -> None:
    """Run what is wanted and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--all", action="store_true", help="run all again")
    parser.add_argument("--docs", action="store_true", help="put the table into docs/soft.md")
    options = parser.parse_args()
    results = {} if options.all else known("soft_bore")
    with Lab() as lab:
        for trial in TRIALS:
            if (key := " ".join(map(str, trial))) not in results:
                results[key] = asdict(measure(lab, *trial))
                keep("soft_bore", results)
    rows = [Bore(**results[key]) for trial in TRIALS if (key := " ".join(map(str, trial))) in results]
    text = f"{table(rows)}\n\nMeasured with {engine()}."
    print(text)
    if options.docs:
        paste("soft.md", "bores", text)


if __name__ == "__main__":
    main()
