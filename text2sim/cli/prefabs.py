"""The command `text2sim prefabs`."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from text2sim.cli.options import AsJson
from text2sim.cli.output import say, say_json
from text2sim.service import exits
from text2sim.spec_schema.text.source import read_source

if TYPE_CHECKING:
    from text2sim.spec_schema.reuse.library import Definition, PrefabLibrary


def prefabs(
    name: Annotated[str, typer.Argument(help="The prefab to explain; all are listed if left out.")] = "",
    case: Annotated[Path | None, typer.Option("--case", help="Include those of this case.")] = None,
    as_json: AsJson = False,
) -> None:
    """List the prefabs that a case can use, or explain one."""
    from text2sim.service.descriptions import describe_prefab

    library = _library(case)
    if not name:
        code = _list(library, as_json)
    else:
        found = _find(library, name)
        code = exits.INPUT if found is None else exits.OK
        if found is not None and as_json:
            say_json(_as_data(found))
        elif found is not None:
            say(describe_prefab(found))
    raise typer.Exit(code)


def _library(case: Path | None) -> "PrefabLibrary":
    from text2sim.service.examined import case_file
    from text2sim.spec_schema.reuse.catalogue import library
    from text2sim.spec_schema.reuse.library import PrefabLibrary
    from text2sim.spec_schema.text.document import parse_document

    if case is None:
        return library()
    file = case_file(case)
    document = parse_document(read_source(file))
    return PrefabLibrary(document, file.parent) if isinstance(document.data, dict) else library(file.parent)


def _list(library: "PrefabLibrary", as_json: bool) -> int:
    """Print one line for each prefab, including broken ones, and return the exit code."""
    found = [(name, _find(library, name)) for name in library.names()]
    usable = [prefab for _, prefab in found if prefab is not None]
    if as_json:
        say_json({"prefabs": [_as_data(prefab) for prefab in usable]})
    else:
        width = max((len(prefab.name) for prefab in usable), default=0)
        for prefab in usable:
            say(f"{prefab.name:{width}}  {_first_sentence(prefab.model.doc)}")
    return exits.OK if len(usable) == len(found) else exits.INPUT


def _find(library: "PrefabLibrary", name: str) -> "Definition | None":
    """Return a prefab, or None after printing why there is none."""
    from text2sim.spec_schema.reuse.library import MissingPrefab

    try:
        return library.find(name)
    except MissingPrefab as missing:
        hint = f"; did you mean `{missing.hint}`?" if missing.hint else ""
        say(f"{missing}{hint}", to=sys.stderr)
        for problem in missing.problems:
            say(f"  {problem}", to=sys.stderr)
        return None


def _first_sentence(doc: str) -> str:
    return " ".join(doc.split()).partition(". ")[0].removesuffix(".")


def _as_data(prefab: "Definition") -> dict[str, Any]:
    from text2sim.spec_schema.reuse.catalogue import parts_of, usage

    params = {name: param.model_dump(mode="json", exclude_unset=True) for name, param in prefab.model.params.items()}
    return {
        "name": prefab.name,
        "file": prefab.place,
        "doc": " ".join(prefab.model.doc.split()),
        "parts": list(parts_of(prefab)),
        "params": params,
        "example": usage(prefab),
    }
