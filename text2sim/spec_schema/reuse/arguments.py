"""Checks of the arguments of prefabs."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from text2sim.spec_schema.arithmetic.interpolation import parse_interpolation
from text2sim.spec_schema.arithmetic.resolution import COPY_VARIABLES, Cascade, Resolver
from text2sim.spec_schema.arithmetic.values import ExpressionError, is_number
from text2sim.spec_schema.errors import Problem, nearest
from text2sim.spec_schema.models.base import Selector
from text2sim.spec_schema.models.colors import NAMED, ColorError, rgb
from text2sim.spec_schema.models.prefab_models import PrefabParam
from text2sim.spec_schema.text.document import Document, Node, Path, pointer, sites_of
from text2sim.spec_schema.vocabulary.words import bounds_of, noun_of, show, slot_of

_SELECTOR = re.compile(bounds_of(slot_of(Selector))["pattern"])


class Unfit(Exception):
    """A value that a parameter does not accept."""

    def __init__(self, message: str, hint: str | None = None, rule: str = "argument") -> None:
        super().__init__(message)
        self.hint = hint
        self.rule = rule


@dataclass(frozen=True)
class Argument:
    """An argument that depends on parameters of the case or on the copy."""

    path: Path
    """Its path, which need not exist."""
    node: Node
    param: PrefabParam
    data: Any
    roots: tuple[Path, ...]
    """The bodies or the static that use it."""


def check_value(param: PrefabParam, value: Any) -> None:
    """Check a value for a parameter.

    Raises:
        Unfit: If the parameter does not accept it.
    """
    wrong = Unfit(f"needs {describe_param(param)} (got {_shown(value)})")
    if param.kind in ("vec2", "vec3"):
        if not isinstance(value, list) or len(value) != int(param.kind[-1]) or not all(map(is_number, value)):
            raise wrong
        if not all(_is_within(param, item) for item in value):
            raise wrong
    elif param.kind in ("number", "integer", "length", "angle_deg"):
        if not is_number(value) or (param.kind == "integer" and not isinstance(value, int)):
            raise wrong
        if not _is_within(param, value) or (param.kind == "length" and value <= 0):
            raise wrong
    elif param.kind == "bool":
        if not isinstance(value, bool):
            raise wrong
    elif param.kind == "color":
        _check_color(value, wrong)
    elif not isinstance(value, str):
        raise wrong
    elif param.kind == "choice" and value not in (param.of or ()):
        raise Unfit(str(wrong), nearest(value, param.of or ()))
    elif param.kind == "body" and not _SELECTOR.fullmatch(value):
        raise Unfit(f"`{value[:60]}` is not a selector: {noun_of(slot_of(Selector)).form}")


def is_open(data: Any) -> bool:
    """Return whether a value is unknown before its expressions are evaluated."""
    return bool(sites_of(data)) and not _has_mapping(data)


def _has_mapping(data: Any) -> bool:
    return isinstance(data, dict) or (isinstance(data, list) and any(map(_has_mapping, data)))


def describe_param(param: PrefabParam) -> str:
    """Return what a parameter accepts."""
    if param.kind in ("vec2", "vec3"):
        return f"{param.kind[-1]} numbers{_range(param)}"
    numbers = {
        "number": "a number",
        "integer": "a whole number",
        "length": "a length [m]",
        "angle_deg": "an angle [deg]",
    }
    if param.kind in numbers:
        return numbers[param.kind] + (_range(param) or (" greater than 0" if param.kind == "length" else ""))
    if param.kind == "choice":
        return f"one of {', '.join(param.of or ())}"
    words = {"bool": "true or false", "color": "a colour", "body": "a selector", "text": "text"}
    return words[param.kind]


def check_arguments(
    document: Document, resolver: Resolver, arguments: list[Argument]
) -> tuple[list[Problem], set[Path]]:
    """Check arguments when the parameters of the case have values; varying ones are checked for copy 0.

    Args:
        document: The expanded document.
        resolver: Values of parameters.
        arguments: Arguments of prefabs.

    Returns:
        The problems, and the bodies and statics with wrong arguments.
    """
    problems: list[Problem] = []
    blamed: set[Path] = set()
    # A wrong argument makes the defaults that use it wrong too, so written ones are checked first.
    for argument in sorted(arguments, key=lambda argument: argument.node.origin is not None):
        if argument.node.origin is not None and not blamed.isdisjoint(argument.roots):
            continue
        used = sorted(names_in(argument.data) & COPY_VARIABLES.keys() - set(resolver.params))
        if used and not any(root in resolver.scopes for root in argument.roots):
            message = f"`{used[0]}` varies between copies and is defined only beside a repeat"
            problem = locate(document, argument.path, argument.node, message, rule="copy-variable")
        else:
            problem = judge(document, resolver, argument, COPY_VARIABLES)
        if problem is not None:
            problems.append(problem)
            blamed |= set(argument.roots)
    return problems, blamed


def judge(document: Document, resolver: Resolver, argument: Argument, variables: Mapping[str, Any]) -> Problem | None:
    """Return the problem of an argument for one copy, or None.

    Args:
        document: The expanded document.
        resolver: Values of parameters.
        argument: The argument.
        variables: Variables of the copy.
    """
    try:
        check_value(argument.param, _value(argument.data, resolver.scope(variables)))
    except Cascade:
        return None
    except (ExpressionError, Unfit) as error:
        return locate(document, argument.path, argument.node, str(error), rule=error.rule, hint=error.hint)
    return None


def locate(document: Document, path: Path, node: Node, message: str, *, rule: str, hint: str | None = None) -> Problem:
    """Return a problem at a node that may no longer be in the document.

    Args:
        document: The document.
        path: Path of the node.
        node: The node.
        message: What is wrong.
        rule: Id of the rule.
        hint: The nearest valid word.
    """
    if node.origin is not None:
        message += f" ({node.origin})"
    return Problem(pointer(path), message, node.line, node.column, document.source.file, hint, rule)


def names_in(data: Any) -> frozenset[str]:
    """Return the names in the expressions of a value."""
    if isinstance(data, list):
        return frozenset().union(*map(names_in, data))
    if isinstance(data, str) and "${" in data:
        return parse_interpolation(data, True).names
    return frozenset()


def _value(data: Any, names: Mapping[str, Any]) -> Any:
    if isinstance(data, list):
        return [_value(item, names) for item in data]
    if isinstance(data, str) and "${" in data:
        return parse_interpolation(data, True).evaluate(names)
    return data


def _shown(value: Any) -> str:
    if isinstance(value, list) and 0 < len(value) <= 4 and all(map(is_number, value)):
        return f"[{', '.join(show(item) for item in value)}]"
    return f"the number {show(value)}" if is_number(value) else show(value)


def _is_within(param: PrefabParam, value: float) -> bool:
    return (param.min is None or value >= param.min) and (param.max is None or value <= param.max)


def _range(param: PrefabParam) -> str:
    if param.min is not None and param.max is not None:
        return f" from {param.min:g} to {param.max:.12g}"
    if param.min is not None:
        return f" of at least {param.min:g}"
    return f" of at most {param.max:.12g}" if param.max is not None else ""


def _check_color(value: Any, wrong: Unfit) -> None:
    """Check a colour, or a list of names that copies take in turn."""
    if isinstance(value, list) and len(value) == 3 and all(map(is_number, value)):
        if not all(0 <= channel <= 1 for channel in value):
            raise wrong
        return
    words = value if isinstance(value, list) and value else [value]
    for word in words:
        if not isinstance(word, str):
            raise wrong
        try:
            rgb(word)
        except ColorError as error:
            raise Unfit(str(error), nearest(word, NAMED), error.rule) from None
