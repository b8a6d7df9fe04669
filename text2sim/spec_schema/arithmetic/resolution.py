"""Resolution of `${…}` in a document to plain data: parameters, and the variables of copies."""

import copy
from collections.abc import Iterator, Mapping
from graphlib import CycleError, TopologicalSorter
from typing import Any

from text2sim.spec_schema.arithmetic.expressions import RESERVED
from text2sim.spec_schema.arithmetic.interpolation import Interpolation, parse_interpolation
from text2sim.spec_schema.arithmetic.values import ExpressionError, Value, count_items
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.names.selectors import body_of
from text2sim.spec_schema.reuse.sections import placed_entries
from text2sim.spec_schema.text.document import MAX_NODES, Document, Path, mapping_at, value_at

MAX_TEXTS = 600_000
"""Most characters of all expressions together, which take a second to parse."""
COPY_VARIABLES: dict[str, int | float] = {"i": 0, "n": 1, "u": 0.0, "row": 0, "column": 0, "layer": 0}
"""Variables of copies, with their values for a body without copies."""


class Resolver:
    """Evaluation of the expressions of a document.

    Attributes:
        problems: Problems of expressions and parameters.
        broken: Paths of scalars without a value.
        varying: Paths of scalars that use copy variables.
        sites: Expressions by the path of their scalar.
        scopes: Paths in which copy variables are defined.
    """

    def __init__(self, document: Document) -> None:
        self.document = document
        self.problems: list[Problem] = []
        self.broken: set[Path] = set()
        self.varying: set[Path] = set()
        self.sites: dict[Path, Interpolation] = {}
        left = MAX_TEXTS
        for path, text in document.sites.items():
            left -= len(text)
            try:
                if left < 0:
                    message = f"the expressions up to here have more than {MAX_TEXTS} characters; use fewer, or numbers"
                    raise ExpressionError(message, rule="too-large")
                self.sites[path] = parse_interpolation(text, path in document.composed)
            except ExpressionError as error:
                self.fail(path, error)
            if left < 0:
                break
        self._size = 0
        self._varying_in: dict[Path, list[Path]] = {}
        self.params = _Parameters(self)
        self.scopes = set(_scopes(document.data))
        for path, site in self.sites.items():
            used = [name for name in site.names if name in COPY_VARIABLES and name not in self.params]
            if used and self._in_scope(path, used):
                self.varying.add(path)

    def fail(self, path: Path, error: ExpressionError) -> None:
        """Record that the scalar at `path` has no value."""
        self.broken.add(path)
        self.problems.append(self.document.problem(path, str(error), rule=error.rule, hint=error.hint))

    def scope(self, variables: Mapping[str, Value] = COPY_VARIABLES) -> Mapping[str, Value]:
        """Return the parameters and copy variables together; a parameter without a value raises `Cascade`."""
        return _Scope(self.params, variables)

    def data(self) -> Any:
        """Return the document's data with every expression evaluated, for copy 0."""
        if self.params:
            self.params.evaluate_all()
        return self._replace(self.document.data, (), list(self.sites), COPY_VARIABLES)

    def copy(self, root: Path, value: Any, variables: Mapping[str, Value]) -> tuple[Any, list[Problem]]:
        """Evaluate the varying values of a body, static or control for one of its copies.

        Args:
            root: Path of the body, static or control.
            value: Its data from `data`; not changed.
            variables: The copy variables.

        Returns:
            The data for this copy, and its problems.
        """
        if root not in self._varying_in:
            self._varying_in[root] = [path for path in self.varying if path[: len(root)] == root]
        fresh = copy.copy(self)
        fresh.problems, fresh.broken, fresh._size = [], set(), 0
        data = fresh._replace(value, root, self._varying_in[root], variables)
        return data, fresh.problems

    def _replace(self, value: Any, root: Path, sites: list[Path], variables: Mapping[str, Value]) -> Any:
        """Replace expressions by values; parts without expressions are shared with `value`."""
        if not sites:
            return value
        names = self.scope(variables)
        copied: dict[Path, Any] = {root: copy.copy(value)}
        for path in sites:
            if path in self.broken:
                continue
            try:
                result = self._evaluate(path, names)
                self._check_size(result)
            except ExpressionError as error:
                self.fail(path, error)
                continue
            except Cascade:
                self.broken.add(path)
                continue
            container = copied[root]
            for depth in range(len(root), len(path) - 1):
                inner = path[: depth + 1]
                if inner not in copied:
                    copied[inner] = container[path[depth]] = container[path[depth]].copy()
                container = copied[inner]
            container[path[-1]] = result
        return copied[root]

    def _check_size(self, value: Value) -> None:
        """Refuse a short case with a huge result, such as a long list that is used ten thousand times."""
        self._size += count_items(value)
        if self._size > MAX_NODES:
            raise ExpressionError(f"the expressions make more than {MAX_NODES} values", rule="too-large")

    def _evaluate(self, path: Path, names: Mapping[str, Value]) -> Value:
        if path[:1] == ("params",) and path[1:2] and path[1] in self.params:
            return value_at(self.params, path[1:])
        return self.sites[path].evaluate(names)

    def _in_scope(self, path: Path, used: list[str]) -> bool:
        scope = next((path[:depth] for depth in range(1, len(path)) if path[:depth] in self.scopes), None)
        word = f"`{used[0]}` varies between copies and"
        if scope is None:
            message = f"{word} is defined only in a body or static with repeat, and in controls on such a body"
        elif path[len(scope)] == "repeat":
            message = f"{word} is not defined in `repeat` itself"
        elif path[0] == "actions" and path[len(scope)] in ("body", "joint", "kind"):
            message = f"{word} is not defined in `{path[len(scope)]}`, which selects the copies"
        else:
            return True
        self.fail(path, ExpressionError(message, rule="copy-variable"))
        return False


class Cascade(Exception):
    """A value depends on a parameter that is already reported."""


class _Parameters(Mapping[str, Value]):
    """The parameters, by name."""

    def __init__(self, resolver: Resolver) -> None:
        self._resolver = resolver
        self._raw = mapping_at(resolver.document.data, "params")
        self._values: dict[str, Value] = {}
        self._failed: set[str] = set()
        for name, value in self._raw.items():
            if name in RESERVED or name in COPY_VARIABLES:
                message = f"`{name}` already has a meaning in expressions; choose another name"
                problem = resolver.document.problem(("params", name), message, key=True, rule="taken-name")
                resolver.problems.append(problem)
            self._check(("params", name), value)

    def evaluate_all(self) -> None:
        """Evaluate every parameter, each after those that it uses."""
        needs: dict[str, set[str]] = {name: set() for name in self._raw}
        for path, site in self._resolver.sites.items():
            if path[0] == "params" and len(path) > 1:
                needs[str(path[1])] |= site.names & self._raw.keys()
        for name in self._order(needs):
            try:
                if name not in self._failed:
                    self._values[name] = self._resolve(("params", name), self._raw[name])
            except Cascade:
                self._failed.add(name)

    def _order(self, needs: dict[str, set[str]]) -> list[str]:
        while True:
            try:
                return list(TopologicalSorter(needs).static_order())
            except CycleError as error:
                cycle: list[str] = error.args[1][:0:-1]
                first = min(cycle, key=list(self._raw).index)
                turn = cycle.index(first)
                shown = " → ".join([*cycle[turn:], *cycle[:turn], first])
                message = f"params refer to each other in a cycle: {shown}"
                sites = [p for p in self._resolver.sites if p[:2] == ("params", first)]
                self._resolver.fail(sites[0], ExpressionError(message, rule="cycle"))
                for name in cycle:
                    needs[name] = set()
                self._failed |= set(cycle)

    def __getitem__(self, name: str) -> Value:
        if name in self._failed:
            raise Cascade
        return self._values[name]

    def _resolve(self, path: Path, value: Any) -> Value:
        if path in self._resolver.broken:
            raise Cascade
        if isinstance(value, list):
            return [self._resolve((*path, index), item) for index, item in enumerate(value)]
        if path not in self._resolver.sites:
            return value
        try:
            return self._resolver.sites[path].evaluate(self)
        except ExpressionError as error:
            self._resolver.fail(path, error)
            raise Cascade from None

    def _check(self, path: Path, value: Any) -> None:
        """Refuse values that expressions cannot use."""
        if isinstance(value, list):
            for index, item in enumerate(value):
                self._check((*path, index), item)
        elif isinstance(value, dict) or value is None:
            what = "a mapping" if isinstance(value, dict) else "nothing"
            message = f"a parameter is a number, text, true or false, or a list of these (got {what})"
            self._resolver.problems.append(self._resolver.document.problem(path, message, rule="parameter"))
            self._resolver.broken.add(path)

    def __iter__(self) -> Iterator[str]:
        return iter(self._raw)

    def __len__(self) -> int:
        return len(self._raw)


class _Scope(Mapping[str, Value]):
    """Parameters and copy variables together."""

    def __init__(self, params: _Parameters, variables: Mapping[str, Value]) -> None:
        self._params = params
        self._variables = variables

    def __getitem__(self, name: str) -> Value:
        return self._params[name] if name in self._params else self._variables[name]

    def __contains__(self, name: object) -> bool:
        return name in self._params or name in self._variables

    def __iter__(self) -> Iterator[str]:
        return iter(self._params)

    def __len__(self) -> int:
        return len(self._params)


def _scopes(data: Any) -> Iterator[Path]:
    """Yield the paths in which copy variables are defined: repeated bodies and statics, and controls on bodies."""
    yield from (path for path, entry in placed_entries(data) if entry.get("repeat") is not None)
    bodies = mapping_at(data, "bodies")
    controls = mapping_at(mapping_at(data, "actions"), "controls")
    for name in controls:
        control = mapping_at(controls, name)
        target = control.get("body", control.get("joint"))
        if isinstance(target, str) and mapping_at(bodies, body_of(target)).get("repeat") is not None:
            yield ("actions", "controls", name)
