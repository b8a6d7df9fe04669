"""Cases and run folders that need no engine."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import typer

from text2sim.cli.main import make_app
from text2sim.compiler.build import compile_case
from text2sim.harness.run import run_case
from text2sim.spec_schema.changes.edit import edit_text
from text2sim.spec_schema.load import load_case
from text2sim.spec_schema.reuse.migration import LATEST
from text2sim.spec_schema.reuse.overlay import NOTHING, CaseOverlay

CASE = """\
text2sim: 1
name: fall
scene:
  duration: 1.0
  statics:
    floor: {shape: {kind: plane}}
bodies:
  ball:
    kind: rigid
    shape: {kind: sphere, radius: 0.1}
    pose: {pos: [0, 0, 5]}
actions:
  measures:
    height: {kind: position, of: ball, axis: z}
  expect:
    starts_high: {measure: height, at: 0.1, above: 4}
    falls: {measure: height, at: end, below: 1}
"""
LATEST_CASE = edit_text(CASE, [{"op": "replace", "path": "/text2sim", "value": LATEST}])
"""The same in the latest version of the language."""

STAND_IN = """
import json, shutil, sys
from pathlib import Path
OUT = Path(sys.argv[sys.argv.index("--out") + 1])
if "--film-only" not in sys.argv:
    shutil.copytree(Path(__file__).parent / "recording", OUT / "states")
    (OUT / "status.json").write_text(json.dumps({"state": "finished", "time": 1.0}))
if "--no-film" not in sys.argv:
    (OUT / "video.mp4").write_bytes(b"film")
"""


def subcommands() -> list[str]:
    """Return the commands of groups in words, such as `cards show`, without hidden ones."""
    groups = typer.main.get_command(make_app()).commands  # type: ignore[attr-defined]
    parts = {name: getattr(group, "commands", {}) for name, group in groups.items()}
    return [f"{name} {part}" for name, rows in parts.items() for part, row in rows.items() if not row.hidden]


@dataclass(frozen=True)
class Answer:
    """What a command said."""

    code: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        """The one document on the output stream."""
        return json.loads(self.out)


Cli = Callable[..., Answer]


def write_case(folder: Path, text: str) -> Path:
    folder.mkdir(parents=True)
    (folder / "case.yaml").write_text(text)
    return folder


def prepare_run(case: Path, runs: Path, overlay: CaseOverlay = NOTHING) -> Path:
    """Give a case a finished run, recorded by hand, that `text2sim run` takes for its own."""

    def compile_to(loaded: Any, out: Path) -> Any:
        plan = compile_case(loaded, out)
        (out / "main.py").write_text(STAND_IN)
        _record(out / "recording")
        return plan

    return run_case(load_case(case, overlay), runs=runs, compile_to=compile_to).folder


def _record(folder: Path) -> None:
    time = np.linspace(0.0, 1.0, 101)
    place = {"mass": 1.0, "com": [0, 0, 0], "inertia": np.eye(3).tolist()}
    links = [
        {"body": "floor", "link": "floor", "fixed": True, **place},
        {"body": "ball", "link": "ball", "fixed": False, **place},
    ]
    layout = {"dt": 0.01, "every": 1, "gravity": [0, 0, -9.81], "duration": 1.0, "links": links, "joints": []}
    pos = np.zeros((len(time), 2, 3))
    pos[:, 1, 2] = 5 - 4.905 * time**2
    quat = np.broadcast_to([1.0, 0, 0, 0], (len(time), 2, 4))
    still, none = np.zeros((len(time), 2, 3)), np.zeros((len(time), 0))
    contacts = {"step": (), "links": (2,), "force": (3,), "pos": (3,), "penetration": (), "normal_force": ()}
    folder.mkdir()
    (folder / "layout.json").write_text(json.dumps(layout))
    np.savez(
        folder / "chunk_00000.npz",
        time=time, links_pos=pos, links_quat=quat, links_vel=still, links_ang=still,
        qpos=none, dofs_velocity=none, dofs_control_force=none,
        **{f"contact_{name}": np.zeros((0, *shape)) for name, shape in contacts.items()},
    )  # fmt: skip
