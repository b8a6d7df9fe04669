"""Inspection of models with MuJoCo in a child process, so that a hostile file cannot crash ours."""

import json
import subprocess
import sys
import tempfile
from functools import lru_cache
from pathlib import Path
from typing import Any

from text2sim.assets.answer_cache import cached_answer
from text2sim.assets.confined import end_of, environment_without_keys
from text2sim.spec_schema.errors import AssetError
from text2sim.spec_schema.whole_files import naming

SCRIPT = Path(__file__).with_name("inspection_child.py")
TIMEOUT = 120
"""Seconds; a robot of a hundred meshes takes five on a busy machine."""

Files = tuple[tuple[str, bytes], ...]


@lru_cache(maxsize=32)
def inspect_model(kind: str, text: str, files: Files) -> dict[str, Any]:
    """Return bodies, joints, geoms and motors of a model as plain data, from the cache if possible.

    Args:
        kind: `mjcf` or `urdf`.
        text: The document.
        files: Name and content of every file that it refers to.

    Raises:
        AssetError: if MuJoCo refuses it, crashes on it, or needs too much time or memory.
    """
    named = [part for file, content in files for part in (file.encode(), content)]
    question = [SCRIPT.read_bytes(), kind.encode(), text.encode(), *named]
    return cached_answer(question, lambda: _ask_mujoco(kind, text, files))


def _ask_mujoco(kind: str, text: str, files: Files) -> dict[str, Any]:
    with tempfile.TemporaryDirectory(prefix="text2sim-") as name:
        folder = Path(name)
        with naming(folder):
            (folder / "files").mkdir()
            for file, content in files:
                (folder / "files" / file).write_bytes(content)
            (folder / "model.xml").write_text(text, "utf-8")
        # The script imports nothing of ours, and must not find our modules in place of others.
        environment = environment_without_keys()
        del environment["PYTHONPATH"]
        command = [sys.executable, "-P", str(SCRIPT), kind, str(folder)]
        try:
            done = subprocess.run(
                command, cwd=folder, env=environment, capture_output=True, timeout=TIMEOUT, check=False
            )
        except subprocess.TimeoutExpired:
            raise AssetError(f"takes MuJoCo more than {TIMEOUT} s to read") from None
        result = folder / "result.json"
        if done.returncode or not result.is_file():
            raise AssetError(f"crashes MuJoCo ({end_of(done)})")
        found: dict[str, Any] = json.loads(result.read_text("utf-8"))
    if "error" in found:
        raise AssetError(f"is refused by MuJoCo: {found['error'][:300]}")
    return found
