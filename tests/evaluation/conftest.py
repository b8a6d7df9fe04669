"""Suites, method folders with real films and recorded runs, and judges, none of which needs the engine."""

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.agents.models.chat_server import Answer, ChatServer, completion
from tests.harness.conftest import WrittenRun
from text2sim.compiler.build import compile_case
from text2sim.evaluation.method_folder import CaseResult, MethodRecord, Resources, write_method, write_result
from text2sim.harness.run import run_case
from text2sim.spec_schema.load import load_case
from text2sim.templates.video import Video

SUITE = """\
text2sim_suite: 1
name: small
prompts:
  drop:
    family: rigid
    source: {title: "On falling balls", authors: "A. Nobody", year: 1999, venue: "Nowhere"}
    prompt: A red ball falls onto a flat floor.
    requirements:
      scene:
        floor: {what: "a flat floor", importance: 3}
      body:
        ball: {what: "a ball", importance: 4}
        red: {what: "the ball is red", importance: 2}
      action:
        falls: {what: "the ball falls", importance: 5}
        lands: {what: "it reaches the floor", importance: 5}
      render:
        seen: {what: "the whole fall is seen", importance: 3}
        near: {what: "the ball is large", importance: 1}
    prohibitions:
      through: {what: "the ball does not pass through the floor", weight: 3}
      early: {what: "the ball does not start on the floor", weight: 1}
  sag:
    family: cloth
    source: {title: "On sagging cloths", authors: "B. Nobody", year: 2001, venue: "Nowhere"}
    prompt: A cloth that hangs by two corners sags.
    requirements:
      scene:
        posts: {what: "two points hold it", importance: 1}
      body:
        cloth: {what: "a cloth", importance: 1}
      action:
        sags: {what: "it sags", importance: 1}
      render:
        seen: {what: "it is seen", importance: 1}
"""

CASE = """\
text2sim: 2
name: drop
prompt: A red ball falls.
scene:
  duration: 1.0
  statics:
    floor: {shape: {kind: plane}}
bodies:
  ball:
    kind: rigid
    shape: {kind: sphere, radius: 0.1}
    pose: {pos: [0, 0, 5]}
    look: {color: red}
actions:
  measures:
    height: {kind: position, of: ball, axis: z}
  expect:
    falls: {measure: height, at: end, below: 1}
"""

STAND_IN = """
import json, shutil, sys
from pathlib import Path
OUT = Path(sys.argv[sys.argv.index("--out") + 1])
shutil.copytree(Path(__file__).parent / "recording", OUT / "states")
(OUT / "status.json").write_text(json.dumps({"state": "finished", "time": 1.0}))
"""

PHYSICAL = """
requirements:
  scene.floor: {mark: 1}
  body.ball: {mark: 1}
  body.red: {mark: 0.5, evidence: "frame 2: it is rather orange"}
  action.falls: {mark: 1}
  action.lands: {mark: 0, evidence: "frame 10: it ends above the floor"}
  render.seen: {mark: 1}
  render.near: {mark: 0.5, evidence: "frame 1: it is small"}
prohibitions:
  through: {violated: no}
  early: {violated: yes, evidence: "frame 1: it touches the floor"}
aesthetics: 60
execution: usable
motion: simulated
"""
SAG = """
requirements:
  scene.posts: {mark: 1}
  body.cloth: {mark: 1}
  action.sags: {mark: 1}
  render.seen: {mark: 1}
aesthetics: 50
execution: usable
motion: simulated
"""
VISUAL = "content: 80\ndepiction: 60\npolish: 40\nimpact: 20\n"
FACTS = "facts:\n  body.red: [{color: ball, like: red}]\n  body.ball: [{count: ball, equals: 2}]\n"


def write_film(path: Path, size: tuple[int, int] = (96, 54), pictures: int = 30, cut: int | None = None) -> Path:
    """A square that moves over a grey ground, with a white picture from `cut` on."""
    video = Video(path, size, 10)
    for k in range(pictures):
        image = np.full((size[1], size[0], 3), 90, np.uint8)
        image[20:30, k : k + 10] = (200, 30, 30)
        if cut is not None and k >= cut:
            image[:] = 255 - image // 4
        video.write(image)
    video.close()
    return path


def fall(run: WrittenRun, *, speed: float = 1.0) -> None:
    """Record a floor and a ball that falls freely from 5 m; `speed` 0 writes velocities of something at rest."""
    run.add_link("floor", fixed=True)
    place = np.stack([0 * run.time, 0 * run.time, 5 - 4.905 * run.time**2], axis=1)
    velocity = np.stack([0 * run.time, 0 * run.time, -9.81 * run.time * speed], axis=1)
    run.add_link("ball", pos=place, vel=velocity)


@pytest.fixture
def suite(tmp_path: Path) -> Path:
    """A suite of two prompts."""
    (tmp_path / "small.yaml").write_text(SUITE)
    return tmp_path / "small.yaml"


def make_run(folder: Path, record: Callable[[WrittenRun], None] = fall) -> Path:
    """Make a finished run of the case `drop` in a folder."""

    def compile_to(loaded: Any, out: Path) -> Any:
        plan = compile_case(loaded, out)
        (out / "main.py").write_text(STAND_IN)
        run = WrittenRun(out / "made")
        record(run)
        run.write()
        shutil.move(out / "made" / "states", out / "recording")
        return plan

    case = folder / "case"
    case.mkdir(parents=True)
    (case / "case.yaml").write_text(CASE)
    made = run_case(load_case(case), runs=folder / "runs", compile_to=compile_to, film=False).folder
    return made.rename(folder / "run")


@pytest.fixture(scope="session")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with `case`, `run` and `film.mp4`, made once."""
    folder = tmp_path_factory.mktemp("recorded")
    make_run(folder)
    write_film(folder / "film.mp4")
    return folder


@pytest.fixture
def make_method(tmp_path: Path, recorded: Path) -> Callable[..., Path]:
    """Return a function that makes a method folder: `drop` with film, case and run, `sag` with a film alone."""

    def make(name: str, tokens: int = 1000) -> Path:
        folder = tmp_path / "methods" / name
        drop, sag = folder / "drop", folder / "sag"
        shutil.copytree(recorded, drop)
        sag.mkdir()
        shutil.copy(recorded / "film.mp4", sag)
        roles = {"planner": Resources(calls=1, tokens_in=tokens, tokens_out=10, cost=0.25, seconds=3.0)}
        one = CaseResult(
            prompt="drop", status="finished", film="film.mp4", program="case/case.yaml", run="run", roles=roles,
            attempts=2, wall_s=60.0, simulation_s=20.0,
        )  # fmt: skip
        write_result(drop, one)
        write_result(sag, CaseResult(prompt="sag", status="finished", film="film.mp4", attempts=4, wall_s=20.0))
        write_method(folder, MethodRecord(name=name, suite="small"))
        return folder

    return make


class Judge(ChatServer):
    """A judge behind the protocol of OpenAI, who answers by what it is asked for; replies can be replaced."""

    def __init__(self) -> None:
        super().__init__(self._answer)
        self.replies: dict[str, Any] = {"physical": PHYSICAL, "sag": SAG, "visual": VISUAL, "check": FACTS}

    @property
    def model(self) -> str:
        """Its name for `--judge`."""
        return f"openai/judge@{self.url},vision=yes"

    def asked(self, kind: str) -> list[str]:
        """What it was sent as text, of one kind."""
        return [text for text in map(self._text, self.requests) if self._kind(text) == kind]

    def _answer(self) -> Answer:
        text = self._text(self.requests[-1])
        reply = self.replies[self._kind(text)]
        return completion(f"```yaml\n{reply() if callable(reply) else reply}\n```")

    @staticmethod
    def _text(request: dict[str, Any]) -> str:
        rows = [message["content"] for message in request["messages"]]
        return "\n".join(row if isinstance(row, str) else "\n".join(p.get("text", "") for p in row) for row in rows)

    @staticmethod
    def _kind(text: str) -> str:
        if text.startswith("A program can tell"):
            return "check"
        if text.startswith("You judge a film"):
            return "visual"
        if text.startswith("You look back"):
            return "lesson"
        if text.startswith("Two Debug Cards"):
            return "merge"
        return "sag" if "hangs by two corners" in text else "physical"


@pytest.fixture
def judge() -> Any:
    """A judge on this machine."""
    with Judge() as server:
        yield server
