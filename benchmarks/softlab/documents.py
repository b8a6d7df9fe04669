"""Tables in the docs that come from runs: they stand between two markers, and what they are made of beside them."""

import json
from importlib.metadata import version
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
RESULTS = Path(__file__).parent / "results"


def known(name: str) -> dict[str, Any]:
    """Return the results of earlier runs, by their keys; those of another release of the engine do not count."""
    path = RESULTS / f"{name}.json"
    found = json.loads(path.read_text()) if path.is_file() else {}
    return found.get("results", {}) if found.get("engine") == engine() else {}


def keep(name: str, results: dict[str, Any]) -> None:
    """Write results beside the release of the engine that they were got with."""
    RESULTS.mkdir(exist_ok=True)
    content = {"engine": engine(), "results": dict(sorted(results.items()))}
    (RESULTS / f"{name}.json").write_text(json.dumps(content, indent=1) + "\n")


def engine() -> str:
    """Return the engine's name and release."""
    return f"genesis-world {version('genesis-world')}"


def paste(document: str, marker: str, text: str) -> None:
    """Replace what stands between `<!-- marker -->` and `<!-- end of marker -->` in a document of `docs`."""
    path = ROOT / "docs" / document
    head, rest = path.read_text().split(f"<!-- {marker} -->\n", 1)
    _, tail = rest.split(f"<!-- end of {marker} -->", 1)
    path.write_text(f"{head}<!-- {marker} -->\n{text.strip()}\n<!-- end of {marker} -->{tail}")
