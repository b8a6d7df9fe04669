"""Bounded values of expressions: numbers, text, booleans and lists of these."""

from typing import Any, TypeGuard

Value = bool | int | float | str | list[Any]

MAX_NUMBER = 1e15
MIN_NUMBER = 1e-30
"""Smallest magnitude of a number other than 0; division by less overflows."""
MAX_ITEMS = 10_000


class ExpressionError(ValueError):
    """An expression that is invalid or has no value."""

    def __init__(self, message: str, hint: str | None = None, rule: str = "expression") -> None:
        super().__init__(message)
        self.hint = hint
        self.rule = rule


def is_number(value: object) -> TypeGuard[int | float]:
    """Return whether a value is a number; booleans are not."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def number(value: object) -> int | float:
    """Return the value, if it is a number and not a boolean.

    Raises:
        ExpressionError: If it is not a number.
    """
    if not is_number(value):
        raise ExpressionError(f"{show(value)} is not a number")
    return value


def bounded(value: int | float) -> int | float:
    """Return the number, if it is finite and not too large; 0 if it is smaller than `MIN_NUMBER`.

    Raises:
        ExpressionError: If it is nan or too large.
    """
    if not abs(value) <= MAX_NUMBER:
        raise ExpressionError(f"the result is larger than {MAX_NUMBER:g}")
    return value if abs(value) >= MIN_NUMBER else type(value)(0)


def bounded_list(items: list[Any]) -> list[Any]:
    """Return the list, if it has at most `MAX_ITEMS` items, counting those of nested lists.

    Raises:
        ExpressionError: If it has more.
    """
    if count_items(items) > MAX_ITEMS:
        raise ExpressionError(f"the list has more than {MAX_ITEMS} items")
    return items


def count_items(value: object) -> int:
    """Return the number of values in a list and its nested lists; counting stops soon after `MAX_ITEMS`."""
    if not isinstance(value, list):
        return 1
    total = 0
    for item in value:
        total += count_items(item)
        if total > MAX_ITEMS:
            break
    return total


def truth(value: Value) -> bool:
    """Return whether a condition holds.

    Raises:
        ExpressionError: If it is neither a boolean nor a number.
    """
    if isinstance(value, bool | int | float):
        return bool(value)
    raise ExpressionError(f"{show(value)} is neither true nor false")


def show(value: object) -> str:
    """Return a value as messages show it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        return "a list"
    if isinstance(value, str):
        return f"the text '{value[:40]}'"
    return str(value)
