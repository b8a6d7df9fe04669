"""Commands in a working directory that is somebody else's."""

import subprocess
import sys
from pathlib import Path

from text2sim.service import exits


def test_no_module_of_the_working_directory_is_imported(case: Path, tmp_path: Path) -> None:
    for module in ("ruff", "mcp", "numpy", "typer", "yaml"):
        (tmp_path / f"{module}.py").write_text(f"open('imported-{module}', 'w')")
    command = [sys.executable, "-m", "text2sim", "compile", str(case), "-o", "program"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert not list(tmp_path.glob("imported-*"))
    assert done.returncode == exits.OK, done.stderr
    assert (tmp_path / "program" / "main.py").is_file()
