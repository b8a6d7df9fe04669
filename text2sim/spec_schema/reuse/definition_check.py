"""Checks of a prefab, independent of its arguments."""

from graphlib import CycleError, TopologicalSorter
from typing import Any

from text2sim.spec_schema.arithmetic.evaluation import CONSTANTS
from text2sim.spec_schema.arithmetic.expressions import RESERVED
from text2sim.spec_schema.arithmetic.interpolation import parse_interpolation
from text2sim.spec_schema.arithmetic.resolution import COPY_VARIABLES
from text2sim.spec_schema.arithmetic.values import ExpressionError
from text2sim.spec_schema.errors import Problem, nearest
from text2sim.spec_schema.models.prefab_models import Prefab
from text2sim.spec_schema.reuse.arguments import Unfit, check_value, is_open, names_in
from text2sim.spec_schema.reuse.multiples import NUMBER
from text2sim.spec_schema.reuse.overlay_check import check_body
from text2sim.spec_schema.text.document import Document, Path, sites_of


def check_definition(document: Document, root: Path, prefab: Prefab) -> list[Problem]:
    """Check names, defaults, and the expressions and keys of the bodies of a prefab.

    Args:
        document: The document with the prefab.
        root: Its path in the document.
        prefab: The validated prefab.
    """
    check = _Check(document, root, prefab)
    check.params()
    if prefab.body is not None:
        check.body((*root, "body"), prefab.body)
    for name, body in (prefab.bodies or {}).items():
        check.body((*root, "bodies", name), body)
    return check.problems


class _Check:
    def __init__(self, document: Document, root: Path, prefab: Prefab) -> None:
        self.document, self.root, self.prefab = document, root, prefab
        self.problems: list[Problem] = []

    def report(self, path: Path, message: str, rule: str, hint: str | None = None, *, key: bool = False) -> None:
        self.problems.append(self.document.problem(path, message, key=key, rule=rule, hint=hint))

    def params(self) -> None:
        needs: dict[str, set[str]] = {}
        for name, param in self.prefab.params.items():
            path = (*self.root, "params", name)
            if name in RESERVED or name in COPY_VARIABLES:
                message = f"`{name}` already has a meaning in expressions; choose another name"
                self.report(path, message, "taken-name", key=True)
            if param.default is None:
                continue
            if self.expressions((*path, "default"), param.default, set(self.prefab.params)):
                needs[name] = set(names_in(param.default))
                if not needs[name]:
                    self.default((*path, "default"), name)
        try:
            list(TopologicalSorter(needs).static_order())
        except CycleError as error:
            cycle = error.args[1][::-1]
            message = f"defaults refer to each other in a cycle: {' → '.join(cycle)}"
            self.report((*self.root, "params", cycle[0], "default"), message, "cycle")

    def default(self, path: Path, name: str) -> None:
        value = self.prefab.params[name].default
        if is_open(value):
            return  # checked in each use
        try:
            check_value(self.prefab.params[name], value)
        except Unfit as error:
            self.report(path, str(error), error.rule, error.hint)

    def body(self, path: Path, body: dict[str, Any]) -> None:
        self.expressions(path, body, {*self.prefab.params, *COPY_VARIABLES, NUMBER})
        self.problems += check_body(self.document, path, body)

    def expressions(self, root: Path, data: Any, known: set[str]) -> bool:
        """Report expressions that are invalid or use unknown names; return whether there are none."""
        before = len(self.problems)
        for path, text in sites_of(data, root).items():
            try:
                names = parse_interpolation(text).names
            except ExpressionError as error:
                self.report(path, str(error), error.rule, error.hint)
                continue
            for name in sorted(names - known):
                listed = ", ".join(sorted(known - COPY_VARIABLES.keys() - {NUMBER}))
                message = f"unknown name `{name}`: a prefab knows its own parameters{f' ({listed})' if listed else ''}"
                self.report(path, message, "unknown-name", nearest(name, [*known, *CONSTANTS]))
        return len(self.problems) == before
