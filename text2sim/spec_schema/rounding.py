"""Numbers of advice, rounded to the side on which it can be followed to the letter."""

from math import ceil, floor, log10


def at_least(value: float) -> str:
    """Return a value with two digits, rounded up."""
    if value <= 0.0:
        return "0"
    digit = 10.0 ** (floor(log10(value)) - 1)
    return f"{ceil(value / digit * (1 - 1e-9)) * digit:g}"


def at_most(value: float) -> str:
    """Return a positive value with two digits, rounded down."""
    digit = 10.0 ** (floor(log10(value)) - 1)
    return f"{floor(value / digit * (1 + 1e-9)) * digit:g}"
