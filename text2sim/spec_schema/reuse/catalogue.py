"""Catalogue of prefabs, with parameters and examples."""

import json
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from text2sim.spec_schema.reuse.arguments import describe_param
from text2sim.spec_schema.reuse.library import Definition, PrefabLibrary
from text2sim.spec_schema.text.document import parse_document
from text2sim.spec_schema.text.source import Source, read_source
from text2sim.spec_schema.text.writing import flow_text

STAGE: dict[str, Any] = {
    "text2sim": 2,
    "name": "example",
    "scene": {
        "duration": 2,
        "dt": 0.005,
        "statics": {"floor": {"shape": {"kind": "plane", "size": 20}}},
    },
}
"""The case around the examples."""


class ParamRow(NamedTuple):
    """A parameter as text."""

    name: str
    takes: str
    default: str
    """As YAML; empty if it is required."""
    doc: str


def library(folder: Path | None = None) -> PrefabLibrary:
    """Return the prefabs that are available in a case's folder, or in any."""
    return PrefabLibrary(parse_document(Source("text2sim: 2\n", "case.yaml")), folder or Path("/nowhere"))


@cache
def built_in() -> dict[str, Definition]:
    """Return the built-in prefabs, by name, in the order of their examples."""
    return {name: library().find(name) for name in examples()}


@cache
def examples() -> dict[str, str]:
    """Return a use of every built-in prefab, as YAML, by name."""
    return parse_document(read_source(Path(__file__).with_name("prefab_examples.yaml"))).data


def example_case(example: str) -> str:
    """Return an example as a whole case (JSON, which is YAML)."""
    return json.dumps(_joined(STAGE, parse_document(Source(example, "example")).data), ensure_ascii=False)


def usage(definition: Definition) -> str:
    """Return a use of a prefab as YAML: its example, or the required parameters."""
    if definition.place.startswith("text2sim/") and definition.name in examples():
        return examples()[definition.name]
    needed = [f"{name}: …" for name, param in definition.model.params.items() if param.default is None]
    given = f", with: {{{', '.join(needed)}}}" if needed else ""
    place = ", place: {on: floor}" if definition.model.body is not None else ""
    return f"bodies:\n  my_{definition.name}: {{use: {definition.name}{given}{place}}}\n"


def param_rows(definition: Definition) -> list[ParamRow]:
    """Return the parameters of a prefab as text."""
    rows = []
    for name, param in definition.model.params.items():
        default = "" if param.default is None else flow_text(param.default)
        rows.append(ParamRow(name, describe_param(param), default, " ".join(param.doc.split())))
    return rows


def parts_of(definition: Definition) -> tuple[str, ...]:
    """Return the names of the parts of a prefab with several bodies."""
    return tuple(definition.model.bodies or ())


def _joined(base: Any, over: Any) -> Any:
    if not isinstance(base, dict) or not isinstance(over, dict):
        return over
    return base | {key: _joined(base[key], value) if key in base else value for key, value in over.items()}
