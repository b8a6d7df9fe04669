"""Numbers as the rules of this folder say them."""

import math


def no_larger(value: float) -> str:
    """Return a number of two digits that is no larger."""
    digit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return f"{math.floor(value / digit + 1e-9) * digit:.2g}"
