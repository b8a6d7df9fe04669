"""Docstrings of public functions: `Args` of three parameters and more, `Raises` of what a function raises itself.

Ruff sees whether a section names all parameters (D417), but not whether there is one. Commands are documented by the
help of their options.
"""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import typer

from text2sim.cli.main import app

PACKAGE = Path(__file__).resolve().parents[1] / "text2sim"
MODULES = sorted(PACKAGE.rglob("*.py"))
Function = ast.FunctionDef | ast.AsyncFunctionDef


def commands(group: typer.Typer) -> Iterator[str]:
    for command in group.registered_commands:
        if command.callback is not None:
            yield f"{command.callback.__module__}.{command.callback.__name__}"
    for inner in group.registered_groups:
        if inner.typer_instance is not None:
            yield from commands(inner.typer_instance)


COMMANDS = frozenset(commands(app))


def public(body: list[ast.stmt], owner: str) -> Iterator[tuple[str, Function]]:
    for node in body:
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            yield from public(node.body, f"{owner}.{node.name}")
        elif isinstance(node, Function) and not node.name.startswith("_"):
            yield f"{owner}.{node.name}", node


def parameters(function: Function) -> list[str]:
    given = function.args
    found = [*given.posonlyargs, *given.args, given.vararg, *given.kwonlyargs, given.kwarg]
    return [one.arg for one in found if one is not None and one.arg not in ("self", "cls")]


def raised(node: ast.AST) -> Iterator[str]:
    """The words that an error is made with; not those of functions within, nor of what is caught on the spot."""
    caught = {ast.unparse(one.type) for one in getattr(node, "handlers", ()) if one.type is not None}
    for child in ast.iter_child_nodes(node):
        if isinstance(child, Function | ast.ClassDef | ast.Lambda):
            continue
        found = [*raised(child)]
        if isinstance(child, ast.Raise) and child.exc is not None:
            found.append(ast.unparse(child.exc.func if isinstance(child.exc, ast.Call) else child.exc))
        kept = () if isinstance(child, ast.ExceptHandler) else caught
        yield from (error for error in found if error not in kept)


def faults(path: Path) -> Iterator[str]:
    module = ".".join(("text2sim", *path.relative_to(PACKAGE).with_suffix("").parts))
    for name, function in public(ast.parse(path.read_text("utf-8")).body, module):
        if name in COMMANDS:
            continue
        told = ast.get_docstring(function) or ""
        if len(parameters(function)) > 2 and "Args:\n" not in told:
            yield f"{name}: no `Args` of {', '.join(parameters(function))}"
        raises = told.partition("Raises:\n")[2]
        for error in sorted({*raised(function)} - {"AssertionError"}):
            # What is no name of a class is made by a function, or chosen: that there is a section has to do.
            known = error in raises if re.fullmatch(r"(\w+\.)*[A-Z]\w*", error) else bool(raises)
            if not known:
                yield f"{name}: no `Raises` of {error}"


def test_public_functions_say_what_they_take_and_raise() -> None:
    missing = [fault for path in MODULES for fault in faults(path)]
    assert not missing, "\n".join(missing)
