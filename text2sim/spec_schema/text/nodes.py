"""Positions of values in a file, and origins of values that are not written there."""

from dataclasses import dataclass

Step = str | int
Path = tuple[Step, ...]


class Node:
    """Position of a value and of the values inside it.

    Attributes:
        line: Line of its first character, from 1.
        column: Column of its first character, from 1.
        children: Nodes by key, or in order; None for a scalar.
        keys: Line and column of each key of a mapping.
    """

    __slots__ = ("children", "column", "keys", "line")

    origin: "Origin | None" = None
    """Where it comes from, if not from its position in the file."""

    def __init__(self, line: int, column: int) -> None:
        self.line = line
        self.column = column
        self.children: dict[str, Node] | list[Node] | None = None
        self.keys: dict[str, tuple[int, int]] = {}

    def copy(self) -> "Node":
        """Return a new node at the same position, with the same children."""
        node = Node(self.line, self.column) if self.origin is None else Derived(self.line, self.column, self.origin)
        node.children, node.keys = self.children, self.keys
        return node


@dataclass(frozen=True)
class Origin:
    """Source of a value that is not in the file itself; messages end with it."""

    text: str
    file: str = ""
    line: int = 0
    outer: "Origin | None" = None
    """Origin of the text that includes this one."""

    def __str__(self) -> str:
        place = f", {self.file}:{self.line}" if self.file else ""
        outer, skipped = self.outer, False
        while outer is not None and outer.outer is not None:
            outer, skipped = outer.outer, True
        return f"{self.text}{place}{', …' if skipped else ''}" + (f", {outer}" if outer is not None else "")


class Derived(Node):
    """Node of a value that is not in the file itself, at the position of its use."""

    __slots__ = ("origin",)

    def __init__(self, line: int, column: int, origin: Origin) -> None:
        super().__init__(line, column)
        self.origin = origin
