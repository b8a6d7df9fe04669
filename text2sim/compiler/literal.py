"""Values as source text of a program.

Every ``{{ }}`` of every template passes `literal`. Data (whatever an author wrote) comes out as a literal that
cannot execute. A `Code` is source text of our own; only the compiler makes one.
"""

import math
import re
from typing import Any

_IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*\Z")


class Code(str):
    """Source text made by the compiler, printed as it is."""

    __slots__ = ()


def literal(value: Any) -> str:
    """Return Python source for a plain value.

    Args:
        value: None, bool, int, finite float, str, or a list, tuple or dict of these; or a `Code`.

    Raises:
        TypeError: for every other type (a numpy scalar prints as `np.float64(…)`, an object as anything).
        ValueError: for numbers that have no literal.
    """
    kind = type(value)
    if kind is Code:
        return str(value)
    if value is None or kind is bool or kind is int or kind is str:
        return repr(value)
    if kind is float:
        if not math.isfinite(value):
            raise ValueError(f"{value} has no literal")
        # Nine digits are below a nanometre on any scene that fits a float32 solver, and read better than seventeen.
        return repr(0.0 if abs(value) < 1e-12 else float(f"{value:.9g}"))
    if kind is tuple:
        inner = ", ".join(literal(item) for item in value)
        return f"({inner},)" if len(value) == 1 else f"({inner})"
    if kind is list:
        return f"[{', '.join(literal(item) for item in value)}]"
    if kind is dict:
        return "{" + ", ".join(f"{literal(k)}: {literal(v)}" for k, v in value.items()) + "}"
    raise TypeError(f"{kind.__name__} cannot enter a program")


def identifier(name: str) -> Code:
    """Return a name as source text.

    Raises:
        ValueError: if it is not made of letters, digits and underscores.
    """
    if not _IDENTIFIER.match(name):
        raise ValueError(f"{name!r} is not an identifier")
    return Code(name)


def comment(text: str) -> Code:
    """Return text that is safe inside a comment or a one-line docstring: printable, without quotes or breaks.

    Anything else becomes a blank: a comment must never stop a program from being written.
    """
    safe = "".join(c if c.isprintable() and c not in "\\\"'" else " " for c in text)
    return Code(" ".join(safe.split())[:200])
