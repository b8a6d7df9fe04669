"""Text with `${…}` in it: a value that is one expression takes its type, any other becomes text."""

import re
from collections.abc import Mapping
from functools import lru_cache

from text2sim.spec_schema.arithmetic.expressions import Expression, parse_expression
from text2sim.spec_schema.arithmetic.values import ExpressionError, Value

MAX_TEXT = 20_000

_MARK = re.compile(r"\$?\$\{")
_BRACE = re.compile(r"[{}]")


class Interpolation:
    """A scalar with expressions.

    Attributes:
        parts: Its text and its expressions, in order.
        whole: The expression, if it consists of one; otherwise None.
        names: Parameters and copy variables that it uses.
    """

    __slots__ = ("names", "parts", "whole")

    def __init__(self, text: str, composed: bool = False) -> None:
        self.parts = _split(text, composed)
        only = self.parts[0] if len(self.parts) == 1 else None
        self.whole = only if isinstance(only, Expression) else None
        self.names = frozenset().union(*(part.names for part in self.parts if isinstance(part, Expression)))

    def evaluate(self, names: Mapping[str, Value]) -> Value:
        """Return the value; see `Expression.evaluate`.

        Raises:
            ExpressionError: If an expression in it has no value, or the text becomes too long.
        """
        if self.whole is not None:
            return self.whole.evaluate(names)
        text = ""
        for part in self.parts:
            text += part if isinstance(part, str) else as_text(part.evaluate(names))
            if len(text) > MAX_TEXT:
                raise ExpressionError(f"the text is longer than {MAX_TEXT} characters")
        return text


@lru_cache(maxsize=4096)
def parse_interpolation(text: str, composed: bool = False) -> Interpolation:
    """Split a scalar into text and expressions; for `composed`, see `parse_expression`.

    Raises:
        ExpressionError: If an expression is not closed or not arithmetic.
    """
    return Interpolation(text, composed)


def _split(text: str, composed: bool) -> list[str | Expression]:
    parts: list[str | Expression] = []
    literal, done = "", 0
    while found := _MARK.search(text, done):
        literal += text[done : found.start()]
        if found[0].startswith("$$"):  # `$${` stands for the characters `${`
            literal += "${"
            done = found.end()
            continue
        end = _closing(text, found.end())
        if literal:
            parts.append(literal)
            literal = ""
        parts.append(parse_expression(text[found.end() : end], composed))
        done = end + 1
    literal += text[done:]
    if literal or not parts:
        parts.append(literal)
    return parts


def _closing(text: str, start: int) -> int:
    depth = 1
    for found in _BRACE.finditer(text, start):
        depth += 1 if found[0] == "{" else -1
        if depth == 0:
            return found.start()
    raise ExpressionError("`${` has no closing brace (write `$${` for the characters)")


def as_text(value: Value) -> str:
    """Return a value as part of a text.

    Raises:
        ExpressionError: If it is a list.
    """
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return str(int(value)) if value == int(value) else f"{value:.12g}"
    if isinstance(value, list):
        raise ExpressionError("a list cannot be part of a text")
    return str(value)
