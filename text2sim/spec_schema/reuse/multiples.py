"""Multiplication of parts, links, controls, measures, events and expectations with `repeat`.

An entry `spoke: {repeat: 12, …}` becomes `spoke_0` to `spoke_11`, each with its number for `k` in every `${…}`.
"""

import re
from dataclasses import replace
from typing import Any

from text2sim.spec_schema.arithmetic.interpolation import parse_interpolation
from text2sim.spec_schema.arithmetic.resolution import Cascade, Resolver
from text2sim.spec_schema.arithmetic.values import ExpressionError
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.models.base import MAX_MULTIPLE
from text2sim.spec_schema.reuse.filling import at_one_place
from text2sim.spec_schema.reuse.sections import repeated, sections
from text2sim.spec_schema.reuse.substitution import bind, fill
from text2sim.spec_schema.reuse.trees import LocatedValue, count, mapping, moved, put, sequence
from text2sim.spec_schema.text.document import MAX_NODES, Document, Node, Origin, Path, sites_of
from text2sim.spec_schema.text.nodes import Derived

_OF_ONE = re.compile(r" \(`\w+`, number \d+\)\Z")
NUMBER = "k"
"""Name of the number of an entry in its expressions."""


def multiply(document: Document) -> tuple[Document, list[Problem]]:
    """Return a case with its entries multiplied, and the problems of entries with `repeat`.

    An entry with an invalid number stays as it is, because the check of its form reports it.
    """
    tree, problems = LocatedValue(document.data, document.root), list[Problem]()
    resolver = Resolver(document)
    resolver.params.evaluate_all()
    if NUMBER in resolver.params:
        message = f"`{NUMBER}` is the number of an entry with repeat; choose another name for the parameter"
        return document, [document.problem(("params", NUMBER), message, key=True, rule="taken-name")]
    room = MAX_NODES - count(document.data)
    for path, section in list(sections(document.data)):
        if not any(True for _ in repeated(section)):
            continue
        multiplied, room = _section(document, resolver, tree.at(path), path, problems, room)
        tree = put(tree, path, multiplied)
    sites = sites_of(tree.data)
    # Expressions from a prefab may be long, and have a new path now; the old ones are gone.
    new = sites.keys() - document.sites.keys() if document.composed else frozenset()
    composed = (document.composed & sites.keys()) | new
    return replace(document, data=tree.data, root=tree.node, sites=sites, composed=composed), problems


def without_repeats(problems: list[Problem]) -> list[Problem]:
    """Return the problems, of those that several numbers of an entry share only the first."""
    first: dict[tuple[Any, ...], Problem] = {}
    for problem in problems:
        first.setdefault((problem.line, problem.column, problem.rule, _OF_ONE.sub("", problem.message)), problem)
    return list(first.values())


def _section(
    document: Document, resolver: Resolver, section: LocatedValue, path: Path, problems: list[Problem], room: int
) -> tuple[LocatedValue, int]:
    parts: dict[str, LocatedValue] = {}
    keys: dict[str, tuple[int, int]] = {}
    several = set(repeated(section.data))
    for name in section.data:
        entry, here = section.child(name), (*path, name)
        if not isinstance(entry.data, dict):  # the check of its form reports it
            parts[name], keys[name] = entry, section.node.keys[name]
            continue
        number = _number(resolver, entry.data["repeat"]) if name in several else None
        plain = mapping(entry.node, {key: entry.child(key) for key in entry.data if key != "repeat"})
        if number is None:
            parts[name], keys[name] = entry, section.node.keys[name]
            if name in several:  # its number is reported, and the rest is checked as entry 0
                parts[name] = put(_rooted(_filled(plain, name, 0), name), ("repeat",), entry.child("repeat"))
            continue
        room -= number * count(plain.data)
        if room < 0:
            problems.append(document.problem((*here, "repeat"), "makes the case too large", rule="too-large"))
            continue
        for k in range(number):
            copy_name = f"{name}_{k}"
            if copy_name in section.data or copy_name in parts:
                message = f"`{copy_name}` already exists; `{name}` with repeat makes the same name"
                problems.append(document.problem(here, message, key=True, rule="duplicate-name"))
                break
            try:
                parts[copy_name], keys[copy_name] = _rooted(_filled(plain, name, k), name), section.node.keys[name]
            except ExpressionError as error:
                problems.append(document.problem(here, str(error), rule=error.rule, hint=error.hint))
                break
    return mapping(section.node, parts, keys), room


def _number(resolver: Resolver, value: Any) -> int | None:
    if isinstance(value, str):
        try:
            value = parse_interpolation(value).evaluate(resolver.scope())
        except (ExpressionError, Cascade):
            return None
    return value if type(value) is int and 1 <= value <= MAX_MULTIPLE else None


def _rooted(link: LocatedValue, name: str) -> LocatedValue:
    """Return a link without parent and joint, if it is the first of a row in which each hangs on the one before."""
    if link.data.get("parent") != f"{name}_-1":
        return link
    return mapping(link.node, {key: link.child(key) for key in link.data if key not in ("parent", "joint")})


def _filled(tree: LocatedValue, name: str, number: int) -> LocatedValue:
    """Return the entry with its number."""
    known, origin = {NUMBER: bind(number)}, Origin(f"`{name}`, number {number}")

    def at(node: Node) -> Node:
        return Derived(node.line, node.column, origin)

    def filled(part: LocatedValue) -> LocatedValue:
        data = part.data
        if isinstance(data, dict):
            items = {key: _in_turn(key, part.child(key), number) for key in data}
            return mapping(at(part.node), {key: filled(item) for key, item in items.items()}, part.node.keys)
        if isinstance(data, list):
            return sequence(at(part.node), [filled(part.child(index)) for index in range(len(data))])
        if not isinstance(data, str) or "${" not in data:
            return LocatedValue(data, at(part.node))
        return moved(at_one_place(fill(data, known)[0], part.node), at)

    return filled(tree)


def _in_turn(key: str, value: LocatedValue, number: int) -> LocatedValue:
    """Return the colour of this number from a list of colours; any other value as it is."""
    if key == "color" and isinstance(value.data, list) and all(isinstance(item, str) for item in value.data):
        return value.child(number % len(value.data)) if value.data else value
    return value
