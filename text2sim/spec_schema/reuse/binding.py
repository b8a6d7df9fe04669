"""Binding of a prefab's parameters to arguments and defaults."""

from dataclasses import dataclass, field
from graphlib import TopologicalSorter

from text2sim.spec_schema.arithmetic.values import ExpressionError
from text2sim.spec_schema.errors import Problem, nearest
from text2sim.spec_schema.reuse.arguments import Argument, Unfit, check_value, describe_param, is_open, locate, names_in
from text2sim.spec_schema.reuse.filling import Filler
from text2sim.spec_schema.reuse.library import Definition
from text2sim.spec_schema.reuse.substitution import BoundParameter, bind
from text2sim.spec_schema.reuse.trees import LocatedValue
from text2sim.spec_schema.text.document import Document, Node, Origin, Path
from text2sim.spec_schema.text.nodes import Derived
from text2sim.spec_schema.vocabulary.words import show


class RefusedUse(Exception):
    """A use that cannot be expanded, with its problems."""

    def __init__(self, problems: list[Problem]) -> None:
        super().__init__("; ".join(problem.message for problem in problems))
        self.problems = problems


@dataclass
class Binding:
    """Parameters with their values."""

    values: dict[str, BoundParameter] = field(default_factory=dict)
    arguments: list[Argument] = field(default_factory=list)
    """Those whose value depends on the case's parameters or on the copy."""


def bind_all(document: Document, entry: LocatedValue, definition: Definition, path: Path, filler: Filler) -> Binding:
    """Bind every parameter of a prefab.

    Args:
        document: The case.
        entry: The entry that uses it.
        definition: The prefab.
        path: Path of the entry.
        filler: Fills defaults.

    Raises:
        RefusedUse: If an argument is unknown, missing or invalid.
    """
    use = entry.child("use")
    given = entry.child("with") if entry.data.get("with") is not None else LocatedValue({}, use.node)
    params, binding, problems = definition.model.params, Binding(), list[Problem]()
    if not isinstance(given.data, dict):
        message = f"needs a mapping of parameters (got {show(given.data)})"
        raise RefusedUse([locate(document, (*path, "with"), given.node, message, rule="type")])
    for name in given.data:
        if name not in params:
            takes = f"takes {', '.join(params)}" if params else "has no parameters"
            message = f"unknown parameter `{name}`; `{definition.name}` {takes}"
            free = [word for word in params if word not in given.data]
            hint = nearest(name, free) or nearest(name, params)
            place = _at(given.node, name)
            problems.append(locate(document, (*path, "with", name), place, message, rule="unknown-param", hint=hint))
            continue
        where, tree = (*path, "with", name), given.child(name)
        try:
            bound = bind(tree.data, tree.node)
            if not is_open(tree.data):
                check_value(params[name], tree.data)
            else:
                binding.arguments.append(Argument(where, tree.node, params[name], tree.data, ()))
            binding.values[name] = bound
        except (Unfit, ExpressionError) as error:
            problems.append(locate(document, where, tree.node, str(error), rule=error.rule, hint=error.hint))
    for name, param in params.items():
        if name not in given.data and param.default is None:
            what = describe_param(param) + (f": {param.doc}" if param.doc else "")
            message = f"`{definition.name}` needs the parameter `{name}` ({what})"
            problems.append(locate(document, path, use.node, message, rule="missing-param"))
    if problems:
        raise RefusedUse(problems)
    _bind_defaults(document, definition, path, use.node, binding, filler)
    return binding


def _bind_defaults(
    document: Document, definition: Definition, path: Path, use: Node, binding: Binding, filler: Filler
) -> None:
    """Bind the defaults of missing arguments, each after those that it uses."""
    params = definition.model.params
    rest = {name: names_in(param.default) for name, param in params.items() if name not in binding.values}
    for name in TopologicalSorter(rest).static_order():
        if name in binding.values:
            continue
        default = definition.default(name)
        assert default is not None
        origin = Origin(f"in prefab `{definition.name}`", definition.place, default.node.line, use.origin)
        where, node = (*path, "with", name), Derived(use.line, use.column, origin)
        try:
            filled = filler.fill(default, binding.values, (use.line, use.column), lambda found: origin)  # noqa: B023
            value = filled.data
            if not is_open(value):
                check_value(params[name], value)
            elif is_open(default.data):
                binding.arguments.append(Argument(where, node, params[name], value, ()))
            binding.values[name] = bind(value)
        except Unfit as error:
            message = f"the default of `{name}` {error}"
            raise RefusedUse([locate(document, path, node, message, rule=error.rule, hint=error.hint)]) from None
        except ExpressionError as error:
            # The message already has the position in the prefab.
            plain = Node(use.line, use.column)
            raise RefusedUse([locate(document, path, plain, str(error), rule=error.rule, hint=error.hint)]) from None


def _at(node: Node, key: str) -> Node:
    """Return a node at the position of a key."""
    line, column = node.keys[key]
    assert isinstance(node.children, dict)
    origin = node.children[key].origin or node.origin
    return Node(line, column) if origin is None else Derived(line, column, origin)
