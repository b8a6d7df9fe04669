"""Which families of bodies touch, both ways, with friction: a table from runs of tiny scenes.

    python -m benchmarks.contact_pairs                      every pair that was not run yet, then the whole table
    python -m benchmarks.contact_pairs --only rigid-mpm …   these again
    python -m benchmarks.contact_pairs --all --docs         all again, and the table into docs/contact.md

Run in the repository's root. What a pair is, and how it is judged: `benchmarks/softlab/pairs.py`,
`benchmarks/softlab/pair_scene.py`.
"""

import argparse
import sys
import time

from benchmarks.softlab.documents import engine, keep, known, paste
from benchmarks.softlab.families import pairs
from benchmarks.softlab.lab import Lab
from benchmarks.softlab.pair_table import markdown
from benchmarks.softlab.pairs import Finding, as_row, batches, examine


def main() -> None:
    """Run what is wanted and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", metavar="PAIR", help="run these pairs, such as rigid-mpm, again")
    parser.add_argument("--all", action="store_true", help="run all pairs again")
    parser.add_argument("--docs", action="store_true", help="put the table into docs/contact.md")
    options = parser.parse_args()
    by_name = {pair.name: pair for pair in pairs()}
    if unknown := sorted(set(options.only or ()) - set(by_name)):
        parser.error(f"no such pair: {', '.join(unknown)}; there are {', '.join(by_name)}")
    results = known("contact_pairs")
    wanted = options.only or [name for name in by_name if options.all or name not in results]
    with Lab() as lab:
        for batch in batches([by_name[name] for name in wanted]):
            began = time.monotonic()
            found = examine(lab, batch)
            results |= {finding.pair: as_row(finding) for finding in found}
            keep("contact_pairs", results)
            print(*found, f"{time.monotonic() - began:.0f} s", sep="\n", file=sys.stderr, flush=True)
    findings = [Finding(**results[name]) for name in by_name if name in results]
    text = f"{markdown(findings)}\n\nMeasured with {engine()}."
    print(text)
    if options.docs:
        paste("contact.md", "pairs", text)


if __name__ == "__main__":
    main()
