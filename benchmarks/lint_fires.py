"""Which rules of the lint fire, over cases that people and agents wrote, and over slips made in them: a table.

    python benchmarks/lint_fires.py [--slips 3000] [--seed 1] [--json FILE]

Documents: the shipped cases, the cards, the scenes of benchmarks and tests, cases that recorded loops assembled, and
every version of them that git keeps. A slip is one change that a hurried author makes: a factor of ten or of a unit,
a sign, degrees for radians, two numbers exchanged, a key left out. A rule that no slip and no document ever breaks is
one to look at.
"""

import argparse
import copy
import json
import math
import random
import re
import signal
import subprocess
import sys
from collections import Counter, defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from text2sim.compiler.build import resolve_case  # noqa: E402
from text2sim.lint import lint_case  # noqa: E402
from text2sim.lint.rules import RULES  # noqa: E402
from text2sim.spec_schema.errors import SpecError, Text2SimError  # noqa: E402
from text2sim.spec_schema.load import load_text  # noqa: E402
from text2sim.spec_schema.text.canonical import dump_case  # noqa: E402
from text2sim.spec_schema.text.document import parse_document  # noqa: E402
from text2sim.spec_schema.text.source import Source  # noqa: E402

FACTORS = (1000, 0.001, 10, 0.1, 2, 0.5, -1, 0, math.degrees(1), math.radians(1))
SECONDS = 20
"""A check that takes longer is left out."""


def documents() -> Iterator[tuple[str, str, Path]]:
    """Yield kind, text and place of every document."""
    for kind, pattern in (
        ("case", "cases/*/case.yaml"),
        ("card", "text2sim/card_library/cards/*/*ing.yaml"),
        ("card", "text2sim/card_library/cards/*/repaired.yaml"),
        ("scene", "benchmarks/**/*.yaml"),
        ("scene", "tests/**/case.yaml"),
    ):
        for path in sorted(ROOT.glob(pattern)):
            yield kind, path.read_text("utf-8"), path
    for folder in sorted((ROOT / "tests/agents/recorded").iterdir()):
        yield from (("loop", text, folder / "case.yaml") for text in assembled(folder))
    yield from earlier_versions()


def assembled(folder: Path) -> Iterator[str]:
    """Yield the first case that a recorded loop put together, and that of every later reply of a Writer."""
    parts: dict[str, Any] = {"text2sim": 2, "name": "recorded"}
    order = {"scene": 0, "bodies": 1, "actions": 2, "render": 3}
    files = [f for f in folder.glob("*.reply.md") if f.name.split("-")[0] in order]
    for file in sorted(files, key=lambda f: (f.name.split("-")[1], order[f.name.split("-")[0]])):
        for block in re.findall(r"```ya?ml\n(.*?)```", file.read_text("utf-8"), re.S):
            try:
                data = parse_document(Source(block)).data
            except SpecError:
                continue
            if isinstance(data, dict):
                parts |= data
                if len(parts) > 3:
                    yield dump_case(parts)


def earlier_versions() -> Iterator[tuple[str, str, Path]]:
    """Yield other versions of the files that git keeps."""
    seen: set[str] = set()
    for commit in git("log", "--all", "--format=%H", "--", "*.yaml").split():
        for line in git("diff-tree", "-r", "--root", "--no-commit-id", commit, "--", "*.yaml").splitlines():
            blob, path = line.split()[3], line.split("\t")[1]
            if blob not in seen and set(blob) != {"0"}:
                seen.add(blob)
                yield "earlier", git("cat-file", "blob", blob), ROOT / path


def git(*words: str) -> str:
    """Return what git says."""
    return subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True, check=False).stdout


def slip(data: Any, chance: random.Random) -> Any:
    """Return a document with one slip."""
    data = copy.deepcopy(data)
    numbers, keys, vectors = [], [], []
    stack = [data.get(key) for key in ("scene", "bodies", "actions", "render", "params")]
    while stack:
        one = stack.pop()
        rows = one.items() if isinstance(one, dict) else enumerate(one) if isinstance(one, list) else ()
        for key, value in rows:
            if isinstance(value, int | float) and not isinstance(value, bool):
                numbers.append((one, key))
            if isinstance(one, dict):
                keys.append((one, key))
            if isinstance(value, list) and len(value) > 1:
                vectors.append(value)
            stack.append(value)
    kind = chance.random()
    if kind < 0.6 and numbers:
        one, key = chance.choice(numbers)
        one[key] = one[key] * chance.choice(FACTORS)
    elif kind < 0.85 and keys:
        one, key = chance.choice(keys)
        del one[key]
    elif vectors:
        one = chance.choice(vectors)
        a, b = chance.sample(range(len(one)), 2)
        one[a], one[b] = one[b], one[a]
    return data


def fired(text: str, path: Path) -> Counter[str] | None:
    """Return how often each rule fires, waived or not; nothing for what is no case, or takes too long."""
    signal.alarm(SECONDS)
    try:
        report = lint_case(resolve_case(load_text(text, path)))
        return Counter(p.rule for p in [*report.problems, *(one.problem for one in report.waived)])
    except SpecError as error:
        known = {rule.id for rule in RULES}
        return Counter(p.rule for p in error.problems if p.rule in known)
    except (Text2SimError, TimeoutError, OSError, ValueError):
        return None
    finally:
        signal.alarm(0)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--slips", type=int, default=3000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()

    def late(*_: object) -> None:
        raise TimeoutError

    signal.signal(signal.SIGALRM, late)
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    example: dict[str, str] = {}
    sound: list[tuple[Any, Path, Counter[str]]] = []
    number = Counter[str]()
    for kind, text, path in documents():
        if not text.lstrip().startswith(("text2sim", "#")):
            continue
        found = fired(text, path)
        if found is None:
            continue
        number[kind] += 1
        for rule in found:
            counts[rule][kind] += 1
            example.setdefault(rule, f"{kind} {path.parent.name}")
        if kind != "earlier":
            try:
                sound.append((parse_document(Source(text)).data, path, found))
            except SpecError:
                continue
    print(dict(number), file=sys.stderr, flush=True)
    chance = random.Random(given.seed)
    for _ in range(given.slips):
        data, path, before = chance.choice(sound)
        try:
            found = fired(dump_case(slip(data, chance)), path)
        except (ValueError, KeyError, TypeError, AttributeError):
            continue
        number["slip"] += found is not None
        for rule in (found or Counter()) - before:
            counts[rule]["slip"] += 1
            example.setdefault(rule, f"slip in {path.parent.name}")
    never = [rule.id for rule in RULES if rule.id not in counts]
    kinds = ["case", "card", "scene", "loop", "earlier", "slip"]
    print("| rule | " + " | ".join(f"{kind} ({number[kind]})" for kind in kinds) + " | first |")
    print("|---|" + "---|" * (len(kinds) + 1))
    for rule in RULES:
        row = [str(counts[rule.id][kind] or "") for kind in kinds]
        print(f"| `{rule.id}` | " + " | ".join(row) + f" | {example.get(rule.id, '')} |")
    print("never: " + ", ".join(never))
    if given.json:
        given.json.write_text(json.dumps(counts, indent=1))


if __name__ == "__main__":
    main()
