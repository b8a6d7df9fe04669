"""The layers of the package: who may import whom, and that nobody imports in a circle."""

import ast
import re
import tomllib
from collections import Counter
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import grimp
import pytest
from importlinter.api import read_configuration
from importlinter.application.use_cases import lint_imports

ROOT = Path(__file__).resolve().parents[1]


def test_imports_keep_to_the_layers() -> None:
    assert read_configuration(str(ROOT / "pyproject.toml"))["contracts_options"]
    assert lint_imports(config_filename=str(ROOT / "pyproject.toml"), cache_dir=None), "see `lint-imports`"


def test_no_modules_import_each_other_in_a_circle() -> None:
    graph = grimp.build_graph("text2sim", exclude_type_checking_imports=True, cache_dir=None)
    above = {module: graph.find_modules_directly_imported_by(module) for module in graph.modules}
    try:
        TopologicalSorter(above).prepare()
    except CycleError as error:
        pytest.fail(" <- ".join(error.args[1]))


def test_the_documented_layers_are_those_of_the_contract() -> None:
    config = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    contract = config["tool"]["importlinter"]["contracts"][0]
    layers = [set(layer.split(" | ")) for layer in contract["layers"]]
    text = (ROOT / "docs" / "architecture.md").read_text("utf-8")
    rows = re.findall(r"^\| `(\w+)` \|", text[: text.index("Inside `spec_schema`")], re.MULTILINE)
    assert Counter(rows) == Counter(name for layer in layers for name in layer)
    depth = [next(i for i, layer in enumerate(layers) if row in layer) for row in rows]
    assert depth == sorted(depth), "rows stand in the order of the layers"


def test_benchmarks_import_what_is_there() -> None:
    """Nothing else notices one that no longer starts: they are run by hand, for the figures in the docs."""
    wrong = []
    for file in sorted((ROOT / "benchmarks").rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text("utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("text2sim"):
                try:
                    exec(ast.unparse(node), {})
                except ImportError as error:
                    wrong.append(f"{file.relative_to(ROOT)}:{node.lineno}: {error}")
    assert wrong == []
