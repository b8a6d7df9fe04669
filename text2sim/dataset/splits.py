"""Splits without leaks: what belongs together lies in one split, and a check that proves it."""

from collections import defaultdict
from collections.abc import Iterable, Mapping
from typing import Any

from text2sim.dataset.recipe import Recipe, Split

TOGETHER = ("source", "case", "case_digest", "sim_digest", "states_digest", "film_digest")
"""Columns of the items of which no value may be in two splits."""
LINKS = ("same_physics_as", "counterfactual_of")
"""Columns that name another item, which has to be in the same split."""


def deal(recipe: Recipe, sizes: Mapping[str, int]) -> dict[str, Split]:
    """Return the split of each source: the largest first, each to where most is missing.

    Args:
        recipe: Says the shares, and the splits of some sources.
        sizes: How many items each source will have about.
    """
    given: dict[str, Split] = {
        name: source.split for name, source in recipe.sources.items() if source.split is not None
    }
    filled: dict[Split, float] = dict.fromkeys(recipe.splits, 0.0)
    for name, split in given.items():
        filled[split] = filled.get(split, 0.0) + sizes[name]
    whole, shares = sum(sizes.values()), sum(recipe.splits.values())
    for name in sorted(sizes, key=lambda name: (-sizes[name], name)):
        if name in given:
            continue
        missing: dict[Split, float] = {
            split: share / shares * whole - filled[split] for split, share in recipe.splits.items() if share
        }
        split = max(missing, key=lambda split: missing[split])
        given[name] = split
        filled[split] += sizes[name]
    return given


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
