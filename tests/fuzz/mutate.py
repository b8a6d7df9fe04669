"""Documents that nobody should have written: cases with something changed in them, as text or as data."""

import copy
import random
from pathlib import Path

from data_changes import DATA, GENTLE
from draft import PIECES, Draft
from language_changes import WORDS, lay_over, operation

from text2sim.spec_schema.text.canonical import dump_case
from text2sim.spec_schema.text.document import parse_document
from text2sim.spec_schema.text.source import Source

SOFT = Path(__file__).with_name("soft")


def originals_of(cases: Path) -> list[Path]:
    """Return the cases that are changed: the good ones, and some with deformable bodies of every kind."""
    return [*sorted(cases.glob("*/case.yaml")), *sorted(SOFT.glob("*/case.yaml"))]


def mutations(cases: Path, count: int, seed: int) -> list[Draft]:
    """Make documents, always the same for one seed.

    Args:
        cases: The folder of good cases.
        count: How many.
        seed: Of the choice.
    """
    chance = random.Random(seed)
    originals = [(path.parent.name, path.read_text("utf-8")) for path in originals_of(cases)]
    data = {name: parse_document(Source(text)).data for name, text in originals}
    made: list[Draft] = []
    while len(made) < count:
        name, text = chance.choice(originals)
        if chance.random() < 0.25:
            draft = Draft(name, _spoil_text(text, chance), data[name])
        else:
            draft = _changed(Draft(name, data=copy.deepcopy(data[name])), chance)
        if chance.random() < 0.2:
            lay_over(draft, chance)
        if chance.random() < 0.3:
            # A copy each: a patch that comes as JSON has no value in two places.
            draft.operations = [
                copy.deepcopy(operation(draft.data, chance)) for _ in range(chance.choice((1, 1, 2, 5)))
            ]
        try:
            draft.text = draft.text or dump_case(draft.data).encode("utf-8", "surrogatepass")
        except (ValueError, RecursionError):
            continue  # not a document at all
        made.append(draft)
    return made


def _changed(draft: Draft, chance: random.Random) -> Draft:
    # Half of them stay near to what a case is: only those get past the first checks.
    gentle = chance.random() < 0.6
    if chance.random() < 0.5:
        for _ in range(chance.choice((1, 1, 2))):
            chance.choice(WORDS)(draft, chance)
    for _ in range(chance.choice((0, 1, 1, 1, 2, 3, 8))):
        chance.choice(GENTLE if gentle else DATA)(draft.data, chance)
    return draft


def _spoil_text(text: str, chance: random.Random) -> bytes:
    data = text
    for _ in range(chance.choice((1, 1, 2, 5))):
        at, other = sorted(chance.randrange(len(data) + 1) for _ in range(2))
        kind = chance.randrange(6)
        if kind == 0:
            data = data[:at] + chance.choice(PIECES) + data[at:]
        elif kind == 1:
            data = data[:at] + data[min(other, at + 40) :]
        elif kind == 2:
            data = data[:at] + data[at : min(other, at + 200)] * 2 + data[at:]
        elif kind == 3:
            lines = data.split("\n")
            i, j = (chance.randrange(len(lines)) for _ in range(2))
            lines[i], lines[j] = lines[j], lines[i]
            data = "\n".join(lines)
        elif kind == 4:
            lines = data.split("\n")
            i = chance.randrange(len(lines))
            lines[i] = " " * chance.randrange(9) + lines[i].lstrip()
            data = "\n".join(lines)
        else:
            data = data[:at] + chance.choice("0123456789.e-") + data[at + 1 :]
        data = data or " "
    spoiled = data.encode("utf-8")
    if chance.random() < 0.1:
        at = chance.randrange(len(spoiled))
        spoiled = spoiled[:at] + bytes([chance.randrange(256)]) + spoiled[at + 1 :]
    return spoiled
