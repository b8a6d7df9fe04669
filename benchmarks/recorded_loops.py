"""What agents took for requests that were played once: a table, or one of them played again.

    python benchmarks/recorded_loops.py                   # the table of docs/agents.md, from the records
    python benchmarks/recorded_loops.py --replay anchor   # checker, engine and account are real, the replies are kept

The records lie in `tests/agents/recorded`: the request, every reply, how it ended, and what it took when it was played.
Tokens are counted as `docs/models.md` says of mailboxes; minutes are by the clock, on a machine that did much else.
"""

import argparse
import json
import tempfile
from pathlib import Path
from typing import Any

RECORDED = Path(__file__).resolve().parents[1] / "tests" / "agents" / "recorded"


def main() -> None:
    """Print what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--replay", metavar="NAME", help="play this one again")
    name = parser.parse_args().replay
    print(replay(name) if name else table())


def table() -> str:
    """Return the table of all records, in Markdown."""
    rows = [
        "| request | outcome | versions | Critic | calls | tokens | minutes | cards |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for file in sorted(RECORDED.glob("*/expected.json")):
        record = json.loads(file.read_text("utf-8"))
        played: dict[str, Any] = record["played"]
        cells = [
            record["request"],
            record["state"].replace("_", " "),
            played["attempts"],
            ", ".join(played["verdicts"]) or "–",
            played["calls"],
            f"{played['tokens']:,}",
            f"{played['minutes']:g}",
            ", ".join(played["cards"]) or "–",
        ]
        rows.append("| " + " | ".join(map(str, cells)) + " |")
    return "\n".join(rows)


def replay(name: str) -> str:
    """Play a record again; return how it ended and what it took."""
    from text2sim.agents.session import Session, Wish

    record = json.loads((RECORDED / name / "expected.json").read_text("utf-8"))
    wish = Wish("generate", record["request"], {"": f"replay:{RECORDED / name}"}, attempts=record["attempts"])
    with tempfile.TemporaryDirectory() as folder:
        session = Session.begin(Path(folder) / "case", wish, [], [])
        outcome = session.run(lambda event, what: None)
    rows = ["  ".join(f"{cell:>12}" for cell in row) for row in session.account.table()]
    return "\n".join([f"{outcome.state}: {outcome.why}", *rows])


if __name__ == "__main__":
    main()
