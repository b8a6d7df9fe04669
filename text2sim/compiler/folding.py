"""Expressions in which everything is evaluated that is the same for all copies."""

import ast
from collections.abc import Mapping

from text2sim.spec_schema.arithmetic.evaluation import evaluate
from text2sim.spec_schema.arithmetic.expressions import Expression
from text2sim.spec_schema.arithmetic.interpolation import parse_interpolation
from text2sim.spec_schema.arithmetic.resolution import COPY_VARIABLES
from text2sim.spec_schema.arithmetic.values import ExpressionError, Value


def folded(text: str, params: Mapping[str, Value]) -> str:
    """Return a scalar with its parameters filled in: its `${…}` keep only what differs from copy to copy.

    Args:
        text: The scalar.
        params: The value of every parameter.
    """
    parts = parse_interpolation(text, True).parts
    return "".join(_folded(part, params) if isinstance(part, Expression) else escaped(part) for part in parts)


def escaped(text: str) -> str:
    """Return text with each `${` escaped, so that it begins no expression."""
    return text.replace("${", "$${")


def _folded(expression: Expression, params: Mapping[str, Value]) -> str:
    tree = ast.parse(" ".join(expression.text.split()), mode="eval").body
    return "${" + ast.unparse(_fold(tree, params)) + "}"


def _fold(node: ast.expr, params: Mapping[str, Value]) -> ast.expr:
    if not any(isinstance(inner, ast.Name) and inner.id in COPY_VARIABLES for inner in ast.walk(node)):
        try:
            return _literal(evaluate(node, params))
        except (ExpressionError, OverflowError):
            pass  # in a branch that is never taken, perhaps
    for name, inner in ast.iter_fields(node):
        if isinstance(inner, ast.expr) and not (isinstance(node, ast.Call) and name == "func"):
            setattr(node, name, _fold(inner, params))
        elif isinstance(inner, list):
            setattr(node, name, [_fold(item, params) if isinstance(item, ast.expr) else item for item in inner])
    return node


def _literal(value: Value) -> ast.expr:
    if isinstance(value, bool):
        return ast.Name("true" if value else "false", ast.Load())
    if isinstance(value, list):
        return ast.List([_literal(item) for item in value], ast.Load())
    if isinstance(value, int | float) and value < 0:
        return ast.UnaryOp(ast.USub(), ast.Constant(-value))
    return ast.Constant(value)
