"""Substitution of arguments for parameters in the text of expressions, by their syntax trees."""

import ast
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from text2sim.spec_schema.arithmetic.expressions import MAX_COMPOSED, Expression, parse_expression
from text2sim.spec_schema.arithmetic.interpolation import as_text, parse_interpolation
from text2sim.spec_schema.arithmetic.values import ExpressionError
from text2sim.spec_schema.text.document import Node
from text2sim.spec_schema.text.writing import number

_ATOMS = (ast.Constant, ast.Name, ast.List, ast.Call, ast.Subscript)
"""Nodes that need no parentheses."""


@dataclass(frozen=True)
class BoundParameter:
    """A value for a parameter."""

    data: Any
    """Plain data, which may contain `${…}`."""
    node: Node | None = None
    """Its node, if it is an argument."""
    code: str | None = None
    """Its text in a larger expression, with parentheses if needed; None if it can only be a whole expression."""


def bind(data: Any, node: Node | None = None) -> BoundParameter:
    """Return a value bound to a parameter.

    Raises:
        ExpressionError: If an expression in it is invalid.
    """
    return BoundParameter(data, node, _code(data))


Spend = Callable[[int], None]
"""Receives the size of every text before it is made."""


def fill(text: str, known: Mapping[str, BoundParameter], spend: Spend = lambda size: None) -> tuple[Any, Node | None]:
    """Substitute values for names in a scalar with expressions.

    Args:
        text: The scalar.
        known: Values by name; other names stay.
        spend: See `Spend`.

    Returns:
        The scalar, or the value itself if the scalar is a single name; and the node of that value, if it has one.
        Expressions without names are evaluated.

    Raises:
        ExpressionError: If it becomes too large, or a value is invalid there.
    """
    site = parse_interpolation(text, True)
    if site.names.isdisjoint(known):
        return text, None
    if site.whole is not None:
        alone = known.get(site.whole.text.strip())
        return (alone.data, alone.node) if alone is not None else (_worked_out(site.whole, known, spend), None)
    filled = ""
    for part in site.parts:
        if isinstance(part, str):
            filled += part.replace("${", "$${")
            continue
        alone = known.get(part.text.strip())
        value = alone.data if alone is not None else _worked_out(part, known, spend)
        filled += value if isinstance(value, str) else as_text(value)
        spend(len(filled))
        if len(filled) > 2 * MAX_COMPOSED[0]:
            raise ExpressionError("the text becomes too long with its parameters", rule="too-large")
    return filled, None


def _worked_out(expression: Expression, known: Mapping[str, BoundParameter], spend: Spend) -> Any:
    """Return the value of an expression after substitution, or its text in `${…}` if it still has names."""
    code = _replaced(expression, known, spend)
    made = parse_expression(code, True)
    if not made.names:
        try:
            value = made.evaluate({})
        except ExpressionError:
            return f"${{{code}}}"  # reported with all expressions
        if not isinstance(value, str) or "${" not in value:
            return _clean(value)
    return f"${{{code}}}"


def _clean(value: Any) -> Any:
    """Return a value without rounding errors: 0.642, not 0.6419999999999999."""
    if isinstance(value, list):
        return [_clean(item) for item in value]
    return float(f"{value:.12g}") if isinstance(value, float) else value


def _replaced(expression: Expression, known: Mapping[str, BoundParameter], spend: Spend) -> str:
    """Return the text of an expression after substitution; its size is checked first."""
    # Positions in a tree are byte offsets in the parsed text.
    text = " ".join(expression.text.split()).encode()
    places = sorted(_places(expression.tree, known))
    codes: list[bytes] = []
    for _, _, name, code in places:
        if code is None:
            raise ExpressionError(f"the value of `{name}` can only be used alone, as ${{{name}}}")
        codes.append(code.encode())
    size = len(text) + sum(map(len, codes))
    if size > MAX_COMPOSED[0]:
        message = f"the expression is longer than {MAX_COMPOSED[0]} characters with its parameters"
        raise ExpressionError(message, rule="too-large")
    spend(size)
    pieces, done = [], 0
    for (start, end, _, _), code in zip(places, codes, strict=True):
        pieces += [text[done:start], code]
        done = end
    return b"".join([*pieces, text[done:]]).decode()


def _places(node: ast.AST, known: Mapping[str, BoundParameter]) -> Iterator[tuple[int, int, str, str | None]]:
    """Yield start, end and name of each parameter in a tree, and its text; for an item of a list, that of the item."""
    if isinstance(node, ast.Name):
        if node.id in known:
            yield node.col_offset, node.end_col_offset or 0, node.id, known[node.id].code
        return
    if isinstance(node, ast.Subscript) and isinstance(node.value, ast.Name) and isinstance(node.slice, ast.Constant):
        bound, index = known.get(node.value.id), node.slice.value
        items = bound.data if bound is not None else None
        if isinstance(items, list) and type(index) is int and index < len(items):
            yield node.col_offset, node.end_col_offset or 0, node.value.id, _code(items[index])
            return
    for child in ast.iter_child_nodes(node):
        yield from _places(child, known)


def _code(data: Any) -> str | None:
    if isinstance(data, bool):
        return "true" if data else "false"
    if isinstance(data, int | float):
        text = str(data) if isinstance(data, int) else number(data)
        return f"({text})" if data < 0 else text
    if isinstance(data, list):
        items = [_code(item) for item in data]
        code = f"[{', '.join(item for item in items if item is not None)}]"
        return None if None in items or len(code) > MAX_COMPOSED[0] else code
    if not isinstance(data, str):
        return None
    if "${" not in data:
        return repr(data) if data.isprintable() and not any(c in data for c in "{}$\\") else None
    expression = parse_interpolation(data, True).whole
    if expression is None:
        return None
    text = " ".join(expression.text.split())
    return text if isinstance(expression.tree, _ATOMS) else f"({text})"
