"""Cinematography of a final case: several treatments are judged by stills, without a new simulation.

A treatment is a patch on `render` and on looks (`restyling.py`). A judge sees the request and path-traced stills of the
start, the events and the end, and nothing else. The best treatment is refined with the judge's remarks on all of them
until it is good enough or the rounds are used up.
"""

from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from math import asin, degrees, hypot, sqrt
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from text2sim.agents import language
from text2sim.agents.assembly import format_problem
from text2sim.agents.conversation import Conversation, RoleFailed, Wrong, typed_parser
from text2sim.agents.frame_choice import EVEN_STILLS, MAX_EVENT_STILLS, choose_stills
from text2sim.agents.journal import Emit
from text2sim.agents.models.exchange import Image, StoppedError
from text2sim.agents.pictures import moments_of, sheet_png
from text2sim.agents.replies import Answer, Line, Name
from text2sim.agents.restyling import TouchesPhysics, restyle
from text2sim.agents.revising import data_of
from text2sim.agents.roles import ROLES, render, system_prompt
from text2sim.agents.yaml_text import yaml_text
from text2sim.recording.run_files import read_events
from text2sim.runtime.internal_errors import internal_error_message
from text2sim.spec_schema.changes.patch import PatchError
from text2sim.spec_schema.errors import SpecError, Text2SimError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.loaded import LoadedCase

GOOD_ENOUGH_MARK, EXCELLENT_MARK = 85.0, 90.0
"""Total marks (0 to 100): from the first, only one more treatment is tried; from the second, none."""
MAX_ROUNDS = 3
"""Largest number of rounds of proposals and judgements."""
FIRST_PROPOSALS = 2
"""Treatments that the Render Writer proposes in the first round; later rounds have one."""
ROUND_OVERTIME = 5.0
"""Minutes beyond the limit of time in which treatments that were written within it are judged."""
STILL_WIDTH = 480
"""Width of a still [pixels]."""
MAX_LISTED = 30
"""Largest number of events, and of bodies, in the Render Writer's prompt."""
MARK_WEIGHTS = {"content": 0.30, "clarity": 0.30, "polish": 0.25, "appeal": 0.15}
"""Weights of the marks."""
BROKEN_COST, MAX_BROKEN = 8.0, 4
"""What each broken demand on the view costs in total marks, and the largest number of them in an answer."""
Score = Annotated[float, Field(ge=0, le=100)]


class Treatment(Answer):
    """One way to film a simulated case."""

    name: Name
    why: Line = ""
    operations: Annotated[list[dict[str, Any]], Field(min_length=1, max_length=100)]
    """RFC 6902, on `render` and looks."""


class Treatments(Answer):
    """Proposals of the Render Writer."""

    treatments: Annotated[list[Treatment], Field(min_length=1, max_length=3)]


class Marks(Answer):
    """Marks of a visual judge for a film."""

    seen: Line
    content: Score
    clarity: Score
    polish: Score
    appeal: Score
    broken: Annotated[list[Line], Field(max_length=MAX_BROKEN)] = []
    """What the request demands of the view and the pictures break, so that handsome pictures do not win by it."""
    better: Line = ""
    """Suggested improvements."""

    @property
    def total(self) -> float:
        """Total mark, at most 100: the weighted marks less the cost of broken demands."""
        weighted = sum(weight * getattr(self, name) for name, weight in MARK_WEIGHTS.items())
        return round(weighted - BROKEN_COST * len(self.broken), 1)


@dataclass(frozen=True)
class FilmedTreatment:
    """A treatment that was filmed and judged."""

    name: str
    text: str
    """Text of the case."""
    marks: Marks
    sheet: Image
    """The stills that were judged."""


class Cinematography:
    """The search for the best film of one final case: an accepted one, or the best that was made.

    Args:
        chat: The conversation with the models.
        request: Text of the request.
        path: Path of the case file.
        run: The run folder.
        emit: Callback for journal events.
    """

    def __init__(self, chat: Conversation, request: str, path: Path, run: Path, emit: Emit) -> None:
        self._chat, self._request, self._path, self._run, self._emit = chat, request, path, run, emit
        self._tried: list[FilmedTreatment] = []
        self._refused: list[str] = []
        """What was wrong with treatments of the last answer that were not filmed."""
        self._corrected: list[str] = []
        """What the program changed in the film as it was, and then in the treatments of the last answer."""

    def best(self, text: str) -> FilmedTreatment | None:
        """Return the best treatment of a case; None if the judge's model does not accept images.

        Args:
            text: The final case. If its film is already good enough, no treatments are requested.

        Raises:
            RoleFailed, BudgetSpent, ModelError: As `Conversation.ask`, before the first judgement.
            RunError, MachineError: If the stills of the unchanged case cannot be traced.
            StoppedError: If the user stopped it.
        """
        if not self._chat.vision("viewer"):
            return None
        text = self.composed(text)
        self._tried = [self._judge_still("as_it_is", text, self._sheet(text))]
        try:
            for round_ in range(MAX_ROUNDS):
                best = self._best_so_far()
                good_enough = best.marks.total >= GOOD_ENOUGH_MARK
                if best.marks.total >= EXCELLENT_MARK or (good_enough and round_ > 0):
                    break
                first = round_ == 0 and not good_enough
                try:
                    written = self._written(best, FIRST_PROPOSALS if first else 1)
                except RoleFailed as failed:  # the next round asks again
                    self._emit("treatments_failed", why=str(failed))
                    continue
                with self._chat.overtime(ROUND_OVERTIME):
                    self._judge_all(written)
        except StoppedError:
            raise
        except Text2SimError as error:  # earlier judgements count
            self._emit("treatments_failed", why=str(error))
        return self._best_so_far()

    def _best_so_far(self) -> FilmedTreatment:
        return max(self._tried, key=lambda one: one.marks.total)

    # --- proposals ------------------------------------------------------------------------------------------------

    def composed(self, text: str, name: str = "as_it_is") -> str:
        """Return the case with cameras that cut off less, and less rest at both ends; unchanged if nothing improves.

        Args:
            text: The case.
            name: Name of the treatment, by which the Render Writer is told of changes.
        """
        from text2sim.rendering.composition import composed

        loaded = load_text(text, self._path)
        try:
            said = f"{loaded.case.prompt or ''} {self._request}"
            patch = composed(_recording(self._run, loaded), data_of(text).get("render") or {}, said)
            corrected = restyle(text, patch, self._path) if patch else text
        except Text2SimError as error:
            self._emit("treatments_failed", why=f"composition: {error}")
            return text
        self._corrected += [f"{name}: {row['path']} is {row['value']}" for row in patch if "value" in row]
        return corrected

    def _written(self, best: FilmedTreatment, count: int) -> dict[str, str]:
        texts: dict[str, str] = {}

        def check(answer: Treatments) -> None:
            texts.clear()
            self._corrected.clear()
            wrong: list[str] = []
            for number, treatment in enumerate(answer.treatments[:count]):
                try:
                    styled = restyle(best.text, treatment.operations, self._path)  # type: ignore[arg-type]
                    texts[treatment.name] = self.composed(styled, treatment.name)
                except SpecError as error:
                    wrong += [f"/treatments/{number}: {format_problem(problem)}" for problem in error.problems[:4]]
                except (PatchError, TouchesPhysics) as error:
                    wrong.append(f"/treatments/{number}: {error}")
            if wrong and not texts:
                raise Wrong(wrong)  # one usable treatment is enough: asking again costs more
            self._refused = wrong

        many = f"{count} treatments" if count > 1 else "one treatment"
        system = system_prompt(
            ROLES["render"],
            "treat",
            count=many,
            rules=language.rules(brief=True, reader="render"),
            pages=f"{language.reference_pages('render')}\n\n{language.explanations(['Look', 'Pattern'])[0]}",
        )
        question = render(
            "treat_ask",
            request=self._request,
            case=yaml_text(appearance_of(best.text)),
            recorded=recorded_text(_recording(self._run, load_text(best.text, self._path))),
            best=best.name,
            marks=yaml_text(
                {take.name: {"total": take.marks.total, **take.marks.model_dump()} for take in self._tried}
            ),
            refused=self._refused,
            corrected=self._corrected,
            sheet=self._chat.vision("render"),
            evenly=EVEN_STILLS,
            events=MAX_EVENT_STILLS,
            instruction=f"Propose {many} that would be marked higher.",
        )
        images = (best.sheet,) if self._chat.vision("render") else ()
        self._chat.ask("render", system, question, typed_parser(Treatments, check), images)
        return dict(texts)

    # --- judgement ------------------------------------------------------------------------------------------------

    def _sheet(self, text: str) -> tuple[bytes, int]:
        return stills(self._run, load_text(text, self._path))

    def _sheet_or_none(self, name: str, text: str) -> tuple[bytes, int] | None:
        """Stills of a treatment and their number; None if they cannot be traced."""
        try:
            return self._sheet(text)
        except Text2SimError as error:
            self._emit("treatments_failed", why=f"{name}: {error}")
            return None

    def _judge_all(self, written: Mapping[str, str]) -> None:
        """Have each treatment judged by itself, while the stills of the next are traced."""
        with ThreadPoolExecutor() as pool:
            asked = [
                pool.submit(self._judge_still, name, text, sheet, self._chat.reserve("viewer"))
                for name, text in written.items()
                if (sheet := self._sheet_or_none(name, text)) is not None
            ]
        self._tried += [one.result() for one in asked if one.exception() is None]
        for one in asked:
            one.result()  # raises the error of the first that failed

    def _judge_still(
        self, name: str, text: str, sheet: tuple[bytes, int], number: int | None = None
    ) -> FilmedTreatment:
        picture, count = Image("film.png", "image/png", sheet[0]), sheet[1]
        question = render("view", request=self._request, count=count)
        marks: Marks = self._chat.ask(
            "viewer", system_prompt(ROLES["viewer"]), question, typed_parser(Marks), (picture,), number=number
        )
        parts = {part: getattr(marks, part) for part in MARK_WEIGHTS}
        if any(take.name == name for take in self._tried):
            name = f"{name}_{len(self._tried)}"
        self._emit("viewed", treatment=name, total=marks.total, marks=parts, broken=marks.broken, better=marks.better)
        return FilmedTreatment(name, text, marks, picture)


def best_treatment(
    cinematography: Cinematography, text: str, refilm: Callable[[LoadedCase], None], path: Path, emit: Emit
) -> str:
    """Return the case with its best treatment; if no judge accepts pictures, with what the program corrects by itself.

    Args:
        cinematography: The search.
        text: The final case.
        refilm: Updates the run for a case with another film.
        path: Path of the case file.
        emit: Callback for journal events.

    Raises:
        StoppedError: If the user stopped it.
    """
    try:
        best = cinematography.best(text)
        chosen = cinematography.composed(text) if best is None else best.text
        if chosen != text:
            refilm(load_text(chosen, path))
    except StoppedError:
        raise
    except Text2SimError as error:
        emit("not_styled", why=str(error))  # a failure of the film must not lose the case
        return text
    except Exception as error:  # noqa: BLE001 - nor may an internal error
        emit("not_styled", why=internal_error_message(error))
        return text
    if best is None:
        emit("not_styled", why="the judge's model does not accept pictures")
    else:
        emit("styled", treatment=best.name, total=best.marks.total)
    return chosen


def stills(run: Path, loaded: LoadedCase) -> tuple[bytes, int]:
    """Return path-traced stills of a run's main film on one PNG sheet, and their number."""
    from PIL import Image as Pictures

    from text2sim.evidence.contact_sheet import contact_sheet
    from text2sim.legibility.visible_motion import visible_motion
    from text2sim.rendering.film import Filming

    recording = _recording(run, loaded)
    wide, tall = recording.film["resolution"]
    filming = Filming(recording, "draft", size=(STILL_WIDTH, max(2, round(STILL_WIDTH * tall / wide / 2) * 2)))
    reel = filming.reels()[0]
    motion = visible_motion(recording, reel.frames).tolist()
    few = filming.excerpt(reel, choose_stills(moments_of(run), reel.frames, motion))
    paths = filming.render(few, lambda progress: None)
    thumbnails = [
        ("film", f"{number}: {frame.k / filming.fps:.2f} s", Pictures.fromarray(picture))
        for number, (frame, picture) in enumerate(zip(few.frames, filming.pictures(few, paths), strict=True), 1)
    ]
    columns = max(2, round(sqrt(len(thumbnails) * tall / wide)))  # a sheet that is nearly square is shrunk least
    return sheet_png(contact_sheet(thumbnails, width=STILL_WIDTH, columns=columns)), len(thumbnails)


def recorded_text(recording: Any) -> str:
    """Describe a recording: times of events, lights, and bounding boxes of bodies at the start and at the end."""
    first: dict[str, float] = {}
    for row in read_events(recording.folder):
        if row["name"]:
            first.setdefault(row["name"], float(row["time"]))
    rows = [f"0 to {recording.last:.3g} s."]
    rows += [f"- event `{name}`: first at {t:.3g} s" for name, t in list(first.items())[:MAX_LISTED]]
    rows += [_light_row(name, light) for name, light in recording.film["lights"].items()]
    for name in list(dict.fromkeys(body.split("[")[0] for body in recording.bodies))[:MAX_LISTED]:
        start, end = (_box(recording.states.bounds([name], t)) for t in (0.0, recording.last))
        rows.append(f"- `{name}`: {start}" + ("" if start == end else f"; at the end {end}"))
    return "\n".join(rows)


def _light_row(name: str, light: Mapping[str, Any]) -> str:
    """Describe a light's position and brightness."""
    row = f"- light `{name}`: {light['kind']}, strength {light['strength']:.3g}"
    if (direction := light.get("direction")) is None:
        return row
    x, y, z = (part / hypot(*direction) for part in direction)
    return f"{row}, direction [{x:.2f}, {y:.2f}, {z:.2f}]: it stands {degrees(asin(-z)):.0f} deg high"


def _box(points: Any) -> str:
    """Describe the bounding box of points by its lowest and highest corner [m]."""
    import numpy as np

    known = points[np.isfinite(points).all(axis=1)]
    if not len(known):
        return "nowhere"
    corners = (known.min(axis=0), known.max(axis=0))
    return " to ".join("[" + ", ".join(f"{round(float(x), 2) + 0.0:g}" for x in corner) + "]" for corner in corners)


def _recording(run: Path, loaded: LoadedCase) -> Any:
    from text2sim.compiler.build import plan_case
    from text2sim.recording.film_record import read_recording

    return read_recording(run, plan_case(loaded))


def appearance_of(text: str) -> dict[str, Any]:
    """The parts of a case that define its appearance: `render` and looks."""
    data = data_of(text)
    scene = data.get("scene") or {}
    looks = {name: _looks(body) for name, body in (data.get("bodies") or {}).items()}
    statics = {name: _looks(static) for name, static in (scene.get("statics") or {}).items()}
    return {"render": data.get("render") or {}, "scene": {"statics": statics}, "bodies": looks}


def _looks(value: Any, within: str = "") -> Any:
    """The looks within a body, in their nesting; parts and links without one are named, as they can get one."""
    if not isinstance(value, Mapping):
        return {}
    inner = {key: _looks(row, key) for key, row in value.items() if isinstance(row, Mapping) and key != "look"}
    kept = {key: row for key, row in inner.items() if row or within in ("parts", "links")}
    return kept | ({"look": value["look"]} if "look" in value else {})
