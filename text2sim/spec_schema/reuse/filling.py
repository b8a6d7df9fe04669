"""Bodies of prefabs with arguments in place of parameters, within limits of size."""

from collections.abc import Callable, Mapping
from typing import Any

from text2sim.spec_schema.arithmetic.interpolation import parse_interpolation
from text2sim.spec_schema.arithmetic.resolution import COPY_VARIABLES
from text2sim.spec_schema.arithmetic.values import ExpressionError
from text2sim.spec_schema.reuse.substitution import BoundParameter, bind, fill
from text2sim.spec_schema.reuse.trees import LocatedValue, count, mapping, moved, sequence
from text2sim.spec_schema.text.document import Node, Origin, sites_of
from text2sim.spec_schema.text.nodes import Derived

_ONE_COPY = {name: bind(value) for name, value in COPY_VARIABLES.items()}
"""Copy variables of a body without copies."""


class Filler:
    """Replacement of parameters in bodies of prefabs, with a budget."""

    def __init__(self, nodes: int, text: int) -> None:
        self.nodes = nodes
        """Remaining values."""
        self.text = text
        """Remaining characters of expressions."""

    def fill(
        self,
        tree: LocatedValue,
        values: Mapping[str, BoundParameter],
        place: tuple[int, int],
        origin: Callable[[Node], Origin],
    ) -> LocatedValue:
        """Return a part of a prefab with arguments in place of parameters.

        Args:
            tree: The part.
            values: Arguments by parameter.
            place: Line and column for all its nodes.
            origin: Returns the origin of a node of the prefab.

        Raises:
            ExpressionError: If an argument is invalid in its position, or the budget is exhausted.
        """
        self._count(1)
        data = tree.data
        node = Derived(*place, origin(tree.node))
        if isinstance(data, dict):
            parts = {key: self.fill(tree.child(key), values, place, origin) for key in data}
            return mapping(node, parts, dict.fromkeys(parts, place))
        if isinstance(data, list):
            return sequence(node, [self.fill(tree.child(k), values, place, origin) for k in range(len(data))])
        if not isinstance(data, str) or "${" not in data:
            return LocatedValue(data, node)
        try:
            value, given = fill(data, values, self._spend)
        except ExpressionError as error:
            raise ExpressionError(f"{error} ({node.origin})", error.hint, error.rule) from None
        self._count(count(value))
        if given is None:
            return at_one_place(value, node)
        # An argument as a whole keeps its own position, but has the origin of its use.
        own = node.origin
        assert own is not None
        return moved(LocatedValue(value, given), lambda found: Derived(found.line, found.column, own))

    def _count(self, more: int) -> None:
        self.nodes -= more
        if self.nodes < 0:
            raise ExpressionError("prefabs make the case too large", rule="too-large")

    def _spend(self, size: int) -> None:
        self.text -= size
        if self.text < 0:
            raise ExpressionError("the expressions of prefabs become too long", rule="too-large")


def settle(tree: LocatedValue) -> LocatedValue:
    """Return a body without copies with its copy variables replaced.

    Only values from a prefab are replaced; copy variables in the case itself are errors.
    """
    if not isinstance(tree.data, dict) or tree.data.get("repeat") is not None or not sites_of(tree.data):
        return tree
    return _settled(tree)


def _settled(tree: LocatedValue) -> LocatedValue:
    data = tree.data
    if isinstance(data, dict):
        return mapping(tree.node, {key: _settled(tree.child(key)) for key in data})
    if isinstance(data, list):
        return sequence(tree.node, [_settled(tree.child(index)) for index in range(len(data))])
    if isinstance(data, str) and "${" in data and tree.node.origin is not None:
        try:
            if parse_interpolation(data, True).names & COPY_VARIABLES.keys():
                return at_one_place(fill(data, _ONE_COPY)[0], tree.node)
        except ExpressionError:
            return tree  # reported with all expressions
    return tree


def at_one_place(value: Any, node: Node) -> LocatedValue:
    """Return a value as located data, all at one position."""
    found = node.copy()
    if isinstance(value, list):
        found.children = [at_one_place(item, node).node for item in value]
    return LocatedValue(value, found)
