"""The card of a dataset, with the settings that `datasets` reads, and its metadata in Croissant.

Croissant: https://docs.mlcommons.org/croissant/docs/croissant-spec.html
"""

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa
import yaml

from text2sim import __version__
from text2sim.dataset.annotations import ARRAYS
from text2sim.dataset.recipe import SPLITS, Recipe
from text2sim.dataset.tables import SCHEMAS
from text2sim.recording.inventory import sha256_of
from text2sim.spec_schema.whole_files import write_atomically

CONTEXT = {
    "@language": "en",
    "@vocab": "https://schema.org/",
    "cr": "http://mlcommons.org/croissant/",
    "sc": "https://schema.org/",
    "dct": "http://purl.org/dc/terms/",
    "citeAs": "cr:citeAs",
    "column": "cr:column",
    "conformsTo": "dct:conformsTo",
    "containedIn": "cr:containedIn",
    "data": {"@id": "cr:data", "@type": "@json"},
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "extract": "cr:extract",
    "field": "cr:field",
    "fileObject": "cr:fileObject",
    "fileSet": "cr:fileSet",
    "fileProperty": "cr:fileProperty",
    "includes": "cr:includes",
    "key": "cr:key",
    "md5": "cr:md5",
    "recordSet": "cr:recordSet",
    "references": "cr:references",
    "repeated": "cr:repeated",
    "source": "cr:source",
}
FILES = {
    "film.mp4": "the film, H.264; sharp pinhole pictures without overlays",
    "annotations.npz": "arrays of every picture, see below",
    "states.npz": "time (F,) [s]; pos, quat (w, x, y, z), vel, ang of links (F, L, …) [SI, world]; qpos, "
    "dofs_velocity, dofs_force of joints; soft_points (T, P, 3) at the times of the pictures",
    "layout.json": "links, joints, deformable bodies: the columns of `states.npz`",
    "case.yaml": "the case as it was run",
    "program.zip": "the generated program",
    "evidence.json, events.jsonl, measures.csv": "measures, events and contacts, expectations, diagnostics",
    "json": "the item's row of the table",
}


def write_card(folder: Path, recipe: Recipe, tables: Mapping[str, Counter[str]]) -> None:
    """Write `README.md` and `croissant.json`. The card names benchmarks that are in the folder.

    Args:
        folder: Folder of the dataset.
        recipe: Its recipe.
        tables: Rows by table and split.
    """
    configs = [
        {
            "config_name": table,
            "data_files": [{"split": split, "path": f"{table}/{split}-*.parquet"} for split in SPLITS if split in rows],
        }
        | ({"default": True} if table == "items" else {})
        for table, rows in tables.items()
    ]
    head = {
        "pretty_name": recipe.name,
        "license": recipe.licence,
        "tags": ["physics", "simulation", "video", "text2sim"],
        "configs": configs,
    }
    benchmarks = sorted(path.parent.name for path in (folder / "benchmarks").glob("*/benchmark.json"))
    text = f"---\n{yaml.safe_dump(head, sort_keys=False)}---\n\n{_words(recipe, tables, benchmarks)}"
    write_atomically(folder / "README.md", text)
    write_atomically(folder / "croissant.json", json.dumps(_croissant(folder, recipe, tables), indent=1) + "\n")


def _words(recipe: Recipe, tables: Mapping[str, Counter[str]], benchmarks: Sequence[str]) -> str:
    rows = [f"# {recipe.name}", recipe.description or "Simulated scenes: films and a record of what happens in them."]
    counts = ["| table | " + " | ".join(SPLITS) + " |", "|---|" + "---|" * len(SPLITS)]
    counts += [
        f"| `{name}` | " + " | ".join(str(rows.get(s, 0)) for s in SPLITS) + " |" for name, rows in tables.items()
    ]
    rows.append("\n".join(counts))
    rows.append(
        f"Made by text2sim {__version__} from `recipe.json`; `refused.jsonl` lists refused draws and items with the "
        "reasons. Each source is in one split, with all its cases, variants, counterfactuals and repeats. "
        "`text2sim dataset check` verifies that."
    )
    if benchmarks:
        rows.append("## Simulator benchmarks in `benchmarks/`")
        rows.append(
            "Cases in neutral formats, with observables, references and tolerances, for other simulators: "
            f"{', '.join(f'`{name}`' for name in benchmarks)}. `text2sim benchmark run benchmarks --engine mujoco` "
            "runs them in MuJoCo. They are for comparing simulators, not for training: some are cases of `test`."
        )
    rows.append("## Files of an item in `shards/`")
    rows.append("\n".join(f"- `KEY.{name}`: {words}" for name, words in FILES.items()))
    if recipe.annotations:
        rows.append("## Arrays of `annotations.npz`")
        rows.append("\n".join(f"- `{name}`: {words}" for name, words in ARRAYS.items()))
    for table in tables:
        rows.append(f"## Columns of `{table}`")
        rows.append("\n".join(f"- `{field.name}`: {_description(field)}" for field in SCHEMAS[table]))
    return "\n\n".join(rows) + "\n"


def _croissant(folder: Path, recipe: Recipe, tables: Mapping[str, Counter[str]]) -> dict[str, Any]:
    files, records = [], []
    for table, rows in tables.items():
        for split in rows:
            name = f"{table}-{split}"
            files.append(_file(folder, f"{table}/{split}-00000.parquet", name, "application/x-parquet"))
            fields = [field for column in SCHEMAS[table] if (field := _field(name, column)) is not None]
            records.append({"@type": "cr:RecordSet", "@id": f"{name}-rows", "name": f"{name}-rows", "field": fields})
    for path in sorted((folder / "shards").glob("*.tar")):
        files.append(_file(folder, f"shards/{path.name}", path.name, "application/x-tar"))
    return {
        "@context": CONTEXT,
        "@type": "sc:Dataset",
        "name": recipe.name,
        "description": recipe.description or "Simulated scenes",
        "license": recipe.licence,
        "conformsTo": "http://mlcommons.org/croissant/1.0",
        "distribution": files,
        "recordSet": records,
    }


def _file(folder: Path, url: str, name: str, encoding: str) -> dict[str, Any]:
    return {
        "@type": "cr:FileObject",
        "@id": name,
        "name": name,
        "contentUrl": url,
        "encodingFormat": encoding,
        "sha256": sha256_of(folder / url),
    }


def _field(file: str, column: pa.Field) -> dict[str, Any] | None:
    """A column in Croissant; None for lists and structures, which it cannot describe well."""
    types = {pa.string(): "sc:Text", pa.float64(): "sc:Float", pa.int64(): "sc:Integer", pa.bool_(): "sc:Boolean"}
    if column.type not in types:
        return None
    return {
        "@type": "cr:Field",
        "@id": f"{file}/{column.name}",
        "name": column.name,
        "description": _description(column),
        "dataType": types[column.type],
        "source": {"fileObject": {"@id": file}, "extract": {"column": column.name}},
    }


def _description(column: pa.Field) -> str:
    return (column.metadata or {})[b"description"].decode()
