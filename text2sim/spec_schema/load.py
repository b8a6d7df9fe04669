"""Loading of a file into a validated case with the positions of its values."""

from pathlib import Path as FilePath
from typing import Any

from pydantic import ValidationError

from text2sim.spec_schema.arithmetic.resolution import Resolver
from text2sim.spec_schema.errors import Problem, SpecError
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.models.case import Case
from text2sim.spec_schema.reuse.migration import migrate
from text2sim.spec_schema.reuse.overlay import NOTHING, CaseOverlay, needs_layers
from text2sim.spec_schema.text.document import Document, Path, parse_document, pointer
from text2sim.spec_schema.text.source import Source, check_source, read_source

CASE_FILE = "case.yaml"


def load_case(path: FilePath | str, overlay: CaseOverlay = NOTHING) -> LoadedCase:
    """Load a case.

    Args:
        path: The case's folder, or its YAML file.
        overlay: Changes to apply to it.

    Raises:
        SpecError: With all problems in the form of the case, in the order of the file.
    """
    path = FilePath(path)
    if path.is_dir():
        path = path / CASE_FILE
    return _load(read_source(path), path, overlay)


def load_text(text: str, path: FilePath | str = CASE_FILE, overlay: CaseOverlay = NOTHING) -> LoadedCase:
    """Load a case from text, as if it were in the file `path`; see `load_case`.

    Args:
        text: The text.
        path: Path of the file.
        overlay: Changes to apply to the case.

    Raises:
        SpecError: With all problems.
    """
    return _load(check_source(Source(text, str(path))), FilePath(path), overlay)


def _load(source: Source, path: FilePath, overlay: CaseOverlay) -> LoadedCase:
    written = parse_document(source)
    if not isinstance(written.data, dict):
        message = "a case is a mapping with the keys text2sim, name, scene, bodies, actions, render"
        raise SpecError([written.problem((), message, rule="type")])
    document, faults = migrate(written)
    layers = None
    if needs_layers(document.data, overlay):
        from text2sim.spec_schema.reuse.layers import build

        layers = build(document, path.parent, overlay)
        document, faults = layers.document, [*faults, *layers.problems]
    resolver = Resolver(document)
    data = resolver.data()
    case, problems = _validate(document, data)
    # A value whose expression failed is not checked further.
    problems = [p for p in problems if not _touches(resolver.broken, p)]
    problems = [*resolver.problems, *problems]
    if layers is not None:
        found, problems = layers.judge(resolver, problems)
        faults += found
    varying = frozenset(path[:depth] for path in resolver.varying for depth in range(len(path) + 1))
    arguments = () if layers is None else tuple(layers.arguments)
    models = case or Case.model_construct()
    loaded = LoadedCase(path, models, data, document, written, resolver, varying, overlay, arguments)
    if problems and not faults:
        from text2sim.spec_schema.names.partial_check import further_problems

        problems += further_problems(loaded, problems, lambda data: _validate(document, data))
    if faults or problems:
        if layers is not None and layers.multiplied:
            from text2sim.spec_schema.reuse.multiples import without_repeats

            problems = without_repeats(problems)
        raise SpecError([*faults, *problems])
    assert case is not None
    return loaded


def _validate(document: Document, data: dict[str, Any]) -> tuple[Case | None, list[Problem]]:
    try:
        return Case.model_validate(data, by_alias=True, by_name=False), []
    except ValidationError as error:
        from text2sim.spec_schema.vocabulary.diagnosis import diagnose

        return None, diagnose(document, error, Case, data)


def _touches(broken: set[Path], problem: Problem) -> bool:
    """Return whether a problem may come from a value that could not be evaluated."""
    for path in broken:
        place = pointer(path)
        if problem.path == place or problem.path.startswith(place + "/"):
            return True
        if problem.rule in ("inconsistent", "type") and place.startswith(problem.path + "/"):
            return True
    return False
