"""After the physics is accepted: treatments, judged by path-traced stills alone; nothing is simulated."""

from collections.abc import Mapping, Sequence
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest
from filmed import MakeRun
from PIL import Image

from tests.agents.scripted import Scripted, fenced
from text2sim.agents import cinematography
from text2sim.agents.asking import Desk
from text2sim.agents.cinematography import Cinematography, Marks, styled
from text2sim.agents.models.calls import Account, Budget, CallLog
from text2sim.agents.restyling import physics

CASE = """\
text2sim: 2
name: slides
scene: {duration: 0.4, dt: 0.1, statics: {floor: {shape: {kind: plane}}}}
bodies:
  box: {kind: rigid, shape: {kind: box, size: [0.6, 0.6, 0.6]}, pose: {pos: [0, 0, 0.3]}, look: {color: "#20242a"}}
render: {resolution: [128, 72], fps: 10}
"""
REQUEST = "A dark box slides across a floor."


def marks(content: float, clarity: float, polish: float, appeal: float, better: str = "A lighter ground.") -> str:
    return fenced(
        f"seen: A box.\ncontent: {content}\nclarity: {clarity}\npolish: {polish}\nappeal: {appeal}\nbetter: {better}\n"
    )


def treatment(*operations: str, name: str = "golden") -> str:
    rows = "\n".join(f"      - {row}" for row in operations)
    return fenced(f"treatments:\n  - name: {name}\n    why: light\n    operations:\n{rows}\n")


GOLDEN = treatment("{op: add, path: /render/lighting, value: golden_hour}")
HEAVY = treatment("{op: add, path: /bodies/box/material, value: {density: 1}}")


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures of a real size take a minute each without LLVM."""
    monkeypatch.setattr(cinematography, "WIDTH", 64)


class Studio:
    """A recorded run, somebody who answers from a script, and what happened."""

    def __init__(self, make_run: MakeRun, tmp_path: Path, replies: Mapping[str, Sequence[str]]) -> None:
        boxes = {
            "floor": {"half": (4, 4, 0.01), "pos": (0, 0, -0.01)},
            "box": {"half": 0.3, "pos": (0, 0, 0.3), "velocity": (2, 0, 0)},
        }
        self.run, self.path = make_run(boxes), tmp_path / "case.yaml"
        self.model, self.events = Scripted(replies), list[tuple[str, dict[str, Any]]]()
        desk = Desk({"": self.model}, CallLog(tmp_path / "calls"), Account(), Budget(None, None, None), self.emit)
        self.cinematography = Cinematography(desk, REQUEST, self.path, self.run, self.emit)
        self.refilmed: list[str] = []

    def emit(self, event: str, *, live: bool = False, **what: Any) -> None:
        self.events.append((event, what))

    def shoot(self) -> str:
        return styled(
            self.cinematography, CASE, lambda loaded: self.refilmed.append(loaded.source.text), self.path, self.emit
        )

    def states(self) -> str:
        digest = sha256()
        for path in sorted([*(self.run / "states").iterdir(), *(self.run / "geometry").iterdir()]):
            digest.update(path.read_bytes())
        return digest.hexdigest()

    @property
    def asked(self) -> list[str]:
        return [request.role for request in self.model.asked]


@pytest.mark.usefixtures("tracer")
def test_the_best_goes_on_and_the_physics_is_the_same_before_and_after(make_run: MakeRun, tmp_path: Path) -> None:
    low, better = marks(70, 40, 60, 50), marks(85, 84, 80, 80)
    studio = Studio(make_run, tmp_path, {"viewer": [low, low, better], "render": [HEAVY, GOLDEN]})
    before = studio.states()
    text = studio.shoot()
    assert "lighting: golden_hour" in text
    assert studio.refilmed == [text], "the run gets the film of the best"
    assert physics(text, studio.path) == physics(CASE, studio.path)
    assert studio.states() == before, "not a byte of what was recorded is another"
    assert studio.asked == ["viewer", "render", "render", "viewer", "viewer"], "as it is; proposals; both of them"
    refused = studio.model.questions("render")[1]
    assert "`/bodies/box/material` is neither below /render nor a look" in refused
    viewed = [what["total"] for event, what in studio.events if event == "viewed"]
    assert viewed == [pytest.approx(55.5), pytest.approx(55.5), pytest.approx(82.7)]
    (shown,) = studio.model.asked[0].messages[-1].images
    with Image.open(BytesIO(shown.data)) as sheet:
        assert sheet.width > 2 * 64
    question = studio.model.asked[0].messages[-1].text
    assert REQUEST in question
    assert "density" not in question
    assert "bodies:" not in question, "the judge sees the request and the pictures, and no case"


@pytest.mark.usefixtures("tracer")
def test_a_film_that_is_good_costs_one_question(make_run: MakeRun, tmp_path: Path) -> None:
    studio = Studio(make_run, tmp_path, {"viewer": [marks(90, 85, 80, 82)]})
    assert studio.shoot() == CASE
    assert studio.asked == ["viewer"]
    assert not studio.refilmed


@pytest.mark.usefixtures("tracer")
def test_whoever_cannot_film_it_loses_nothing(make_run: MakeRun, tmp_path: Path) -> None:
    studio = Studio(make_run, tmp_path, {})  # the model is gone
    assert studio.shoot() == CASE
    assert studio.events[-1][0] == "not_styled"
    studio.model.vision = False
    assert studio.shoot() == CASE
    assert "cannot see" in studio.events[-1][1]["why"]


def test_the_weights_of_the_marks() -> None:
    assert Marks(seen="", content=100, clarity=0, polish=0, appeal=0).total == 30
    assert Marks(seen="", content=0, clarity=100, polish=0, appeal=0).total == 30
    assert Marks(seen="", content=0, clarity=0, polish=100, appeal=0).total == 25
    assert Marks(seen="", content=0, clarity=0, polish=0, appeal=100).total == 15
