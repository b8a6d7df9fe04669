"""The program of every case in the repository: of six cases as text, of the others by the digests of their files.

Of meshes and pictures, only the names.
"""

import difflib
import json
from hashlib import sha256
from pathlib import Path

import pytest

from text2sim.compiler.build import compile_case
from text2sim.compiler.emit import COPIED_MODULES, COPIED_SOFT
from text2sim.compiler.emit_actions import COPIED_ACTIONS
from text2sim.spec_schema.load import load_case

ROOT = Path(__file__).resolve().parent.parent
GOLDEN = ROOT / "golden"
PRINTED = (".py", ".xml", ".json")
WHOLE = ("brick_wall", "catch_net", "crank_slider", "curtains", "sand_hourglass", "soft_press")
"""Cases whose programs are kept to be read: rigid copies, a net, a mechanism, cloth, grains, a soft body."""
DIGESTS = GOLDEN / "digests.json"
CASES = sorted(path.parent for path in (ROOT.parent / "cases").glob("*/case.yaml"))


@pytest.mark.parametrize("case", CASES, ids=lambda path: path.name)
def test_program_is_golden(case: Path, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    compile_case(load_case(case), tmp_path)
    paths = {str(p.relative_to(tmp_path)): p for p in sorted(tmp_path.rglob("*")) if p.is_file()}
    paths = {name: path for name, path in paths.items() if name not in (*COPIED_MODULES, *COPIED_SOFT, *COPIED_ACTIONS)}
    made = {name: path.read_text() for name, path in paths.items() if path.suffix in PRINTED}
    made["others.txt"] = "".join(f"{name}\n" for name in paths if name not in made)
    update = request.config.getoption("--update-goldens")
    if case.name not in WHOLE:
        _compare_digests(
            case.name, {name: sha256(text.encode()).hexdigest()[:16] for name, text in made.items()}, update
        )
        return
    folder = GOLDEN / case.name
    if update:
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


def _compare_digests(case: str, made: dict[str, str], update: bool) -> None:
    known = json.loads(DIGESTS.read_text()) if DIGESTS.exists() else {}
    if update:
        DIGESTS.write_text(json.dumps(known | {case: made}, indent=1, sort_keys=True) + "\n")
        return
    changed = sorted(name for name, _ in known.get(case, {}).items() ^ made.items())
    assert not changed, (
        f"the program of {case} has changed: text2sim compile cases/{case} and look; then --update-goldens"
    )


def test_every_golden_program_belongs_to_a_case() -> None:
    assert {path.name for path in GOLDEN.iterdir() if path.is_dir()} == set(WHOLE)
    assert json.loads(DIGESTS.read_text()).keys() | set(WHOLE) == {case.name for case in CASES}
