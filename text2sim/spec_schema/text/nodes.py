"""Positions: where values stand in a file, and where those come from that do not."""

from dataclasses import dataclass

Step = str | int
Path = tuple[Step, ...]


class Node:
    """Where a value stands, and where the values inside it stand.

    Attributes:
        line: Line of its first character, from 1.
        column: Column of its first character, from 1.
        children: Nodes by key, or in order; None for a scalar.
        keys: Line and column of each key of a mapping.
    """

    __slots__ = ("children", "column", "keys", "line")

    origin: "Origin | None" = None
    """Where it really comes from, if that is not the place in the file."""

    def __init__(self, line: int, column: int) -> None:
        self.line = line
        self.column = column
        self.children: dict[str, Node] | list[Node] | None = None
        self.keys: dict[str, tuple[int, int]] = {}

    def copy(self) -> "Node":
        """Return a node of its own at the same place, with the same children."""
        node = Node(self.line, self.column) if self.origin is None else Derived(self.line, self.column, self.origin)
        node.children, node.keys = self.children, self.keys
        return node


@dataclass(frozen=True)
class Origin:
    """Where a value comes from that does not stand in the file itself; a message gets it as its end."""

    text: str
    file: str = ""
    line: int = 0
    outer: "Origin | None" = None
    """Where the text comes from that took this one in."""

    def __str__(self) -> str:
        place = f", {self.file}:{self.line}" if self.file else ""
        outer, between = self.outer, 0
        while outer is not None and outer.outer is not None:
            outer, between = outer.outer, between + 1
        return f"{self.text}{place}{', …' if between else ''}" + (f", {outer}" if outer is not None else "")


class Derived(Node):
    """The node of a value that does not stand in the file itself, at the place that brought it in."""

    __slots__ = ("origin",)

    def __init__(self, line: int, column: int, origin: Origin) -> None:
        super().__init__(line, column)
        self.origin = origin
