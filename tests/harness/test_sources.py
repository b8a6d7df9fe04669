"""Which of our own code a simulation depends on, and which only its film."""

import ast
import shutil
from pathlib import Path

import pytest

from text2sim.compiler.emit import FILM_TEMPLATES
from text2sim.harness import sources


@pytest.fixture
def copied(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """A copy of the templates that may be edited."""
    shutil.copytree(sources.TEMPLATES, tmp_path / "templates")
    monkeypatch.setattr(sources, "TEMPLATES", tmp_path / "templates")
    return tmp_path / "templates"


@pytest.mark.parametrize(
    ("name", "films"),
    [
        *((name, True) for name in ("film.py", "cameras.py", "viewpoints.py", "soft_film.py", "render.py.j2")),
        *((name, False) for name in ("recorder.py", "main.py.j2", "soft.py", "actions/drive.py.j2")),
    ],
)
def test_a_change_counts_where_it_matters(copied: Path, name: str, films: bool) -> None:
    simulation, film = sources.simulation_code(), sources.film_code()
    with (copied / name).open("a") as stream:
        stream.write("\n# changed\n")
    assert (sources.simulation_code() == simulation) == films
    assert (sources.film_code() == film) != films


def test_nothing_that_simulates_asks_what_only_films() -> None:
    filming = {Path(name).stem for name in FILM_TEMPLATES if name.endswith(".py")}
    assert all((sources.TEMPLATES / name).is_file() for name in FILM_TEMPLATES)
    for path in sources.TEMPLATES.glob("*.py"):
        if path.name in FILM_TEMPLATES:
            continue
        for node in ast.walk(ast.parse(path.read_text())):
            named = [node.module] if isinstance(node, ast.ImportFrom) else []
            named += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            assert not filming & {str(name) for name in named}, path.name
