"""The body of a prefab with arguments in the place of its parameters, counted while it grows."""

from collections.abc import Callable, Mapping
from typing import Any

from text2sim.spec_schema.arithmetic.interpolation import parse_interpolation
from text2sim.spec_schema.arithmetic.resolution import COPY_VARIABLES
from text2sim.spec_schema.arithmetic.values import ExpressionError
from text2sim.spec_schema.reuse.substitution import BoundParameter, bind, fill
from text2sim.spec_schema.reuse.trees import LocatedValue, count, mapping, moved
from text2sim.spec_schema.text.document import Node, Origin, sites_of
from text2sim.spec_schema.text.nodes import Derived

_ONE_COPY = {name: bind(value) for name, value in COPY_VARIABLES.items()}
"""What the copy variables are for a body without copies."""


class Filler:
    """Fills bodies of prefabs, until there are too many of them."""

    def __init__(self, nodes: int, text: int) -> None:
        self.nodes = nodes
        """As many values may still be made."""
        self.text = text
        """As many characters of expressions."""

    def fill(
        self,
        tree: LocatedValue,
        values: Mapping[str, BoundParameter],
        place: tuple[int, int],
        origin: Callable[[Node], Origin],
    ) -> LocatedValue:
        """Put arguments in the place of parameters.

        Args:
            tree: Something of a prefab.
            values: What stands for each parameter.
            place: Line and column that everything in it gets.
            origin: Says where a node of the prefab stands.

        Raises:
            ExpressionError: If an argument cannot stand where it should, or all that was filled is too much.
        """
        self._count(1)
        data = tree.data
        node = Derived(*place, origin(tree.node))
        if isinstance(data, dict):
            parts = {key: self.fill(tree.child(key), values, place, origin) for key in data}
            return mapping(node, parts, dict.fromkeys(parts, place))
        if isinstance(data, list):
            items = [self.fill(tree.child(index), values, place, origin) for index in range(len(data))]
            node.children = [item.node for item in items]
            return LocatedValue([item.data for item in items], node)
        if not isinstance(data, str) or "${" not in data:
            return LocatedValue(data, node)
        try:
            value, given = fill(data, values, self._spend)
        except ExpressionError as error:
            raise ExpressionError(f"{error} ({node.origin})", error.hint, error.rule) from None
        if given is not None:
            return self._given(LocatedValue(value, given), node)
        self._count(count(value))
        return at_one_place(value, node)

    def _given(self, tree: LocatedValue, node: Derived) -> LocatedValue:
        """An argument that stands alone: at its own place, but from where it went."""
        self._count(count(tree.data))
        origin = node.origin
        assert origin is not None
        return moved(tree, lambda found: Derived(found.line, found.column, origin))

    def _count(self, more: int) -> None:
        self.nodes -= more
        if self.nodes < 0:
            raise ExpressionError("prefabs make the case too large", rule="too-large")

    def _spend(self, size: int) -> None:
        self.text -= size
        if self.text < 0:
            raise ExpressionError("the expressions of prefabs become too long", rule="too-large")


def settle(tree: LocatedValue) -> LocatedValue:
    """Give a body without copies the values that copy variables have for one: it uses none of its own.

    Only what came from a prefab is touched: what the case itself says is for its author to put right.
    """
    if not isinstance(tree.data, dict) or tree.data.get("repeat") is not None or not sites_of(tree.data):
        return tree
    return _settled(tree)


def _settled(tree: LocatedValue) -> LocatedValue:
    data = tree.data
    if isinstance(data, dict):
        parts = {key: _settled(tree.child(key)) for key in data}
        return mapping(tree.node, parts)
    if isinstance(data, list):
        items = [_settled(tree.child(index)) for index in range(len(data))]
        node = tree.node.copy()
        node.children = [item.node for item in items]
        return LocatedValue([item.data for item in items], node)
    if isinstance(data, str) and "${" in data and tree.node.origin is not None:
        try:
            if parse_interpolation(data, True).names & COPY_VARIABLES.keys():
                return at_one_place(fill(data, _ONE_COPY)[0], tree.node)
        except ExpressionError:
            return tree  # it is reported where all expressions are
    return tree


def at_one_place(value: Any, node: Node) -> LocatedValue:
    """Return a value that was worked out as located data, all of it at one place."""
    found = node.copy()
    if isinstance(value, list):
        found.children = [at_one_place(item, node).node for item in value]
    return LocatedValue(value, found)
