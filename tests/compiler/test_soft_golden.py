"""Programs with deformable bodies, byte for byte; of their meshes, the names."""

import difflib
from pathlib import Path

import pytest

from text2sim.compiler.build import compile_case
from text2sim.compiler.emit import MODULES
from text2sim.spec_schema.load import load_case

PROGRAMS = Path(__file__).resolve().parent.parent / "soft_programs"
CASES = sorted(path.parent for path in PROGRAMS.glob("*/case.yaml"))


@pytest.mark.parametrize("case", CASES, ids=lambda path: path.name)
def test_soft_program_is_golden(case: Path, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    compile_case(load_case(case), tmp_path)
    made = {name: (tmp_path / name).read_text() for name in MODULES}
    meshes = sorted(path.name for path in (tmp_path / "models").glob("*.obj")) if (tmp_path / "models").exists() else []
    made["meshes.txt"] = "".join(f"{name}\n" for name in meshes)
    if request.config.getoption("--update-goldens"):
        for name, text in made.items():
            (case / name).write_text(text)
    known = {name: (case / name).read_text() if (case / name).exists() else "" for name in made}
    if made != known:
        diff = [
            line
            for name in made
            for line in difflib.unified_diff(
                known[name].splitlines(), made[name].splitlines(), f"golden/{name}", f"made/{name}", lineterm=""
            )
        ]
        pytest.fail("\n".join([*diff[:60], "if this is meant: pytest tests/compiler --update-goldens"]))


def test_same_case_same_bytes(tmp_path: Path) -> None:
    for name in ("first", "second"):
        compile_case(load_case(PROGRAMS / "squash"), tmp_path / name)
    first, second = (
        {str(p.relative_to(tmp_path / name)): p.read_bytes() for p in (tmp_path / name).rglob("*") if p.is_file()}
        for name in ("first", "second")
    )
    assert first == second
    assert {"filling.py", "soft.py", "soft_film.py"} <= first.keys()
