"""Cycles among names that refer to each other."""

from collections.abc import Mapping


def find_cycles(following: Mapping[str, str]) -> list[list[str]]:
    """Return the cycles of a graph in which each name has at most one successor."""
    cycles: list[list[str]] = []
    seen: set[str] = set()
    for start in following:
        path: list[str] = []
        name = start
        while name in following and name not in seen:
            seen.add(name)
            path.append(name)
            name = following[name]
        if name in path:
            cycles.append(path[path.index(name) :])
    return cycles
