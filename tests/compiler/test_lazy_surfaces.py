"""Surfaces and files that are made when they are asked for: a check that is made again needs no arrays."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from text2sim.compiler.build import resolve_case
from text2sim.compiler.files import Files
from text2sim.compiler.shapes.surface import LazyMesh, learn_digests, surface
from text2sim.spec_schema.load import load_case
from text2sim.spec_schema.models.shapes import Cup

CUP = Cup(kind="cup", radius=0.05, height=0.1, thickness=0.005)
TURN = (0.8, 0.6, 0.0, 0.0)


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache"


def test_a_check_that_is_made_again_makes_no_surface(cases: Path) -> None:
    code = (
        "import sys; from pathlib import Path; from text2sim.compiler.build import resolve_case;"
        "from text2sim.spec_schema.load import load_case; from text2sim.lint import lint_case;"
        f"lint_case(resolve_case(load_case(Path({str(cases / 'laid_table')!r})))); print('numpy' in sys.modules)"
    )
    said = [
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=120).stdout
        for _ in range(2)
    ]
    assert said == ["True\n", "False\n"]


@pytest.mark.parametrize("case", ["brick_wall", "conveyor_sorter", "curtains"])
def test_a_check_loads_no_library_of_meshes_and_builds_validators_of_its_own_kinds(cases: Path, case: str) -> None:
    code = (
        "import json, sys; from pathlib import Path; from text2sim.compiler.build import resolve_case;"
        "from text2sim.spec_schema.load import load_case; from text2sim.lint import lint_case;"
        "from text2sim.spec_schema.models.base import Model; from text2sim.spec_schema.vocabulary.words import kinds_of;"
        f"loaded = load_case(Path({str(cases / case)!r})); lint_case(resolve_case(loaded));"
        "families = [Model]; [families.extend(m.__subclasses__()) for m in families];"
        "print(json.dumps([sorted({'trimesh', 'scipy', 'shapely'} & set(sys.modules)),"
        " {m.__name__: kinds_of(m) for m in families[1:] if m.__pydantic_complete__}, json.dumps(loaded.data)]))"
    )
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=120)
    libraries, built, data = json.loads(answer.stdout)
    assert libraries == []
    assert built.pop("Case") == []
    assert "Rigid" in built
    assert [
        name for name, kinds in built.items() if kinds and not any(f'"kind": "{kind}"' in data for kind in kinds)
    ] == []


def test_what_is_remembered_changes_nothing(cases: Path) -> None:
    first, second = (resolve_case(load_case(cases / "crank_slider")).plan for _ in range(2))
    assert dict(first.files) == dict(second.files)
    assert first.sim_digest == second.sim_digest
    assert any(path.endswith(".obj") for path in first.files)


@pytest.mark.parametrize("pos", [(0.0, 0.0, 0.0), (0.1, -0.2, 0.3)])
def test_a_surface_knows_its_digest_before_it_is_made(pos: tuple[float, float, float]) -> None:
    made = surface(CUP).at(pos, TURN, "a")
    learn_digests([made])
    again = surface(CUP).at(pos, TURN, "b")
    learn_digests([again])
    assert isinstance(again, LazyMesh)
    assert "_made" in made.__dict__
    assert "_made" not in again.__dict__
    assert (again.digest, again.part) == (made.digest, "b")
    assert again.obj() == made.obj()
    other = surface(CUP).at((9.0, 0.0, 0.0), TURN, "a")
    learn_digests([other])
    assert other.digest != made.digest


def test_files_are_made_once_and_only_if_asked_for() -> None:
    files, made = Files(), []
    files.later("a", lambda: made.append("a") or "text")
    files.later("a", lambda: made.append("again") or "other")
    files["b"] = b"bytes"
    assert (sorted(files), "a" in files, len(files), made) == (["a", "b"], True, 2, [])
    assert dict(files) == {"a": b"text", "b": b"bytes"}
    assert files["a"] == b"text"
    assert made == ["a"]
