"""Judging of method folders: independent repeats by judges who see neither names nor each other's scores.

JUDGED/judging.json                                     suite, prompts, methods and judges
JUDGED/<prompt>/<method>/frames/                        the frames that judges saw
JUDGED/<prompt>/<method>/<kind>-<judge>-<repeat>/       judgement.json, and calls/ with every request and reply
"""

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field
from hashlib import sha256
from itertools import product
from pathlib import Path
from typing import Any, Literal

from pydantic import TypeAdapter

from text2sim.agents.conversation import BudgetSpent, Conversation, RoleFailed, Wrong, typed_parser
from text2sim.agents.journal import Journal
from text2sim.agents.models.calls import Account, Budget, CallLog
from text2sim.agents.models.endpoint import Endpoint, endpoint_of, in_subfolder, never_stop
from text2sim.agents.models.exchange import ModelError, StoppedError
from text2sim.agents.models.files import write_durably
from text2sim.evaluation.exhibit import ResultExhibit, bind_facts, exhibit_of
from text2sim.evaluation.method_folder import PROMPT_FILE, MethodFolder, PromptResult, read_method
from text2sim.evaluation.prompt_templates import render_prompt
from text2sim.evaluation.scores import PhysicalReply, VisualReply, physical_faults, physical_score, visual_score
from text2sim.evaluation.suite import Prompt, Suite
from text2sim.recording.record import RunRecord
from text2sim.recording.run_files import read_json, read_text
from text2sim.spec_schema.errors import RunError
from text2sim.spec_schema.whole_files import write_json

Kind = Literal["physical", "visual", "check"]
"""`check` binds requirements to facts; it is not a judgement."""
KINDS: tuple[Kind, ...] = ("physical", "visual")
State = Literal["judged", "nothing", "not_judged"]
"""`nothing`: there was nothing to judge, so the score is 0 and no judge was asked."""
JUDGING_FILE, JUDGEMENT_FILE = "judging.json", "judgement.json"
Tell = Callable[[str], None]


@dataclass(frozen=True)
class Turn:
    """A judgement that is due."""

    prompt: str
    method: str
    kind: Kind
    judge: int
    """Number of the judge's model, from 1."""
    repeat: int
    """From 1."""

    @property
    def code(self) -> str:
        """Its anonymous name, which reveals neither the method nor other judgements of the same film."""
        seed_text = f"{self.prompt}/{self.method}/{self.kind}/{self.judge}/{self.repeat}"
        return f"{self.prompt}-{self.kind}-{sha256(seed_text.encode()).hexdigest()[:8]}"

    @property
    def place(self) -> Path:
        """Its folder."""
        return Path(self.prompt) / self.method / f"{self.kind}-{self.judge}-{self.repeat}"


@dataclass(frozen=True)
class Judgement:
    """One judge's opinion of one result."""

    turn: Turn
    digest: str
    """Digest of the prompt and its requirements (`Prompt.digest`)."""
    state: State
    total: float | None
    """0 to 100; None if it was not judged."""
    why: str = ""
    """Reason for a total without a judge, or for no total."""
    reply: Mapping[str, Any] | None = None
    """The judge's reply."""
    score: Mapping[str, Any] | None = None
    """The parts of a physical score."""
    shown: Mapping[str, Any] | None = None
    """Facts, missing files, and times of the frames [s]."""


_JUDGEMENT = TypeAdapter(Judgement)


@dataclass
class Judging:
    """Judging of method folders by several judges."""

    suite: Suite
    methods: Sequence[MethodFolder]
    models: Sequence[str]
    """The judges."""
    out: Path
    """Output folder."""
    repeats: int = 3
    """Number of judgements of each kind by each judge."""
    budget: Budget = field(default_factory=Budget)
    stop: Callable[[], bool] = never_stop

    def __post_init__(self) -> None:
        names = [method.name for method in self.methods]
        if len(set(names)) < len(names):
            raise RunError(f"two method folders have the same name: {', '.join(names)}")
        self.account = Account()

    def run(self, prompts: Mapping[str, Prompt], tell: Tell, jobs: int = 1) -> list[Judgement]:
        """Judge all results; finished judgements are not repeated.

        Args:
            prompts: The prompts, by id.
            tell: Called with one line for each judgement.
            jobs: Number of results judged concurrently.

        Raises:
            StoppedError: If the user stopped it.
            BudgetSpent: If the budget is used up.
            RunError: If a judge does not accept images.
        """
        for model in self.models:
            if not judge_endpoint(model, "").vision:
                raise RunError(
                    f"the judge {model} does not accept pictures; if it does, append `,vision=yes` to its name"
                )
        before = read_json(self.out / JUDGING_FILE)
        earlier = before["judged"] if _is_record(before) and before["digest"] == self.suite.digest() else []
        write_json(
            self.out / JUDGING_FILE,
            {
                "judged": list(dict.fromkeys([*earlier, *prompts])),
                "suite": self.suite.name,
                "digest": self.suite.digest(),
                "prompts": {name: prompt.digest() for name, prompt in self.suite.prompts.items()},
                "models": [judge_endpoint(model, "").name for model in self.models],
                "repeats": self.repeats,
                "methods": {method.name: str(method.folder.resolve()) for method in self.methods},
            },
        )
        pairs = [(name, method) for name in prompts for method in self.methods]
        with ThreadPoolExecutor(jobs) as pool:
            rows = pool.map(lambda pair: self._result(pair[0], prompts[pair[0]], pair[1], tell), pairs)
            return [row for result in rows for row in result]

    def _result(self, name: str, prompt: Prompt, method: MethodFolder, tell: Tell) -> list[Judgement]:
        made = method.made.get(name)
        shown = exhibit_of(made) if made is not None else ResultExhibit()
        for image in shown.frames.images if shown.frames is not None else ():
            write_durably(self.out / name / method.name / "frames" / image.name, image.data)
        if made is not None and not made.empty:
            turn = Turn(name, method.name, "check", 1, 1)
            bind_facts(lambda: self._chat(turn), prompt, shown, made)
        rows = []
        for turn in _turns(name, method.name, len(self.models), self.repeats):
            row = self._judge_turn(turn, prompt, made, shown)
            write_json(self.out / turn.place / JUDGEMENT_FILE, asdict(row))
            rows.append(row)
            result = f"{row.total:.1f}" if row.total is not None else f"not judged: {row.why}"
            who = f"{turn.kind} {turn.repeat} of {self.repeats} by judge {turn.judge}"
            tell(f"{name}, {method.name}: {who}: {result}")
        return rows

    def _judge_turn(self, turn: Turn, prompt: Prompt, made: PromptResult | None, shown: ResultExhibit) -> Judgement:
        def plain(state: State, why: str) -> Judgement:
            return Judgement(turn, prompt.digest(), state, 0.0 if state == "nothing" else None, why)

        if made is None:
            return plain("not_judged", "the method was not run on this prompt")
        asked = read_text(made.folder / PROMPT_FILE).strip()
        if asked and asked != prompt.prompt:
            return plain("not_judged", f"its folder answers another prompt: {asked[:200]}")
        if made.empty:
            return plain("nothing", made.result.why or "there is nothing to judge")
        if turn.kind == "visual" and shown.frames is None:
            return plain("nothing", "; ".join(shown.missing))
        try:
            return (_physical if turn.kind == "physical" else _visual)(self._chat(turn), turn, prompt, shown)
        except (StoppedError, BudgetSpent):
            raise
        except (RoleFailed, ModelError) as error:
            return plain("not_judged", str(error))

    def _chat(self, turn: Turn) -> Conversation:
        endpoint = judge_endpoint(self.models[turn.judge - 1], turn.code)
        place = self.out / turn.place
        log, journal = CallLog(place / "calls"), Journal(place / "journal.jsonl")
        return Conversation({"": endpoint}, log, self.account, self.budget, journal, self.stop)


def _physical(chat: Conversation, turn: Turn, prompt: Prompt, shown: ResultExhibit) -> Judgement:
    images = shown.frames.images if shown.frames else ()

    def check(reply: PhysicalReply) -> None:
        if wrong := physical_faults(prompt, reply, len(images)):
            raise Wrong(wrong)

    question = render_prompt("physical_ask", prompt=prompt, shown=shown)
    reply: PhysicalReply = chat.ask(
        "physical", render_prompt("physical"), question, typed_parser(PhysicalReply, check), images
    )
    keyframed = shown.motion is not None and shown.motion.mainly_keyframed
    score = physical_score(prompt, reply, usable=shown.frames is not None, keyframed=keyframed)
    times = list(shown.frames.times) if shown.frames else []
    seen = {"facts": shown.facts, "missing": shown.missing, "notes": shown.notes, "times": times}
    return Judgement(
        turn, prompt.digest(), "judged", score.total, reply=reply.model_dump(), score=asdict(score), shown=seen
    )


def _visual(chat: Conversation, turn: Turn, prompt: Prompt, shown: ResultExhibit) -> Judgement:
    assert shown.frames is not None
    question = render_prompt("visual_ask", prompt=prompt, frames=shown.frames)
    reply: VisualReply = chat.ask(
        "visual", render_prompt("visual"), question, typed_parser(VisualReply), shown.frames.images
    )
    seen = {"times": list(shown.frames.times)}
    return Judgement(turn, prompt.digest(), "judged", visual_score(reply), reply=reply.model_dump(), shown=seen)


def _turns(prompt: str, method: str, judges: int, repeats: int) -> list[Turn]:
    """The judgements that are due for a result."""
    return [
        Turn(prompt, method, kind, judge, repeat)
        for kind in KINDS
        for judge in range(1, judges + 1)
        for repeat in range(1, repeats + 1)
    ]


def judge_endpoint(model: str, code: str) -> Endpoint:
    """Return a judge's endpoint; each judgement by mailbox has a folder of its own, so that they are independent."""
    return endpoint_of(in_subfolder(model, code))


def read_judgements(out: Path) -> tuple[dict[str, Any], list[Judgement]]:
    """Return the record of what was judged, and its judgements; pending ones are marked as not judged.

    Raises:
        RunError: If the folder has no judgements.
    """
    record = read_json(out / JUDGING_FILE)
    if not _is_record(record):
        raise RunError(f"{out}: nothing was judged here (no {JUDGING_FILE})")
    rows = []
    for path in sorted(out.glob(f"*/*/*/{JUDGEMENT_FILE}")):
        try:
            row = _JUDGEMENT.validate_python(read_json(path))
        except ValueError:
            raise RunError(f"{path}: not a judgement; remove its folder, and judge again with --resume") from None
        turn = row.turn
        belongs = record["prompts"].get(turn.prompt) == row.digest and turn.method in record["methods"]
        if belongs and turn.repeat <= record["repeats"] and turn.judge <= len(record["models"]):
            rows.append(row)
    turns = {row.turn for row in rows}
    for name, method in product(record["judged"], record["methods"]):
        for turn in _turns(name, method, len(record["models"]), record["repeats"]):
            if turn not in turns:
                rows.append(Judgement(turn, record["prompts"][name], "not_judged", None, "nobody has judged it yet"))
    return record, rows


def _is_record(data: Any) -> bool:
    """Return whether the content of a `judging.json` is a record of what was judged."""
    kinds = {"judged": list, "digest": str, "prompts": dict, "models": list, "repeats": int, "methods": dict}
    return isinstance(data, dict) and all(isinstance(data.get(name), kind) for name, kind in kinds.items())


def scores_of_runs(out: Path) -> dict[str, list[dict[str, Any]]]:
    """Return the judgements of runs of text2sim by simulation digest, as `by`, `score` (0 to 100) and `verdict` (None).

    Raises:
        RunError: If the folder has no judgements, or a method folder is gone.
        SpecError: If a `method.json` is invalid.
    """
    record, rows = read_judgements(out)
    results = {name: read_method(Path(folder)).made for name, folder in record["methods"].items()}
    found = defaultdict[str, list[dict[str, Any]]](list)
    for row in rows:
        result = results[row.turn.method].get(row.turn.prompt)
        run = result.path("run") if result is not None else None
        ran = RunRecord.read(run) if run is not None else None
        if row.state == "judged" and ran is not None and ran.key.get("sim_digest"):
            by = f"{row.turn.kind} judge {row.turn.judge}, {row.turn.repeat}"
            found[ran.key["sim_digest"]].append({"by": by, "score": row.total, "verdict": None})
    return dict(found)
