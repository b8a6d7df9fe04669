"""After the physics is accepted: treatments, judged by path-traced stills alone; nothing is simulated."""

import re
from collections.abc import Mapping, Sequence
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from threading import Barrier
from types import SimpleNamespace
from typing import Any

import pytest
from filmed import MakeRun
from PIL import Image

from tests.agents.scripted import Scripted, fenced
from text2sim.agents import cinematography
from text2sim.agents.attempts import Attempts
from text2sim.agents.cinematography import Cinematography, Marks, best_treatment
from text2sim.agents.conversation import Conversation
from text2sim.agents.models.calls import Account, Budget, CallLog
from text2sim.agents.models.exchange import StoppedError
from text2sim.agents.restyling import physics_digest
from text2sim.compiler.build import plan_case
from text2sim.harness import run as harness_run
from text2sim.spec_schema.errors import RunError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.loaded import LoadedCase

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
    monkeypatch.setattr(cinematography, "STILL_WIDTH", 64)


class Studio:
    """A recorded run, somebody who answers from a script, and what happened."""

    def __init__(self, make_run: MakeRun, tmp_path: Path, replies: Mapping[str, Sequence[str]]) -> None:
        boxes = {
            "floor": {"half": (4, 4, 0.01), "pos": (0, 0, -0.01)},
            "box": {"half": 0.3, "pos": (0, 0, 0.3), "velocity": (2, 0, 0)},
        }
        self.run, self.path = make_run(boxes), tmp_path / "case.yaml"
        self.model, self.events = Scripted(replies), list[tuple[str, dict[str, Any]]]()
        chat = Conversation({"": self.model}, CallLog(tmp_path / "calls"), Account(), Budget(minutes=60), self.emit)
        self.cinematography = Cinematography(chat, REQUEST, self.path, self.run, self.emit)
        self.refilmed: list[str] = []

    def emit(self, event: str, *, live: bool = False, **what: Any) -> None:
        self.events.append((event, what))

    def shoot(self) -> str:
        return best_treatment(
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
    low, better = marks(70, 40, 60, 50), marks(88, 87, 85, 85)
    studio = Studio(make_run, tmp_path, {"viewer": [low, better], "render": [HEAVY, GOLDEN]})
    before = studio.states()
    text = studio.shoot()
    assert "lighting: golden_hour" in text
    assert studio.refilmed == [text], "the run gets the film of the best"
    assert physics_digest(text, studio.path) == physics_digest(CASE, studio.path)
    assert studio.states() == before, "not a byte of what was recorded is another"
    assert studio.asked == ["viewer", "render", "render", "viewer"], "as it is; a refused proposal; its correction"
    refused = studio.model.questions("render")[1]
    assert "`/bodies/box/material` is neither below /render nor a look" in refused
    viewed = [what["total"] for event, what in studio.events if event == "viewed"]
    assert viewed == [pytest.approx(55.5), pytest.approx(86.5)]
    (shown,) = studio.model.asked[0].messages[-1].images
    with Image.open(BytesIO(shown.data)) as sheet:
        assert sheet.width > 2 * 64
    question = studio.model.asked[0].messages[-1].text
    assert REQUEST in question
    assert "density" not in question
    assert "bodies:" not in question, "the judge sees the request and the pictures, and no case"


@pytest.mark.usefixtures("tracer")
def test_a_film_that_is_excellent_costs_one_question(make_run: MakeRun, tmp_path: Path) -> None:
    studio = Studio(make_run, tmp_path, {"viewer": [marks(94, 92, 90, 88)]})
    assert studio.shoot() == CASE
    assert studio.asked == ["viewer"]
    assert not studio.refilmed


@pytest.mark.usefixtures("untraced")
def test_a_film_that_is_good_gets_one_more_treatment(make_run: MakeRun, tmp_path: Path) -> None:
    good, less = marks(88, 86, 85, 86), marks(80, 80, 80, 80)
    studio = Studio(make_run, tmp_path, {"viewer": [good, less], "render": [light("golden_hour")]})
    assert studio.shoot() == CASE
    assert studio.asked == ["viewer", "render", "viewer"]


@pytest.mark.usefixtures("tracer")
def test_whoever_cannot_film_it_loses_nothing(make_run: MakeRun, tmp_path: Path) -> None:
    studio = Studio(make_run, tmp_path, {})  # the model is gone
    assert studio.shoot() == CASE
    assert studio.events[-1][0] == "not_styled"
    studio.model.vision = False
    assert studio.shoot() == CASE
    assert "does not accept pictures" in studio.events[-1][1]["why"]


@pytest.fixture
def untraced(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Stills that nobody traced: which treatments were to be filmed, and a plain picture of each."""
    shot: list[str] = []

    def stills(run: Path, loaded: LoadedCase) -> tuple[bytes, int]:
        shot.append(loaded.source.text)
        if "dark_stage" in loaded.source.text:
            raise RunError("this treatment cannot be traced")
        plain = BytesIO()
        Image.new("RGB", (8, 8), (len(shot), 0, 0)).save(plain, "PNG")
        return plain.getvalue(), 1

    monkeypatch.setattr(cinematography, "stills", stills)
    return shot


def two_lights(*names: str) -> str:
    rows = (f"  - {{name: {name}, operations: [{{op: add, path: /render/lighting, value: {name}}}]}}" for name in names)
    return fenced("\n".join(["treatments:", *rows]))


def light(name: str) -> str:
    return treatment(f"{{op: add, path: /render/lighting, value: {name}}}", name=name)


@pytest.mark.usefixtures("untraced")
def test_the_best_so_far_is_kept_when_the_judge_fails(make_run: MakeRun, tmp_path: Path) -> None:
    low, good, less = marks(40, 40, 40, 40), marks(75, 75, 75, 75), marks(60, 60, 60, 60)
    replies = {"viewer": [low, good, less], "render": [light("golden_hour"), light("overcast"), light("studio")]}
    studio = Studio(make_run, tmp_path, replies)  # the third round's judge is gone
    text = studio.shoot()
    assert "lighting: golden_hour" in text
    assert studio.refilmed == [text]
    assert [event for event, _ in studio.events][-2:] == ["treatments_failed", "styled"]


@pytest.mark.parametrize(("late", "asked"), [(62, 3), (66, 2)])
def test_what_was_written_in_time_is_judged_beyond_it(
    make_run: MakeRun, tmp_path: Path, untraced: list[str], monkeypatch: pytest.MonkeyPatch, late: float, asked: int
) -> None:
    replies = {"viewer": [marks(40, 40, 40, 40), marks(75, 75, 75, 75)], "render": [light("golden_hour")]}
    studio = Studio(make_run, tmp_path, replies)
    # The stills of the treatment are traced when the 60 minutes are over.
    monkeypatch.setattr(Budget, "minutes_used", property(lambda budget: late if len(untraced) > 1 else 50))
    assert ("lighting: golden_hour" in studio.shoot()) == (asked == 3)
    assert studio.asked == ["viewer", "render", "viewer"][:asked]
    assert ("treatments_failed", {"why": "60 minutes are over"}) in studio.events


@pytest.mark.usefixtures("untraced")
def test_after_a_round_without_a_usable_answer_the_next_one_asks_again(make_run: MakeRun, tmp_path: Path) -> None:
    replies = {"viewer": [marks(40, 40, 40, 40), marks(90, 90, 90, 90)], "render": ["x", "x", "x", light("overcast")]}
    studio = Studio(make_run, tmp_path, replies)
    assert "lighting: overcast" in studio.shoot()
    assert [event for event, _ in studio.events].count("treatments_failed") == 1


def test_a_treatment_that_cannot_be_traced_costs_no_other(
    make_run: MakeRun, tmp_path: Path, untraced: list[str]
) -> None:
    low, good = marks(40, 40, 40, 40), marks(85, 85, 85, 85)
    replies = {"viewer": [low, good], "render": [light("dark_stage"), light("overcast")]}
    studio = Studio(make_run, tmp_path, replies)
    assert "lighting: overcast" in studio.shoot()
    assert len(untraced) == 3


@pytest.mark.usefixtures("untraced")
def test_two_treatments_are_judged_at_the_same_time(
    make_run: MakeRun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    low, good = marks(40, 40, 40, 40), marks(90, 90, 90, 90)
    studio = Studio(make_run, tmp_path, {"viewer": [low, low, good], "render": [two_lights("golden_hour", "overcast")]})
    complete, together = studio.model.complete, Barrier(2, timeout=20)

    def beside_the_other(request: Any, stop: Any) -> Any:
        if request.role == "viewer" and request.number > 1:
            together.wait()
        return complete(request, stop)

    monkeypatch.setattr(studio.model, "complete", beside_the_other)
    studio.shoot()
    assert sorted(request.number for request in studio.model.asked if request.role == "viewer") == [1, 2, 3]


@pytest.mark.usefixtures("untraced")
def test_whoever_stops_it_is_heard(make_run: MakeRun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    studio = Studio(make_run, tmp_path, {"viewer": [marks(40, 40, 40, 40)]})
    complete = studio.model.complete

    def stopped(request: Any, stop: Any) -> Any:
        if request.role == "render":
            raise StoppedError("Ctrl-C")
        return complete(request, stop)

    monkeypatch.setattr(studio.model, "complete", stopped)
    with pytest.raises(StoppedError):
        studio.shoot()


@pytest.mark.usefixtures("untraced")
def test_who_films_it_knows_where_and_when_and_what_was_tried(make_run: MakeRun, tmp_path: Path) -> None:
    low, less = marks(40, 40, 40, 40, "A wider lens."), marks(30, 30, 30, 30, "Not so dark.")
    replies = {"viewer": [low, less, marks(90, 90, 90, 90)], "render": [light("overcast"), light("golden_hour")]}
    studio = Studio(make_run, tmp_path, replies)
    (studio.run / "events.jsonl").write_text('{"name": "slid", "time": 0.21}\n{"name": "slid", "time": 0.3}\n')
    studio.shoot()
    first, second = studio.model.questions("render")
    assert "- event `slid`: first at 0.21 s" in first
    assert "- `box`: [-0.3, -0.3, 0] to [0.3, 0.3, 0.6]; at the end [0.5, -0.3, 0] to [1.1, 0.3, 0.6]" in first
    assert re.search(r"- light `\w+`: softbox, strength 3.8, direction \[.*\]: it stands \d\d deg high", first)
    assert "6 spread over the film" in first
    assert "A wider lens." in second
    assert "Not so dark." in second, "what did not raise the marks is not tried again"
    asked = [request for request in studio.model.asked if request.role == "render"]
    assert [len(request.messages[-1].images) for request in asked] == [1, 1]
    told = asked[0].messages[0].text
    assert "brushed_metal" in told and "gingham" in told, "what finishes and patterns there are"


def test_no_preview_is_filmed_of_what_is_traced_next(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    given: dict[str, Any] = {}

    def run_case(loaded: LoadedCase, **more: Any) -> Any:
        given.update(more)
        return SimpleNamespace(stopped=False)

    loaded = load_text(CASE, tmp_path / "case.yaml")
    run = tmp_path / "runs" / f"slides-{plan_case(loaded).sim_digest[:10]}"
    (run / "states").mkdir(parents=True)
    monkeypatch.setattr(harness_run, "run_case", run_case)
    Attempts(tmp_path).refilm(loaded)
    assert given["film"] is False


def test_the_weights_of_the_marks() -> None:
    assert Marks(seen="", content=100, clarity=0, polish=0, appeal=0).total == 30
    assert Marks(seen="", content=0, clarity=100, polish=0, appeal=0).total == 30
    assert Marks(seen="", content=0, clarity=0, polish=100, appeal=0).total == 25
    assert Marks(seen="", content=0, clarity=0, polish=0, appeal=100).total == 15


@pytest.mark.usefixtures("untraced")
def test_a_handsome_film_that_breaks_what_was_asked_for_does_not_win(make_run: MakeRun, tmp_path: Path) -> None:
    plain, handsome = (
        marks(70, 70, 70, 70),
        marks(74, 74, 74, 74).replace("better:", "broken: [4: cuts it off]\nbetter:"),
    )
    others = [light("golden_hour"), light("overcast"), light("studio")]
    replies = {"viewer": [plain, *[handsome] * 3], "render": others}
    studio = Studio(make_run, tmp_path, replies)
    assert studio.shoot() == CASE
    assert [what["total"] for event, what in studio.events if event == "viewed"] == [70, 66, 66, 66]
    assert "cuts it off" in studio.model.questions("render")[1]


@pytest.mark.usefixtures("untraced")
def test_who_films_it_hears_what_was_not_filmed(make_run: MakeRun, tmp_path: Path) -> None:
    low, less = marks(40, 40, 40, 40), marks(30, 30, 30, 30)
    both = fenced(
        "treatments:\n"
        "  - {name: warm, operations: [{op: add, path: /render/lighting, value: overcast}]}\n"
        "  - {name: heavy, operations: [{op: add, path: /bodies/box/material, value: {density: 1}}]}\n"
    )
    replies = {"viewer": [low, less, marks(90, 90, 90, 90)], "render": [both, light("golden_hour")]}
    studio = Studio(make_run, tmp_path, replies)
    studio.shoot()
    first, second = studio.model.questions("render")
    assert "not filmed" not in first
    assert "- /treatments/1: operation 1: `/bodies/box/material` is neither below /render nor a look" in second


@pytest.mark.usefixtures("untraced")
def test_who_films_it_hears_what_the_program_corrected(make_run: MakeRun, tmp_path: Path) -> None:
    """A camera that points 14 deg up cuts off the lower edge of the box, and is turned down."""
    side = "{kind: still, from: [0, -4, 0.5], look_at: [0, 0, 1.5], fov_deg: 40}"
    cut = treatment(f"{{op: add, path: /render/cameras, value: {{side: {side}}}}}", name="near")
    replies = {"viewer": [marks(40, 40, 40, 40)] * 3, "render": [cut, light("overcast"), light("studio")]}
    studio = Studio(make_run, tmp_path, replies)
    studio.shoot()
    first, second = studio.model.questions("render")[:2]
    assert "program corrected" not in first
    assert re.search(r"less at rest:\n\n- near: /render/cameras/side/look_at is \[", second), second
