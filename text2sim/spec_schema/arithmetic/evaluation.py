"""Interpreter of checked expressions, with bounded values."""

import ast
import math
from collections.abc import Callable, Mapping
from typing import Any

from text2sim.spec_schema.arithmetic.functions import call
from text2sim.spec_schema.arithmetic.values import (
    MAX_NUMBER,
    ExpressionError,
    Value,
    bounded,
    bounded_list,
    number,
    show,
    truth,
)
from text2sim.spec_schema.errors import nearest, there_are

CONSTANTS: dict[str, Value] = {"pi": math.pi, "tau": math.tau, "true": True, "false": False}

BINARY: dict[type[ast.AST], str] = {
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.Div: "/",
    ast.FloorDiv: "//",
    ast.Mod: "%",
    ast.Pow: "**",
}
COMPARISONS: dict[type[ast.AST], Callable[[Any, Any], bool]] = {
    ast.Eq: lambda a, b: a == b,
    ast.NotEq: lambda a, b: a != b,
    ast.Lt: lambda a, b: a < b,
    ast.LtE: lambda a, b: a <= b,
    ast.Gt: lambda a, b: a > b,
    ast.GtE: lambda a, b: a >= b,
}


def evaluate(node: ast.expr, names: Mapping[str, Value]) -> Value:
    """Return the value of a checked tree; see `Expression.evaluate`.

    Raises:
        ExpressionError: If the expression has no value.
    """
    if isinstance(node, ast.Constant):
        return node.value  # type: ignore[return-value]  # checked by _check_constant
    if isinstance(node, ast.Name):
        return _name(node.id, names)
    if isinstance(node, ast.BinOp):
        return _binary(node, evaluate(node.left, names), evaluate(node.right, names))
    if isinstance(node, ast.UnaryOp):
        value = evaluate(node.operand, names)
        if isinstance(node.op, ast.Not):
            return not truth(value)
        return -number(value) if isinstance(node.op, ast.USub) else number(value)
    if isinstance(node, ast.Compare):
        return _compare(node, names)
    if isinstance(node, ast.BoolOp):
        wanted = isinstance(node.op, ast.Or)
        return wanted if any(truth(evaluate(v, names)) is wanted for v in node.values) else not wanted
    if isinstance(node, ast.IfExp):
        return evaluate(node.body if truth(evaluate(node.test, names)) else node.orelse, names)
    if isinstance(node, ast.List):
        return bounded_list([evaluate(item, names) for item in node.elts])
    if isinstance(node, ast.Subscript):
        return _item(evaluate(node.value, names), evaluate(node.slice, names))
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
        return call(node.func.id, [evaluate(argument, names) for argument in node.args])
    raise ExpressionError(f"{type(node).__name__} is not part of the language")


def _name(name: str, names: Mapping[str, Value]) -> Value:
    if name in CONSTANTS:
        return CONSTANTS[name]
    if name not in names:
        known = list(names)
        known_names = there_are(known) if known else "; there are no names here: add it to `params`"
        raise ExpressionError(
            f"unknown name `{name}`{known_names}", nearest(name, [*known, *CONSTANTS]), "unknown-name"
        )
    return names[name]


def _binary(node: ast.BinOp, left: Value, right: Value) -> Value:
    sign = BINARY[type(node.op)]
    for value in (left, right):
        if isinstance(value, list):
            raise ExpressionError(f"`{sign}` works on numbers, not on lists; use items, a[0] {sign} b[0]")
    a, b = number(left), number(right)
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
        # Half of six is the integer three, so that it can be a count.
        exact = isinstance(a, int) and isinstance(b, int) and a % b == 0
        result = a // b if exact else a / b
    else:
        result = a // b if sign == "//" else a % b
    return bounded(result)


def _power(base: float, exponent: float) -> float:
    if base < 0 and exponent != int(exponent):
        raise ExpressionError("a negative number has no fractional power")
    if base == 0 and exponent < 0:
        raise ExpressionError("division by zero")
    # The magnitude is checked first, so that 9 ** 9 ** 9 is never computed.
    if base != 0 and exponent * math.log10(abs(base)) > math.log10(MAX_NUMBER):
        raise ExpressionError(f"the result is larger than {MAX_NUMBER:g}")
    if abs(base) <= 1 or abs(exponent) > 1000:
        return math.pow(base, exponent) if isinstance(base, float) or exponent < 0 else int(math.pow(base, exponent))
    return base**exponent


def _compare(node: ast.Compare, names: Mapping[str, Value]) -> bool:
    left = evaluate(node.left, names)
    for operator, operand in zip(node.ops, node.comparators, strict=True):
        right = evaluate(operand, names)
        if not isinstance(operator, ast.Eq | ast.NotEq) and not (isinstance(left, str) and isinstance(right, str)):
            left, right = number(left), number(right)
        if not COMPARISONS[type(operator)](left, right):
            return False
        left = right
    return True


def _item(value: Value, index: Value) -> Value:
    if not isinstance(value, list):
        raise ExpressionError(f"only lists have items (got {show(value)})")
    if isinstance(index, bool) or not isinstance(index, int):
        raise ExpressionError(f"an index is a whole number (got {show(index)})")
    if not -len(value) <= index < len(value):
        raise ExpressionError(f"there is no item {index}: the list has {len(value)} (0 to {len(value) - 1})")
    return value[index]
