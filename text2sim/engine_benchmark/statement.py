"""Model of a case's `benchmark.yaml`: observables, tolerances, and analytic solutions."""

from typing import Annotated

from pydantic import Field

from text2sim.spec_schema.arithmetic.expressions import parse_expression
from text2sim.spec_schema.arithmetic.values import ExpressionError, number
from text2sim.spec_schema.errors import Problem, SpecError, nearest
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.models.base import Model, Positive
from text2sim.spec_schema.text.document import parse_document
from text2sim.spec_schema.text.source import read_source
from text2sim.spec_schema.vocabulary.typed_document import model_of

STATEMENT_FILE = "benchmark.yaml"


class Observable(Model):
    """One observable."""

    tolerance: Positive | None = None
    """Largest difference from the reference [unit of the measure]; 2 % of its range if left out."""
    analytic: Annotated[str, Field(max_length=500)] | None = None
    """Its value as an expression of `t` [s]."""


class Statement(Model):
    """Contents of `benchmark.yaml`."""

    observables: dict[str, Observable]
    until: Positive | None = None
    """End of the comparison [s]; that of the simulation if left out."""
    about: Annotated[str, Field(max_length=2000)] = ""
    """Sources of the equations, and known disagreements."""


def read_statement(loaded: LoadedCase) -> Statement:
    """Read the case's `benchmark.yaml`; without one, all measures that other engines can give are observables.

    Raises:
        SpecError: with all problems of the file and their places, or if there is nothing to observe.
    """
    measures, path = loaded.case.actions.measures, loaded.folder / STATEMENT_FILE
    comparable = [name for name, measure in measures.items() if measure.traits.from_poses]
    if not path.is_file():
        if not comparable:
            message = "it has no measure that other engines can give: position, joint_position, energy, …"
            raise SpecError([loaded.problem(("actions",), message, rule="no-observable")])
        return Statement(observables={name: Observable() for name in comparable})
    document = parse_document(read_source(path))
    statement = model_of(document, Statement)
    problems: list[Problem] = []
    for name, row in statement.observables.items():
        place = ("observables", name)
        if name not in comparable:
            message = f"there is no measure `{name}` that can be compared; there are {', '.join(comparable) or 'none'}"
            problems.append(document.problem(place, message, key=True, rule="unknown", hint=nearest(name, comparable)))
        if row.analytic is not None:
            try:
                for t in (0.0, loaded.case.scene.duration):
                    number(parse_expression(row.analytic).evaluate({"t": t}))
            except ExpressionError as error:
                problems.append(document.problem((*place, "analytic"), str(error), rule="expression"))
    if problems:
        raise SpecError(problems)
    return statement
