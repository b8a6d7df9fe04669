"""Values of expressions: numbers, text, booleans and lists of these, all of them bounded."""

from typing import Any

Value = bool | int | float | str | list[Any]

MAX_NUMBER = 1e15
MIN_NUMBER = 1e-30
"""Least magnitude of a number that is not 0: nothing in a scene is so small, and to divide by less overflows."""
MAX_ITEMS = 10_000


class ExpressionError(ValueError):
    """An expression that cannot be understood or has no value."""

    def __init__(self, message: str, hint: str | None = None, rule: str = "expression") -> None:
        super().__init__(message)
        self.hint = hint
        self.rule = rule


def number(value: object) -> int | float:
    """Return the value, if it is a number; booleans are none.

    Raises:
        ExpressionError: If it is not a number.
    """
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ExpressionError(f"{show(value)} is not a number")
    return value


def bounded(value: int | float) -> int | float:
    """Return the number, if it is finite and not too large; 0 for what rounding has left of it.

    Raises:
        ExpressionError: If it is nan or too large.
    """
    if not abs(value) <= MAX_NUMBER:
        raise ExpressionError(f"the result is larger than {MAX_NUMBER:g}")
    return value if abs(value) >= MIN_NUMBER else type(value)(0)


def bounded_list(items: list[Any]) -> list[Any]:
    """Return the list, if it is not too long: lists of lists of lists grow fast.

    Raises:
        ExpressionError: If it holds more.
    """
    if count_items(items) > MAX_ITEMS:
        raise ExpressionError(f"the list has more than {MAX_ITEMS} items")
    return items


def count_items(value: object) -> int:
    """Return how many values there are in a list and the lists inside it; counting stops soon after `MAX_ITEMS`."""
    if not isinstance(value, list):
        return 1
    total = 0
    for item in value:
        total += count_items(item)
        if total > MAX_ITEMS:
            break
    return total


def truth(value: Value) -> bool:
    """Whether a condition holds.

    Raises:
        ExpressionError: If it is neither a boolean nor a number.
    """
    if isinstance(value, bool | int | float):
        return bool(value)
    raise ExpressionError(f"{show(value)} is neither true nor false")


def show(value: object) -> str:
    """Name a value in a message."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        return "a list"
    if isinstance(value, str):
        return f"the text '{value[:40]}'"
    return str(value)
