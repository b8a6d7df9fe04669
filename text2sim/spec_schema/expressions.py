"""Expressions: the arithmetic of `${…}`, checked and evaluated without running any code.

An expression is parsed by Python's own parser, every node is checked against a short list, and the tree is then
walked by an interpreter that bounds what it makes. Names are parameters, copy variables, `pi`, `tau`, `true`
and `false`.
"""

import ast
import math
import warnings
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any

from text2sim.spec_schema.errors import nearest

Value = bool | int | float | str | list[Any]

MAX_LENGTH = 500
MAX_DEPTH = 30
MAX_NUMBER = 1e15
MAX_ITEMS = 10_000

CONSTANTS: dict[str, Value] = {"pi": math.pi, "tau": math.tau, "true": True, "false": False}


class ExpressionError(ValueError):
    """An expression that cannot be understood or has no value."""

    def __init__(self, message: str, hint: str | None = None, rule: str = "expression") -> None:
        super().__init__(message)
        self.hint = hint
        self.rule = rule


class Expression:
    """One checked expression.

    Attributes:
        text: What was written between the braces.
        names: Parameters and copy variables that it uses.
    """

    __slots__ = ("_tree", "names", "text")

    def __init__(self, text: str) -> None:
        self.text = text
        self._tree = _parse(text)
        self.names = frozenset(
            node.id for node in ast.walk(self._tree) if isinstance(node, ast.Name) and node.id not in RESERVED
        )

    def evaluate(self, names: Mapping[str, Value]) -> Value:
        """Return the value.

        Args:
            names: What every name stands for.

        Raises:
            ExpressionError: If a name is unknown, types do not fit, or the result is not a finite number.
        """
        try:
            return _evaluate(self._tree, names)
        except OverflowError:
            raise ExpressionError(f"the result is larger than {MAX_NUMBER:g}") from None


@lru_cache(maxsize=4096)
def parse_expression(text: str) -> Expression:
    """Parse and check the text of an expression, without `${` and `}`."""
    return Expression(text)


# --- parsing --------------------------------------------------------------------------------------------------

_BINARY: dict[type[ast.AST], str] = {
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.Div: "/",
    ast.FloorDiv: "//",
    ast.Mod: "%",
    ast.Pow: "**",
}
_COMPARISONS: dict[type[ast.AST], Callable[[Any, Any], bool]] = {
    ast.Eq: lambda a, b: a == b,
    ast.NotEq: lambda a, b: a != b,
    ast.Lt: lambda a, b: a < b,
    ast.LtE: lambda a, b: a <= b,
    ast.Gt: lambda a, b: a > b,
    ast.GtE: lambda a, b: a >= b,
}
_ALLOWED = (
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
    *_BINARY,
    *_COMPARISONS,
    ast.UAdd,
    ast.USub,
    ast.Not,
    ast.And,
    ast.Or,
    ast.Load,
)
_HINTS: dict[type[ast.AST], str] = {
    ast.Tuple: "write a list, [a, b]",
    ast.Slice: "take one item, a[0]",
    ast.Attribute: "names have no dots",
    ast.BitXor: "a power is written a ** b",
    ast.Dict: "there are no mappings",
    ast.In: "compare with ==",
    ast.Is: "compare with ==",
    ast.NamedExpr: "nothing can be assigned",
    ast.Lambda: "functions cannot be made",
    ast.ListComp: "write the items out",
    ast.JoinedStr: "write text with ${…} in it",
}


def _parse(text: str) -> ast.expr:
    if len(text) > MAX_LENGTH:
        raise ExpressionError(f"the expression is longer than {MAX_LENGTH} characters")
    if not text.strip():
        raise ExpressionError("there is nothing between the braces")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            tree = ast.parse(" ".join(text.split()), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise ExpressionError(f"`{text.strip()}` is not arithmetic") from None
    _check(tree, text, 1)
    return tree


def _check(node: ast.AST, text: str, depth: int) -> None:
    if depth > MAX_DEPTH:
        raise ExpressionError(f"the expression is nested more than {MAX_DEPTH} deep")
    if not isinstance(node, _ALLOWED):
        way_out = next((f"; {hint}" for kind, hint in _HINTS.items() if isinstance(node, kind)), "")
        raise ExpressionError(f"`{_snippet(node, text)}` is not part of the language{way_out}")
    if isinstance(node, ast.Constant):
        _check_constant(node.value)
    elif isinstance(node, ast.Name) and node.id not in text:
        # Python folds look-alike letters into plain ones: what is read must be what is written.
        raise ExpressionError(f"`{text.strip()}` has letters that only look like those of a name")
    elif isinstance(node, ast.Call):
        if not isinstance(node.func, ast.Name):
            raise ExpressionError(f"`{_snippet(node.func, text)}` is not a function")
        if node.func.id not in FUNCTIONS:
            message = f"unknown function `{node.func.id}`; there are {', '.join(FUNCTIONS)}"
            raise ExpressionError(message, nearest(node.func.id, FUNCTIONS), "unknown-function")
        if node.keywords:
            raise ExpressionError(f"`{node.func.id}` takes no named arguments")
    elif isinstance(node, ast.Name) and node.id in FUNCTIONS:
        raise ExpressionError(f"`{node.id}` is a function: write {node.id}(…)")
    for field, child in ast.iter_fields(node):
        if isinstance(node, ast.Call) and field == "func":
            continue
        for item in child if isinstance(child, list) else [child]:
            if isinstance(item, ast.AST):
                _check(item, text, depth + 1)


def _snippet(node: ast.AST, text: str) -> str:
    found = ast.get_source_segment(" ".join(text.split()), node) if isinstance(node, ast.expr) else None
    return found or text.strip()


def _check_constant(value: object) -> None:
    if isinstance(value, bool | str):
        return
    if isinstance(value, int | float):
        _bounded(value)
    else:
        raise ExpressionError(f"`{value!r}` is neither a number nor text")


# --- evaluation -----------------------------------------------------------------------------------------------


def _evaluate(node: ast.expr, names: Mapping[str, Value]) -> Value:
    if isinstance(node, ast.Constant):
        return node.value  # type: ignore[return-value]  # _check_constant has seen it
    if isinstance(node, ast.Name):
        return _name(node.id, names)
    if isinstance(node, ast.BinOp):
        return _binary(node, _evaluate(node.left, names), _evaluate(node.right, names))
    if isinstance(node, ast.UnaryOp):
        value = _evaluate(node.operand, names)
        if isinstance(node.op, ast.Not):
            return not _truth(value)
        number = _number(value)
        return -number if isinstance(node.op, ast.USub) else number
    if isinstance(node, ast.Compare):
        return _compare(node, names)
    if isinstance(node, ast.BoolOp):
        wanted = isinstance(node.op, ast.Or)
        return wanted if any(_truth(_evaluate(v, names)) is wanted for v in node.values) else not wanted
    if isinstance(node, ast.IfExp):
        return _evaluate(node.body if _truth(_evaluate(node.test, names)) else node.orelse, names)
    if isinstance(node, ast.List):
        return [_evaluate(item, names) for item in node.elts]
    if isinstance(node, ast.Subscript):
        return _item(_evaluate(node.value, names), _evaluate(node.slice, names))
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
        return _call(node.func.id, [_evaluate(argument, names) for argument in node.args])
    raise ExpressionError(f"{type(node).__name__} is not part of the language")


def _name(name: str, names: Mapping[str, Value]) -> Value:
    if name in CONSTANTS:
        return CONSTANTS[name]
    if name not in names:
        known = list(names)
        message = f"unknown name `{name}`" + (f"; there are {', '.join(known)}" if 0 < len(known) <= 12 else "")
        raise ExpressionError(message, nearest(name, [*known, *CONSTANTS]), "unknown-name")
    return names[name]


def _binary(node: ast.BinOp, left: Value, right: Value) -> Value:
    sign = _BINARY[type(node.op)]
    for value in (left, right):
        if isinstance(value, list):
            raise ExpressionError(f"`{sign}` works on numbers, not on lists; take items, a[0] {sign} b[0]")
    a, b = _number(left), _number(right)
    if sign == "+":
        result = a + b
    elif sign == "-":
        result = a - b
    elif sign == "*":
        result = a * b
    elif sign == "**":
        result = _power(a, b)
    elif b == 0:
        raise ExpressionError("division by zero")
    elif sign == "/":
        # Half of six is the whole number three, so that it can be a count.
        exact = isinstance(a, int) and isinstance(b, int) and a % b == 0
        result = a // b if exact else a / b
    else:
        result = a // b if sign == "//" else a % b
    return _bounded(result)


def _power(base: float, exponent: float) -> float:
    if base < 0 and exponent != int(exponent):
        raise ExpressionError("a negative number has no fractional power")
    if base == 0 and exponent < 0:
        raise ExpressionError("division by zero")
    # The size is known before the power is: 9 ** 9 ** 9 never gets computed.
    if base != 0 and exponent * math.log10(abs(base)) > math.log10(MAX_NUMBER):
        raise ExpressionError(f"the result is larger than {MAX_NUMBER:g}")
    if abs(base) <= 1 or abs(exponent) > 1000:
        return math.pow(base, exponent) if isinstance(base, float) or exponent < 0 else int(math.pow(base, exponent))
    return base**exponent


def _compare(node: ast.Compare, names: Mapping[str, Value]) -> bool:
    left = _evaluate(node.left, names)
    for operator, operand in zip(node.ops, node.comparators, strict=True):
        right = _evaluate(operand, names)
        if not isinstance(operator, ast.Eq | ast.NotEq) and not (isinstance(left, str) and isinstance(right, str)):
            left, right = _number(left), _number(right)
        if not _COMPARISONS[type(operator)](left, right):
            return False
        left = right
    return True


def _item(value: Value, index: Value) -> Value:
    if not isinstance(value, list):
        raise ExpressionError(f"only lists have items (got {_show(value)})")
    if isinstance(index, bool) or not isinstance(index, int):
        raise ExpressionError(f"an index is a whole number (got {_show(index)})")
    if not -len(value) <= index < len(value):
        raise ExpressionError(f"there is no item {index}: the list has {len(value)} (0 to {len(value) - 1})")
    return value[index]


def _truth(value: Value) -> bool:
    if isinstance(value, bool | int | float):
        return bool(value)
    raise ExpressionError(f"{_show(value)} is neither true nor false")


def _number(value: object) -> int | float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ExpressionError(f"{_show(value)} is not a number")
    return value


def _bounded(value: int | float) -> int | float:
    if not abs(value) <= MAX_NUMBER:
        raise ExpressionError(f"the result is larger than {MAX_NUMBER:g}")
    return value


def _show(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        return "a list"
    if isinstance(value, str):
        return f"the text '{value[:40]}'"
    return str(value)


# --- functions ------------------------------------------------------------------------------------------------


def _spread(arguments: list[Any]) -> list[int | float]:
    """The numbers to work on: the arguments, or those in the one list that was given."""
    items = arguments[0] if len(arguments) == 1 and isinstance(arguments[0], list) else arguments
    if not items:
        raise ExpressionError("the list is empty")
    return [_number(item) for item in items]


def _length(value: Value) -> int:
    if isinstance(value, list | str):
        return len(value)
    raise ExpressionError(f"only lists and text have a length (got {_show(value)})")


def _round(value: float, digits: int = 0) -> int | float:
    if isinstance(digits, float) or not 0 <= digits <= 15:
        raise ExpressionError("round takes 0 to 15 digits")
    return round(value, digits) if digits else round(value)


def _clamp(value: float, low: float, high: float) -> float:
    if low > high:
        raise ExpressionError(f"clamp needs its lower bound first (got {low:g} and {high:g})")
    return min(max(value, low), high)


_OF_NUMBERS: dict[str, tuple[Callable[..., int | float], int, int]] = {
    "sin": (math.sin, 1, 1),
    "cos": (math.cos, 1, 1),
    "tan": (math.tan, 1, 1),
    "asin": (math.asin, 1, 1),
    "acos": (math.acos, 1, 1),
    "atan": (math.atan, 1, 1),
    "atan2": (math.atan2, 2, 2),
    "sqrt": (math.sqrt, 1, 1),
    "exp": (math.exp, 1, 1),
    "log": (math.log, 1, 2),
    "abs": (lambda value: abs(value), 1, 1),
    "floor": (math.floor, 1, 1),
    "ceil": (math.ceil, 1, 1),
    "round": (_round, 1, 2),
    "radians": (math.radians, 1, 1),
    "degrees": (math.degrees, 1, 1),
    "hypot": (math.hypot, 1, 10),
    "clamp": (_clamp, 3, 3),
}
_OF_LISTS: dict[str, Callable[[list[Any]], int | float]] = {
    "min": lambda arguments: min(_spread(arguments)),
    "max": lambda arguments: max(_spread(arguments)),
    "sum": lambda arguments: sum(_spread(arguments)),
}
FUNCTIONS = (*_OF_NUMBERS, *_OF_LISTS, "len")
RESERVED = frozenset(CONSTANTS) | frozenset(FUNCTIONS)


def _call(name: str, arguments: list[Value]) -> Value:
    if name == "len":
        if len(arguments) != 1:
            raise ExpressionError("len takes one list")
        return _length(arguments[0])
    if name in _OF_LISTS:
        if not arguments:
            raise ExpressionError(f"{name} takes numbers, or one list of numbers")
        return _bounded(_OF_LISTS[name](arguments))
    function, fewest, most = _OF_NUMBERS[name]
    if not fewest <= len(arguments) <= most:
        wanted = str(fewest) if fewest == most else f"{fewest} to {most}"
        raise ExpressionError(f"{name} takes {wanted} arguments (got {len(arguments)})")
    numbers = [_number(argument) for argument in arguments]
    try:
        return _bounded(function(*numbers))
    except (ValueError, ZeroDivisionError) as error:
        if isinstance(error, ExpressionError):
            raise
        shown = ", ".join(f"{n:g}" for n in numbers)
        raise ExpressionError(f"{name}({shown}) has no value") from None
