"""Expressions: the arithmetic of `${…}`, checked and evaluated without running code.

Python's parser parses an expression, every node is checked against a short list, and an interpreter evaluates the tree
with bounded values. Names are parameters, copy variables, `pi`, `tau`, `true` and `false`.
"""

import ast
import warnings
from collections.abc import Mapping
from functools import lru_cache

from text2sim.spec_schema.arithmetic.evaluation import BINARY, COMPARISONS, CONSTANTS, evaluate
from text2sim.spec_schema.arithmetic.functions import FUNCTIONS
from text2sim.spec_schema.arithmetic.values import MAX_NUMBER, ExpressionError, Value, bounded
from text2sim.spec_schema.errors import nearest

RESERVED = frozenset(CONSTANTS) | frozenset(FUNCTIONS)
"""Names that parameters cannot have."""

MAX_LENGTH = 500
MAX_DEPTH = 30
MAX_COMPOSED = (5000, 100)
"""Length and depth of composed expressions: those of prefabs with their arguments."""


class Expression:
    """One checked expression.

    Attributes:
        text: The text between the braces.
        tree: Its syntax tree.
        names: Parameters and copy variables that it uses.
    """

    __slots__ = ("names", "text", "tree")

    def __init__(self, text: str, limits: tuple[int, int] = (MAX_LENGTH, MAX_DEPTH)) -> None:
        self.text = text
        self.tree, self.names = _parse(text, *limits)

    def evaluate(self, names: Mapping[str, Value]) -> Value:
        """Return the value, with these values of names.

        Raises:
            ExpressionError: If a name is unknown, types do not fit, or the result is not a finite number.
        """
        try:
            return evaluate(self.tree, names)
        except OverflowError:
            raise ExpressionError(f"the result is larger than {MAX_NUMBER:g}") from None


@lru_cache(maxsize=4096)
def parse_expression(text: str, composed: bool = False) -> Expression:
    """Parse and check the text of an expression, without `${` and `}`.

    Args:
        text: The text.
        composed: Whether it may be as large as a composed one.
    """
    return Expression(text, MAX_COMPOSED) if composed else Expression(text)


_ALLOWED: set[type[ast.AST]] = {
    ast.BinOp,
    ast.UnaryOp,
    ast.BoolOp,
    ast.Compare,
    ast.IfExp,
    ast.Call,
    ast.Subscript,
    ast.List,
    ast.Name,
    ast.Constant,
}
_SIGNS = {*BINARY, *COMPARISONS, ast.UAdd, ast.USub, ast.Not, ast.And, ast.Or}
_PARTS = {kind: [field for field in kind._fields if field not in ("func", "keywords", "ctx")] for kind in _ALLOWED}
"""Fields of each node that are checked; `_check_call` checks the others of a call."""
_HINTS: dict[type[ast.AST], str] = {
    ast.Tuple: "write a list, [a, b]",
    ast.Slice: "use one item, a[0]",
    ast.Attribute: "names have no dots",
    ast.BitXor: "write a power as a ** b",
    ast.Dict: "there are no mappings",
    ast.In: "compare with ==",
    ast.Is: "compare with ==",
    ast.NamedExpr: "there are no assignments",
    ast.Lambda: "there are no function definitions",
    ast.ListComp: "write the items out",
    ast.JoinedStr: "write text with ${…} in it",
}


def _parse(text: str, length: int, depth: int) -> tuple[ast.expr, frozenset[str]]:
    if len(text) > length:
        raise ExpressionError(f"the expression is longer than {length} characters")
    if not text.strip():
        raise ExpressionError("there is nothing between the braces")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            tree = ast.parse(" ".join(text.split()), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise ExpressionError(f"`{text.strip()}` is not arithmetic") from None
    names: set[str] = set()
    _check(tree, text, (1, depth), names)
    return tree, frozenset(names)


def _check(node: ast.AST, text: str, depth: tuple[int, int], names: set[str]) -> None:
    """Refuse nodes that are not allowed or too deep, and collect the names."""
    kind = type(node)
    if kind in _SIGNS:
        return
    if kind not in _PARTS:
        hint = f"; {_HINTS[kind]}" if kind in _HINTS else ""
        raise ExpressionError(f"`{_snippet(node, text)}` is not part of the language{hint}")
    at, most = depth
    if at > most:
        raise ExpressionError(f"the expression is nested more than {most} deep")
    if isinstance(node, ast.Constant):
        return _check_constant(node.value)
    if isinstance(node, ast.Name):
        return _check_name(node.id, text, names)
    if isinstance(node, ast.Call):
        _check_call(node, text)
    for field in _PARTS[kind]:
        child = getattr(node, field)
        for item in child if isinstance(child, list) else [child]:
            _check(item, text, (at + 1, most), names)


def _check_name(name: str, text: str, names: set[str]) -> None:
    if name not in text:
        # Python normalises look-alike letters to ASCII; the name must be as written.
        raise ExpressionError(f"`{text.strip()}` has letters that only look like those of a name")
    if name in FUNCTIONS:
        raise ExpressionError(f"`{name}` is a function: write {name}(…)")
    if name not in RESERVED:
        names.add(name)


def _check_call(node: ast.Call, text: str) -> None:
    if not isinstance(node.func, ast.Name):
        raise ExpressionError(f"`{_snippet(node.func, text)}` is not a function")
    if node.func.id not in FUNCTIONS:
        message = f"unknown function `{node.func.id}`; there are {', '.join(FUNCTIONS)}"
        raise ExpressionError(message, nearest(node.func.id, FUNCTIONS), "unknown-function")
    if node.keywords:
        raise ExpressionError(f"`{node.func.id}` takes no named arguments")


def _snippet(node: ast.AST, text: str) -> str:
    found = ast.get_source_segment(" ".join(text.split()), node) if isinstance(node, ast.expr) else None
    return found or text.strip()


def _check_constant(value: object) -> None:
    if isinstance(value, bool | str):
        return
    if isinstance(value, int | float):
        bounded(value)
    else:
        raise ExpressionError(f"`{value!r}` is neither a number nor text")
