"""What others read first: the card, with what `datasets` needs to know, and the metadata in Croissant.

Croissant: https://docs.mlcommons.org/croissant/docs/croissant-spec.html
"""

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from hashlib import file_digest
from pathlib import Path
from typing import Any

import pyarrow as pa
import yaml

from text2sim import __version__
from text2sim.dataset.annotations import ARRAYS
from text2sim.dataset.recipe import SPLITS, Recipe
from text2sim.dataset.tables import SCHEMAS
from text2sim.recording.record import write_atomically

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
    "film.mp4": "the film, H.264; sharp pinhole pictures, nothing written into them",
    "annotations.npz": "arrays of every picture, see below",
    "states.npz": "time (F,) [s]; pos, quat (w, x, y, z), vel, ang of links (F, L, …) [SI, world]; qpos, "
    "dofs_velocity, dofs_force of joints; soft_points (T, P, 3) at the times of the pictures",
    "layout.json": "links, joints, deforming bodies: the columns of `states.npz`",
    "case.yaml": "the case as it was run",
    "program.zip": "the program that it became",
    "evidence.json, events.jsonl, measures.csv": "measures, events and touches, expectations, diagnostics",
    "json": "the item's row of the table",
}


def write_card(folder: Path, recipe: Recipe, tables: Mapping[str, Counter[str]]) -> None:
    """Write `README.md` and `croissant.json`. Benchmarks that lie in the folder are named.

    Args:
        folder: The dataset.
        recipe: What it was made from.
        tables: Rows by table and split.
    """
    configs = [
        {
            "config_name": table,
            "data_files": [
                {"split": split, "path": f"{table}/{split}-*.parquet"}
                for split in SPLITS
                if rows.get(split) is not None
            ],
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
    rows = [f"# {recipe.name}", recipe.description or "Simulated scenes: films, what happens in them, and why."]
    counts = ["| table | " + " | ".join(SPLITS) + " |", "|---|" + "---|" * len(SPLITS)]
    counts += [
        f"| `{name}` | " + " | ".join(str(rows.get(s, 0)) for s in SPLITS) + " |" for name, rows in tables.items()
    ]
    rows.append("\n".join(counts))
    rows.append(
        f"Made by text2sim {__version__} from `recipe.json`; what was refused, and why, is in `refused.jsonl`. No "
        "source lies in two splits, and with it no case, variant, counterfactual or repeat of one. "
        "`text2sim dataset check` proves that."
    )
    if benchmarks:
        rows.append("## Simulator benchmarks in `benchmarks/`")
        rows.append(
            "Cases as neutral files, with observables, references and tolerances, for other simulators: "
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
        rows.append(
            "\n".join(
                f"- `{field.name}`: {(field.metadata or {})[b'description'].decode()}" for field in SCHEMAS[table]
            )
        )
    return "\n\n".join(rows) + "\n"


def _croissant(folder: Path, recipe: Recipe, tables: Mapping[str, Counter[str]]) -> dict[str, Any]:
    files, records = [], []
    for table, rows in tables.items():
        for split in rows:
            name = f"{table}-{split}"
            path = folder / table / f"{split}-00000.parquet"
            with path.open("rb") as file:
                digest = file_digest(file, "sha256").hexdigest()
            files.append(
                {
                    "@type": "cr:FileObject",
                    "@id": name,
                    "name": name,
                    "contentUrl": path.relative_to(folder).as_posix(),
                    "encodingFormat": "application/x-parquet",
                    "sha256": digest,
                }
            )
            fields = [field for one in SCHEMAS[table] if (field := _field(name, one)) is not None]
            records.append({"@type": "cr:RecordSet", "@id": f"{name}-rows", "name": f"{name}-rows", "field": fields})
    for path in sorted((folder / "shards").glob("*.tar")):
        with path.open("rb") as file:
            digest = file_digest(file, "sha256").hexdigest()
        files.append(
            {
                "@type": "cr:FileObject",
                "@id": path.name,
                "name": path.name,
                "contentUrl": f"shards/{path.name}",
                "encodingFormat": "application/x-tar",
                "sha256": digest,
            }
        )
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


def _field(file: str, one: pa.Field) -> dict[str, Any] | None:
    """Return a column in Croissant; None for lists of structures, which it does not tell well."""
    kind, repeated = one.type, pa.types.is_list(one.type)
    kind = kind.value_type if repeated else kind
    name = {pa.string(): "sc:Text", pa.float64(): "sc:Float", pa.int64(): "sc:Integer", pa.bool_(): "sc:Boolean"}.get(
        kind
    )
    if name is None or repeated:
        return None
    return {
        "@type": "cr:Field",
        "@id": f"{file}/{one.name}",
        "name": one.name,
        "description": (one.metadata or {})[b"description"].decode(),
        "dataType": name,
        "source": {"fileObject": {"@id": file}, "extract": {"column": one.name}},
    }
