"""Splits without leaks: what belongs together lies in one split, and a check that proves it."""

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping
from typing import Any

from text2sim.dataset.recipe import SPLITS, Recipe, Split
from text2sim.spec_schema.errors import RunError

TOGETHER = ("source", "case", "case_digest", "sim_digest", "states_digest", "film_digest")
"""Columns of the items of which no value may be in two splits."""
LINKS = ("same_physics_as", "counterfactual_of")
"""Columns that name another item, which has to be in the same split."""


def deal(recipe: Recipe, jobs: Iterable[tuple[str, str]]) -> dict[str, Split]:
    """Return the split of each source: the largest first, each to where most is missing, then moved while that helps.

    Args:
        recipe: Says the shares, the splits of some sources, and how many items a job makes.
        jobs: Source and case of every job. Sources that share a case stay together.

    Raises:
        RunError: if sources that share a case are wanted in different splits.
    """
    sizes, cases = Counter[str](), dict[str, str]()
    group = {name: name for name in recipe.sources}
    for source, case in jobs:
        own = recipe.sources[source]
        sizes[source] += own.films * (1 + len(own.counterfactuals))
        first, second = group[cases.setdefault(case, source)], group[source]
        group = {name: first if root == second else root for name, root in group.items()}
    found: dict[str, Split] = {}
    for name, source in recipe.sources.items():
        if source.split is not None and found.setdefault(group[name], source.split) != source.split:
            raise RunError(f"the source {name} has a case in common with one that goes to {found[group[name]]}")
    weight = Counter[str]()
    for name, size in sizes.items():
        weight[group[name]] += size
    whole, shares = weight.total(), sum(recipe.splits.values())
    missing: dict[Split, float] = {split: recipe.splits.get(split, 0.0) / shares * whole for split in SPLITS}
    for root, split in found.items():
        missing[split] -= weight[root]
    free = sorted((root for root in weight if root not in found), key=lambda root: (-weight[root], root))
    wanted: list[Split] = [split for split, share in recipe.splits.items() if share]
    for root in free:
        found[root] = max(wanted, key=lambda split: missing[split])
        missing[found[root]] -= weight[root]
    moved = True
    while moved:
        moved = False
        for root in free:
            # A move by w changes the sum of squares of what is missing by 2 w (w + from - to).
            split: Split = max(wanted, key=lambda split: missing[split])
            if weight[root] + missing[found[root]] - missing[split] < -1e-9:
                missing[found[root]] += weight[root]
                missing[split] -= weight[root]
                found[root], moved = split, True
    return {name: found[group[name]] for name in sizes}


def leaks(rows: Iterable[tuple[str, Mapping[str, Any]]]) -> list[str]:
    """Return what lies in two splits although it belongs together, in words.

    Args:
        rows: The split that the file of each item is of, and the item: columns `key`, `TOGETHER` and `LINKS`.
    """
    where: dict[tuple[str, str], dict[str, str]] = defaultdict(dict)
    home: dict[str, str] = {}
    links, found = [], []
    for split, row in rows:
        key = row["key"]
        if row.get("split", split) != split:
            found.append(f"{key} says it is of {row['split']}, and lies in {split}")
        if key in home and home[key] != split:
            found.append(f"{key} lies in {home[key]} and in {split}")
        home[key] = split
        for column in TOGETHER:
            if row.get(column):
                where[column, row[column]].setdefault(split, key)
        links += [(key, column, row[column]) for column in LINKS if row.get(column)]
    for (column, value), splits in where.items():
        if len(splits) > 1:
            some = " and ".join(f"{key} in {split}" for split, key in splits.items())
            found.append(f"one {column.replace('_', ' ')}, {value[:40]}: {some}")
    for key, column, other in links:
        if home.get(other, home[key]) != home[key]:
            found.append(f"{key} in {home[key]} is {column.replace('_', ' ')} {other} in {home[other]}")
    return found
