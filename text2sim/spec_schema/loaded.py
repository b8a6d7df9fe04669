"""Case in memory: its models, its plain data, and the document with the positions of its values."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from text2sim.spec_schema.arithmetic.resolution import COPY_VARIABLES, Resolver
from text2sim.spec_schema.arithmetic.values import Value
from text2sim.spec_schema.errors import Problem, SpecError
from text2sim.spec_schema.models.bodies import Body
from text2sim.spec_schema.models.case import Case
from text2sim.spec_schema.models.controls import Control
from text2sim.spec_schema.models.scene import Static
from text2sim.spec_schema.reuse.overlay import NOTHING, CaseOverlay
from text2sim.spec_schema.text.document import Document, Path, parse_pointer, value_at
from text2sim.spec_schema.text.source import Source

if TYPE_CHECKING:
    from text2sim.spec_schema.reuse.arguments import Argument


@dataclass(frozen=True, eq=False)
class LoadedCase:
    """A case with a valid form, with the document that it came from."""

    path: FilePath
    """The YAML file."""
    case: Case
    """The models; expressions that vary between copies have their value for copy 0."""
    data: dict[str, Any]
    """Plain data with every expression evaluated."""
    document: Document
    """The case as it is checked: in the latest version, with overlays applied and prefabs expanded."""
    written: Document
    """The case as it is in the file."""
    resolver: Resolver = field(repr=False)
    varying: frozenset[Path] = field(repr=False)
    """Paths of the values that vary between copies, or contain such values."""
    overlay: CaseOverlay = NOTHING
    """Changes that were applied to it."""
    _arguments: "tuple[Argument, ...]" = field(default=(), repr=False)
    """Arguments of prefabs that may vary between copies."""

    @property
    def folder(self) -> FilePath:
        """The case's folder, which contains its assets."""
        return self.path.parent

    @property
    def raw(self) -> dict[str, Any]:
        """Plain data of `document`, with unevaluated `${…}`."""
        return self.document.data

    @property
    def source(self) -> Source:
        """The text."""
        return self.document.source

    def line(self, where: str | Path) -> int:
        """Return the line (from 1) of the key of a value, or of its nearest existing ancestor."""
        return self.document.place(_path(where), key=True)[0]

    def problem(
        self,
        where: str | Path,
        message: str,
        *,
        key: bool = False,
        rule: str = "invalid",
        hint: str | None = None,
        severity: Any = "error",
    ) -> Problem:
        """Return a problem at a place of the case.

        Args:
            where: JSON Pointer or path.
            message: What is wrong.
            key: Whether to point at the key instead of the value.
            rule: Stable id of the rule.
            hint: The nearest valid word.
            severity: `error` or `warning`.
        """
        return self.document.problem(_path(where), message, key=key, rule=rule, hint=hint, severity=severity)

    def varies(self, where: str | Path) -> bool:
        """Return whether the value, or a part of it, varies between copies."""
        return _path(where) in self.varying

    def body_copy(self, name: str, variables: Mapping[str, Value]) -> Body:
        """Return the model of one copy of a body.

        Args:
            name: Name of the body.
            variables: `i`, `n`, `u`, `row`, `column`, `layer` of the copy.

        Raises:
            SpecError: If an expression has no value, or an invalid one, for this copy.
        """
        return self._copy(("bodies", name), self.case.bodies[name], variables)

    def static_copy(self, name: str, variables: Mapping[str, Value]) -> Static:
        """Return the model of one copy of a static; see `body_copy`."""
        return self._copy(("scene", "statics", name), self.case.scene.statics[name], variables)

    def control_copy(self, name: str, variables: Mapping[str, Value]) -> Control:
        """Return the control for one copy; see `body_copy`."""
        return self._copy(("actions", "controls", name), self.case.actions.controls[name], variables)

    def _copy(self, root: Path, model: Any, variables: Mapping[str, Value]) -> Any:
        if root not in self.varying:
            return model
        known = {**COPY_VARIABLES, **variables}
        data, problems = self.resolver.copy(root, value_at(self.data, root), known)
        problems = self._judge_arguments(root, known) or problems
        if not problems:
            try:
                return type(model).model_validate(data, by_alias=True, by_name=False)
            except ValidationError as error:
                from text2sim.spec_schema.vocabulary.diagnosis import diagnose

                problems = diagnose(self.document, error, type(model), data, root)
        which = f"copy {known['i']}: "
        raise SpecError(replace(problem, message=which + problem.message) for problem in problems)

    def _judge_arguments(self, root: Path, known: Mapping[str, Value]) -> list[Problem]:
        arguments = [argument for argument in self._arguments if root in argument.roots]
        if not arguments:
            return []
        from text2sim.spec_schema.reuse.arguments import judge

        found = [judge(self.document, self.resolver, argument, known) for argument in arguments]
        return [problem for problem in found if problem is not None]


def _path(where: str | Path) -> Path:
    return parse_pointer(where) if isinstance(where, str) else where
