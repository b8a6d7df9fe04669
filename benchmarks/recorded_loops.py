"""What agents took for requests that were played once: a table, or some of them played again.

    python benchmarks/recorded_loops.py                          # the table of docs/agents.md, from the records
    python benchmarks/recorded_loops.py --replay anchor sand     # played again with kept replies: what they take now
    python benchmarks/recorded_loops.py --replay sand --keep F   # runs stay in folder F, and are not simulated twice
    python benchmarks/recorded_loops.py --replay sand --write    # what it takes now goes into its record, and the table

Checker, engine and account of a replay are real; it says how large the letters were, by role.

The records lie in `tests/agents/recorded`: the request, every reply, how it ended, and what it took when it was played.
Tokens are counted as `docs/models.md` says of mailboxes; minutes are by the clock, on a machine that did much else.
"""

import argparse
import json
import shutil
import tempfile
from collections import defaultdict
from pathlib import Path
from typing import Any

GOALS = {"simple": 40_000, "hard": 100_000, "small edit": 12_000, "make the ball red": 6_000}
RECORDED = Path(__file__).resolve().parents[1] / "tests" / "agents" / "recorded"


def main() -> None:
    """Print what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--replay", metavar="NAME", nargs="+", help="play these again")
    parser.add_argument("--keep", metavar="FOLDER", type=Path, help="keep what is simulated here")
    parser.add_argument("--write", action="store_true", help="put what it takes now into the record")
    given = parser.parse_args()
    for name in given.replay or ():
        print(f"## {name}\n\n{replay(name, given.keep, write=given.write)}\n", flush=True)
    if not given.replay:
        print(table())


def table() -> str:
    """Return the table of all records, in Markdown."""
    rows = [
        "| request | outcome | versions | Critic | calls | tokens | now | from a cache | minutes | cards |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for file in sorted(RECORDED.glob("*/expected.json")):
        record = json.loads(file.read_text("utf-8"))
        played: dict[str, Any] = record["played"]
        now: dict[str, int] = record.get("now", {})
        cells = [
            record["request"],
            record["state"].replace("_", " "),
            played["attempts"],
            ", ".join(played["verdicts"]) or "–",
            played["calls"],
            f"{played['tokens']:,}" if played["tokens"] else "–",
            f"{now['tokens']:,}" if now else "–",
            f"{now['again']:,}" if now else "–",
            f"{played['minutes']:g}" if played["minutes"] else "–",
            ", ".join(played["cards"]) or "–",
        ]
        rows.append("| " + " | ".join(map(str, cells)) + " |")
    goals = ", ".join(f"{sort} {tokens:,}" for sort, tokens in GOALS.items())
    return "\n".join([*rows, "", f"Goals, in tokens of an accepted case: {goals}."])


def replay(name: str, keep: Path | None = None, *, write: bool = False) -> str:
    """Play a record again; return how it ended, what it took, and how large the letters were."""
    from text2sim.agents.session import Session, SessionWish

    record = json.loads((RECORDED / name / "expected.json").read_text("utf-8"))
    base = RECORDED / name / "base.yaml"
    wish = SessionWish(
        record.get("kind", "generate"),
        record["request"],
        {"": f"replay:{RECORDED / name}"},
        attempts=record["attempts"],
        base=base.read_text("utf-8") if base.is_file() else "",
    )
    with tempfile.TemporaryDirectory() as folder:
        case = (keep or Path(folder)) / name
        shutil.rmtree(case / "generation" / "calls", ignore_errors=True)
        (case / "generation" / "request.json").unlink(missing_ok=True)
        session = Session.begin(case, wish, [], [])
        outcome = session.run(lambda event, what: None)
        sizes = letter_sizes(case)
    if write and outcome.state == record["state"]:
        total = session.account.total()
        record["now"] = {"calls": total.calls, "tokens": total.tokens, "again": total.again}
        text = json.dumps(record, indent=1, ensure_ascii=False) + "\n"
        (RECORDED / name / "expected.json").write_text(text, "utf-8")
    rows = ["  ".join(f"{cell:>12}" for cell in row) for row in session.account.table()]
    return "\n".join([f"{outcome.state}: {outcome.why}", *rows, "", *sizes])


def letter_sizes(case: Path) -> list[str]:
    """Rows of bytes of letters and of answers by role, of a loop that was played."""
    calls: dict[str, list[tuple[int, int, int]]] = defaultdict(list)
    for file in sorted((case / "generation" / "calls").glob("*.json")):
        call = json.loads(file.read_text("utf-8"))
        told = [len(message["text"].encode()) for message in call["request"]["messages"]]
        calls[call["request"]["role"]].append((sum(told), told[0], len(call["reply"]["text"].encode())))
    rows = [("letters", "calls", "bytes", "of them first message", "answers")]
    rows += [
        (role, *(f"{n:,}" for n in (len(sent), *(sum(row[k] for row in sent) for k in range(3)))))
        for role, sent in calls.items()
    ]
    return ["  ".join(f"{cell:>12}" for cell in row) for row in rows]


if __name__ == "__main__":
    main()
