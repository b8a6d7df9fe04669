"""The program of every case in the repository, byte for byte."""

import difflib
from pathlib import Path

import pytest

from text2sim.compiler.build import compile_case
from text2sim.compiler.emit import COPIED
from text2sim.spec_schema.load import load_case

ROOT = Path(__file__).resolve().parent.parent
GOLDEN = ROOT / "golden"
CASES = sorted(path.parent for path in (ROOT.parent / "cases").glob("*/case.yaml"))


@pytest.mark.parametrize("case", CASES, ids=lambda path: path.name)
def test_program_is_golden(case: Path, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    compile_case(load_case(case), tmp_path)
    made = {str(p.relative_to(tmp_path)): p.read_text() for p in sorted(tmp_path.rglob("*")) if p.is_file()}
    made = {name: text for name, text in made.items() if name not in COPIED}
    folder = GOLDEN / case.name
    if request.config.getoption("--update-goldens"):
        for old in sorted(folder.rglob("*"), reverse=True):
            old.unlink() if old.is_file() else old.rmdir()
        for name, text in made.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_text(text)
    known = {str(p.relative_to(folder)): p.read_text() for p in sorted(folder.rglob("*")) if p.is_file()}
    if made != known:
        diff = [
            line
            for name in sorted(made.keys() | known.keys())
            for line in difflib.unified_diff(
                known.get(name, "").splitlines(),
                made.get(name, "").splitlines(),
                f"golden/{name}",
                f"made/{name}",
                lineterm="",
            )
        ]
        pytest.fail("\n".join([*diff[:60], "if this is meant: pytest tests/compiler/test_golden.py --update-goldens"]))


def test_every_golden_program_belongs_to_a_case() -> None:
    assert {path.name for path in GOLDEN.iterdir()} == {case.name for case in CASES}
