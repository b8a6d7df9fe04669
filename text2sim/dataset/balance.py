"""Selection of questions whose words do not give the answer away, and a classifier of words that verifies it.

Among all questions about a case with the same text, every answer is correct equally often, and each choice is correct
for some of them.
"""

import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from hashlib import sha256

import numpy as np

from text2sim.dataset.draws import generator
from text2sim.dataset.questions import Row

Group = tuple[str, str, str]
"""Split, case and text of questions: answers from another case would not be in the scene."""
MAX_CHOICES = 5
"""Largest number of choices."""
FOLDS = 5
"""Folds of cases for cross-validation."""


def balanced_questions(rows: Iterable[Row], counts: Mapping[Group, Counter[str]], seed: int) -> Iterator[Row]:
    """Yield questions with choices, as rows of the table, such that their text does not tell the answer.

    Args:
        rows: Candidates, each with its `split` and `case`.
        counts: How often each answer is correct among all candidates of a group.
        seed: Seed of the order of choices.
    """
    quota = {group: _quota(found) for group, found in counts.items()}
    given: dict[Group, Counter[str]] = defaultdict(Counter)
    for row in rows:
        group = row["split"], row["case"], row["question"]
        wanted = quota.get(group, {})
        if given[group][row["right"]] >= wanted.get(row["right"], 0):
            continue
        given[group][row["right"]] += 1
        choices, digest = [*wanted], sha256(row["question"].encode()).hexdigest()[:8]
        number = sum(given[group].values())
        generator(seed, row["key"], row["question"], number).shuffle(choices)
        kept = {name: row[name] for name in ("split", "key", "kind", "question", "evidence")}
        answer = {"choices": choices, "answer": choices.index(row["right"])}
        yield kept | answer | {"question_id": f"{row['key']}-{row['kind']}-{digest}"}


def _quota(found: Counter[str]) -> dict[str, int]:
    """How often each answer is used: the most frequent answers, each as often as the rarest of them.

    The number of answers, from two to `MAX_CHOICES`, is the one that gives the most questions.
    """
    ranked = sorted(found.items(), key=lambda pair: (-pair[1], pair[0]))[:MAX_CHOICES]
    best = max(range(1, len(ranked) + 1), key=lambda n: (n > 1, n * ranked[n - 1][1]))
    return {answer: ranked[best - 1][1] for answer, _ in ranked[:best]} if best > 1 else {}


def guess_by_words(rows: Sequence[Row], cases: Sequence[str]) -> dict[str, float]:
    """Return the shares of questions (rows, and the case of each) that are answered correctly without pictures.

    `by_words`: by naive Bayes over the words and pairs of words of question and choice, trained on other cases. The
    same cases must not train it: where answers are balanced exactly, the remaining ones are wrong.
    `by_wording`: by someone who knows the most frequent answer to every wording; an upper bound for words alone.
    `by_chance`: by guessing.
    """
    if not rows:
        return dict.fromkeys(("by_words", "by_wording", "by_chance"), 0.0)
    names = sorted({*cases})
    dealt = dict(zip(names, generator("folds", len(names)).permutation(len(names)) % FOLDS, strict=True))
    fold_of = np.array([dealt[case] for case in cases])
    hits, wordings = 0, defaultdict[tuple[str, str, tuple[str, ...]], Counter[str]](Counter)
    for fold in range(FOLDS):
        seen = {True: Counter[str](), False: Counter[str]()}
        for k in np.flatnonzero(fold_of != fold).tolist():
            for number, choice in enumerate(rows[k]["choices"]):
                seen[number == rows[k]["answer"]].update(_features(rows[k], choice))
        totals = {truth: sum(found.values()) + 1 for truth, found in seen.items()}
        for k in np.flatnonzero(fold_of == fold).tolist():
            scores = [
                sum(
                    np.log((seen[True][f] + 1) / totals[True]) - np.log((seen[False][f] + 1) / totals[False])
                    for f in _features(rows[k], choice)
                )
                for choice in rows[k]["choices"]
            ]
            hits += int(np.argmax(scores)) == rows[k]["answer"]
    for row, case in zip(rows, cases, strict=True):
        wordings[case, row["question"], tuple(sorted(row["choices"]))][row["choices"][row["answer"]]] += 1
    return {
        "by_words": hits / len(rows),
        "by_wording": sum(max(found.values()) for found in wordings.values()) / len(rows),
        "by_chance": float(np.mean([1 / len(row["choices"]) for row in rows])),
    }


def _features(row: Row, choice: str) -> list[str]:
    words = re.findall(r"\w+", row["question"].lower())
    pairs = [f"{a} {b}" for a, b in zip(words, words[1:], strict=False)]
    return [choice, *(f"{word}|{choice}" for word in {*words, *pairs}), f"{row['question']}|{choice}"]
