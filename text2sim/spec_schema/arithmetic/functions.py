"""Functions that expressions may call."""

import math
from collections.abc import Callable
from typing import Any

from text2sim.spec_schema.arithmetic.values import ExpressionError, Value, bounded, number, show


def _spread(arguments: list[Any]) -> list[int | float]:
    """Return the arguments as numbers, or those in the only argument if that is a list."""
    items = arguments[0] if len(arguments) == 1 and isinstance(arguments[0], list) else arguments
    if not items:
        raise ExpressionError("the list is empty")
    return [number(item) for item in items]


def _length(value: Value) -> int:
    if isinstance(value, list | str):
        return len(value)
    raise ExpressionError(f"only lists and text have a length (got {show(value)})")


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
_OF_LISTS: dict[str, Callable[[list[int | float]], int | float]] = {"min": min, "max": max, "sum": sum}
FUNCTIONS = (*_OF_NUMBERS, *_OF_LISTS, "len")


def call(name: str, arguments: list[Value]) -> Value:
    """Call a function of the list.

    Raises:
        ExpressionError: If the arguments are invalid, or there is no value.
    """
    if name == "len":
        if len(arguments) != 1:
            raise ExpressionError("len takes one list")
        return _length(arguments[0])
    if name in _OF_LISTS:
        if not arguments:
            raise ExpressionError(f"{name} takes numbers, or one list of numbers")
        return bounded(_OF_LISTS[name](_spread(arguments)))
    function, fewest, most = _OF_NUMBERS[name]
    if not fewest <= len(arguments) <= most:
        wanted = str(fewest) if fewest == most else f"{fewest} to {most}"
        noun = "argument" if most == 1 else "arguments"
        raise ExpressionError(f"{name} takes {wanted} {noun} (got {len(arguments)})")
    numbers = [number(argument) for argument in arguments]
    try:
        return bounded(function(*numbers))
    except (ValueError, ZeroDivisionError) as error:
        if isinstance(error, ExpressionError):
            raise
        shown = ", ".join(f"{n:g}" for n in numbers)
        raise ExpressionError(f"{name}({shown}) has no value") from None
