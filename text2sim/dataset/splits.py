"""Assignment of sources to splits without leaks, and the check for leaks."""

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping
from typing import Any

from text2sim.dataset.recipe import SPLITS, Recipe, Split
from text2sim.spec_schema.errors import RunError

TOGETHER = ("source", "case", "case_digest", "sim_digest", "states_digest", "film_digest")
"""Columns of the items whose values must not be in two splits."""
LINKS = ("same_physics_as", "counterfactual_of")
"""Columns that name another item, which must be in the same split."""


def deal_splits(recipe: Recipe, jobs: Iterable[tuple[str, str]]) -> dict[str, Split]:
    """Return the split of each source, such that the numbers of items are near the requested shares.

    The largest sources come first, each goes to the split that lacks most, and single moves improve the result.

    Args:
        recipe: Has the shares, the splits of some sources, and the number of items per job.
        jobs: Source and case of every job. Sources that share a case stay together.

    Raises:
        RunError: if sources that share a case have different splits.
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
            raise RunError(f"the source {name} shares a case with a source that goes to {found[group[name]]}")
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
            # Moving the weight w changes the sum of squares of `missing` by 2 w (w + from - to).
            split: Split = max(wanted, key=lambda split: missing[split])
            if weight[root] + missing[found[root]] - missing[split] < -1e-9:
                missing[found[root]] += weight[root]
                missing[split] -= weight[root]
                found[root], moved = split, True
    return {name: found[group[name]] for name in sizes}


def leaks(rows: Iterable[tuple[str, Mapping[str, Any]]]) -> list[str]:
    """Return what belongs together and is in two splits, in words.

    Args:
        rows: Each item with the split of its file: columns `key`, `TOGETHER` and `LINKS`.
    """
    where: dict[tuple[str, str], dict[str, str]] = defaultdict(dict)
    home: dict[str, str] = {}
    links, found = [], []
    for split, row in rows:
        key = row["key"]
        if row.get("split", split) != split:
            found.append(f"{key} has the split {row['split']}, but is in {split}")
        if key in home and home[key] != split:
            found.append(f"{key} is in {home[key]} and in {split}")
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
