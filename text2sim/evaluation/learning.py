"""Learning of cards from a suite: failures are reviewed, and a card is kept only if it improves the score.

WORK/rounds/<round>/<prompt>/    answers to the prompts: round `before`, then one round for each card that is tried
WORK/judged/<round>/             judgements of these answers
WORK/lessons/<prompt>/           calls about the lesson from a prompt, and the lesson in lesson.json
WORK/cards/<round>/              the card library of a round: the cards kept so far, and the one that is tried
"""

import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from itertools import combinations
from math import sqrt
from pathlib import Path
from typing import Any

import numpy as np

from text2sim.agents.conversation import Conversation, RoleFailed, Wrong, typed_parser
from text2sim.agents.distilling import CardDraft, CardProposal, attempts_of, attempts_text, draft_card
from text2sim.agents.journal import Journal
from text2sim.agents.models.calls import Account as Spent
from text2sim.agents.models.calls import Budget, CallLog
from text2sim.agents.models.endpoint import never_stop
from text2sim.agents.replies import Answer
from text2sim.agents.yaml_text import yaml_text
from text2sim.card_library.library import BUILT_IN, CardEntry, CardLibrary, check_card, load_library
from text2sim.card_library.model import Card, card_schema
from text2sim.card_library.retrieval import DUPLICATE_LIKENESS, likeness
from text2sim.card_library.verify import TIMEOUT, verify_card
from text2sim.evaluation.exhibit import exhibit_of
from text2sim.evaluation.judging import KINDS, Judgement, Judging, judge_endpoint
from text2sim.evaluation.ledger import (
    CardDebt,
    CardRecord,
    CardTrial,
    count_offered_cards,
    digest_of,
    read_ledger,
    record_card,
)
from text2sim.evaluation.method_folder import MethodFolder, read_method
from text2sim.evaluation.methods import Allowance, Method, run_method
from text2sim.evaluation.prompt_templates import render_prompt
from text2sim.evaluation.statistics import case_scores, spread_within
from text2sim.evaluation.suite import Prompt, Suite
from text2sim.recording.run_files import read_json
from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.whole_files import write_json


class Lesson(CardProposal):
    """Answer of the evaluator: a failure, and a card about it."""

    failure: str
    evidence: str
    edits: str = ""
    """Id of the card that it edits; empty for a new card."""


class Lessons(Answer):
    """The lesson from a prompt, if there is one."""

    lesson: Lesson | None


class MergedCard(Answer):
    """One card that replaces two."""

    keep: str
    card: dict[str, Any]


@dataclass(frozen=True)
class LearningRound:
    """One round in which prompts were answered and judged."""

    made: MethodFolder
    rows: Sequence[Judgement]

    def scores(self) -> dict[str, float]:
        """Return the mean of the physical and visual score of each prompt that could be judged."""
        parts = [case_scores(self.rows, kind) for kind in KINDS]
        return {key[1]: float(np.mean([part[key] for part in parts])) for key in parts[0] if key in parts[1]}

    def noise(self, repeats: int) -> float:
        """Return the standard error of a score, from the scatter of repeated judgements."""
        return max((spread_within(self.rows, kind, self.made.name) or 0.0) for kind in KINDS) / sqrt(repeats)


@dataclass
class Learning:
    """Learning of cards from one suite."""

    suite: Suite
    prompts: Mapping[str, Prompt]
    """The prompts of the suite to learn from."""
    cards: Path
    """The folder of learned cards, with its ledger."""
    work: Path
    """The folder of answers, judgements and lessons."""
    models: Sequence[str]
    """Models that answer the prompts, `[ROLE=]MODEL`."""
    judge: str
    """Model of the judge."""
    allowance: Allowance
    tell: Callable[[str], None]
    repeats: int = 3
    """Number of judgements of each kind."""
    reviewer: str = ""
    """Model of the evaluator, who reviews failures and writes cards; the judge's if empty."""
    answer: Callable[..., Path] = run_method
    """Answers prompts; has the signature of `run_method`."""
    budget: Budget = field(default_factory=Budget)
    stop: Callable[[], bool] = never_stop

    def run(self) -> None:
        """Answer all prompts and try a lesson from each; finished steps are not repeated."""
        self.cards.mkdir(parents=True, exist_ok=True)
        before = self._run_round("before", self.prompts, self.cards)
        for name in self.prompts:
            file = self.work / "lessons" / name / "lesson.json"
            stored: Any = read_json(file)
            if stored is None:
                found = self._ask_for_lesson(name, before)
                stored = (
                    {"lesson": None} if found is None else {"lesson": found[0].model_dump(), "draft": asdict(found[1])}
                )
                write_json(file, stored)
            if stored["lesson"] is not None and not stored.get("tried"):
                self._try_card(name, Lesson(**stored["lesson"]), CardDraft(**stored["draft"]), before)
                write_json(file, stored | {"tried": True})
        self.consolidate()

    def _run_round(self, label: str, prompts: Mapping[str, Prompt], library: Path) -> LearningRound:
        method = Method(label, "text2sim", library=str(library.resolve()))
        folder = self.answer(self.suite, prompts, method, self.models, self.allowance, self.work / "rounds", self.tell)
        made = read_method(folder)
        out = self.work / "judged" / label
        judging = Judging(self.suite, [made], [self.judge], out, self.repeats, self.budget, self.stop)
        return LearningRound(made, judging.run(prompts, self.tell))

    def _conversation(self, name: str) -> Conversation:
        folder = self.work / "lessons" / name
        endpoint = judge_endpoint(self.reviewer or self.judge, f"lesson-{name}")
        log, journal = CallLog(folder / "calls"), Journal(folder / "journal.jsonl")
        return Conversation({"": endpoint}, log, Spent(), self.budget, journal, self.stop)

    def _library(self) -> CardLibrary:
        return load_library([self.cards])

    def _ask_for_lesson(self, name: str, before: LearningRound) -> tuple[Lesson, CardDraft] | None:
        """Have a model review the answer to a prompt, until its card is valid."""
        score, made = before.scores().get(name), before.made.made.get(name)
        attempts = attempts_of(made.folder / "case") if made is not None else {}
        if made is None or score is None or not attempts:
            self.tell(f"{name}: nothing to learn from: {'not judged' if attempts else 'no attempt was made'}")
            return None
        library, built_in = self._library(), load_library([BUILT_IN])
        everything = {**built_in.entries, **library.entries}
        shown = exhibit_of(made)
        question = render_prompt(
            "learn_ask", prompt=self.prompts[name], attempts=attempts_text(attempts), frames=shown.frames,
            findings=_findings(before.rows, name), learned=", ".join(library.entries) or "none",
            built_in=", ".join(built_in.entries),
            **{kind: f"{case_scores(before.rows, kind)[before.made.name, name]:.0f}" for kind in KINDS},
        )  # fmt: skip
        drafts: list[CardDraft] = []

        def check(answer: Lessons) -> None:
            drafts.clear()
            if answer.lesson is None:
                return
            draft = draft_card(answer.lesson, attempts)
            self._check_duplicates(answer.lesson.edits, draft, library, everything)
            self._check_by_running(draft, self.work / "cards" / f"asked-{name}")
            drafts.append(draft)

        def pages(names: list[str]) -> str:
            return (
                "\n\n".join(everything[card].card.brief() for card in names if card in everything) or "There is none."
            )

        images = shown.frames.images if shown.frames is not None else ()
        system = render_prompt("learn", schema=yaml_text(card_schema()))
        try:
            answer: Lessons = self._conversation(name).ask(
                "evaluator", system, question, typed_parser(Lessons, check), images, read_pages=pages
            )
        except RoleFailed as failed:
            self.tell(f"{name}: {failed}")
            return None
        if answer.lesson is None:
            self.tell(f"{name}: nothing to learn here")
            return None
        return answer.lesson, drafts[0]

    def _check_duplicates(
        self, edits: str, draft: CardDraft, library: CardLibrary, everything: Mapping[str, CardEntry]
    ) -> None:
        """Reject a card that duplicates another one or makes a forbidden edit."""
        card = Card.model_validate(draft.data)
        if edits and edits not in library.entries:
            raise Wrong(
                [f"/edits: no card `{edits[:60]}` was learned; there are: {', '.join(library.entries) or 'none'}"]
            )
        if edits and card.id != edits:
            raise Wrong([f"/card/id: it edits `{edits}`, and has to have its id"])
        if not edits and card.id in everything:
            raise Wrong([f"/card/id: there is a card `{card.id}` already"])
        for entry in everything.values():
            if entry.id != edits and likeness(card, entry.card) >= DUPLICATE_LIKENESS:
                remedy = f"edit it (`edits: {entry.id}`)" if entry.id in library.entries else "it comes with text2sim"
                raise Wrong([f"/card: it says the same as `{entry.id}`: {remedy}"])

    def _check_by_running(self, draft: CardDraft, folder: Path) -> None:
        """Run both cases of a card, and reject it if they do not show what it says."""
        place = folder / str(draft.data["id"])
        shutil.rmtree(folder, ignore_errors=True)
        draft.write(place)
        entry = CardEntry(Card.model_validate(draft.data), place)
        verdict = verify_card(entry, runs=self.work / "runs", timeout=min(TIMEOUT, self.allowance.sim_timeout))
        if not verdict.ok:
            raise Wrong([f"the card does not hold: {verdict.message}"])

    def _try_card(self, name: str, lesson: Lesson, draft: CardDraft, before: LearningRound) -> None:
        """Answer the prompts of a card again with it, and keep it if their scores improve."""
        id = str(draft.data["id"])
        previous = read_ledger(self.cards).cards.get(id) if lesson.edits else None
        affected = {name, *(debt.prompt for debt in previous.owes)} if previous else {name}
        prompts = {prompt_id: prompt for prompt_id, prompt in self.prompts.items() if prompt_id in affected}
        entry = CardEntry(Card.model_validate(draft.data), self.work / "cards" / f"asked-{name}" / id)
        label = f"with-{id}-{digest_of(entry)[:8]}"
        library = self.work / "cards" / label
        if not library.exists():
            shutil.copytree(self.cards, library)
            draft.write(library / id)
        after = self._run_round(label, prompts, library)
        scores_before = before.scores() | {trial.prompt: trial.after for trial in (previous.tried if previous else ())}
        scores_after = after.scores()
        tried = [
            CardTrial(
                prompt=prompt_id,
                before=scores_before[prompt_id],
                after=scores_after[prompt_id],
                dealt=count_offered_cards([after.made.made[prompt_id].folder])[1][id] > 0,
            )
            for prompt_id in prompts
            if prompt_id in scores_before and prompt_id in scores_after
        ]
        record = CardRecord(
            state="rejected", digest=digest_of(entry), tried=tried,
            owes=[CardDebt(prompt=name, failure=lesson.failure, evidence=lesson.evidence)],
        )  # fmt: skip
        noise = sqrt(before.noise(self.repeats) ** 2 + after.noise(self.repeats) ** 2) / sqrt(max(1, len(tried)))
        kept = any(trial.dealt for trial in tried) and record.gain > noise
        if kept:
            record = record.model_copy(update={"state": "kept"})
            draft.write(self.cards / id)
        if kept or previous is None:  # an edit without improvement is discarded
            record_card(self.cards, id, record, {name: self.prompts[name]})
        why = f"{record.gain:+.1f} points (noise {noise:.1f})" if any(trial.dealt for trial in tried) else "never dealt"
        self.tell(f"{name}: {id}: {record.state}: {why}")

    def consolidate(self) -> None:
        """Have cards with the same content merged."""
        for first, second in combinations(self._library().entries, 2):
            entries, known = self._library().entries, read_ledger(self.cards).cards
            if (
                not {first, second} <= entries.keys() & known.keys()
                or likeness(entries[first].card, entries[second].card) < DUPLICATE_LIKENESS
            ):
                continue
            pair = {name: entries[name] for name in (first, second)}
            question = render_prompt("merge_ask", cards=[entry.card.brief() for entry in pair.values()])
            system = render_prompt("merge", ids=list(pair), schema=yaml_text(card_schema()))
            drafts: list[CardDraft] = []

            def check(
                answer: MergedCard, pair: Mapping[str, CardEntry] = pair, drafts: list[CardDraft] = drafts
            ) -> None:
                if answer.keep not in pair:
                    raise Wrong([f"/keep: is {' or '.join(pair)}"])
                kept = pair[answer.keep]
                evidence = kept.card.evidence.model_dump(mode="json")
                draft = CardDraft(
                    {**answer.card, "id": kept.id, "evidence": evidence},
                    kept.failing.read_text("utf-8"), kept.repaired.read_text("utf-8"),
                )  # fmt: skip
                try:
                    check_card(yaml_text(draft.data), failing=draft.failing, repaired=draft.repaired)
                except SpecError as error:
                    raise Wrong([f"{problem.path}: {problem.message}" for problem in error.problems[:8]]) from None
                drafts[:] = [draft]

            chat = self._conversation(f"{first}-{second}")
            try:
                answer: MergedCard = chat.ask("evaluator", system, question, typed_parser(MergedCard, check))
            except RoleFailed as failed:
                self.tell(f"{first} and {second} stay two: {failed}")
                continue
            self._merge(pair, answer.keep, drafts[0])

    def _merge(self, pair: Mapping[str, CardEntry], keep: str, draft: CardDraft) -> None:
        (dropped,) = set(pair) - {keep}
        ledger = read_ledger(self.cards)
        draft.write(self.cards / keep)
        shutil.rmtree(self.cards / dropped)
        kept_record, dropped_record = ledger.cards[keep], ledger.cards[dropped]
        digest = digest_of(pair[keep])
        record_card(
            self.cards,
            keep,
            kept_record.model_copy(update={"digest": digest, "owes": [*kept_record.owes, *dropped_record.owes]}),
            {},
        )
        record_card(self.cards, dropped, dropped_record.model_copy(update={"state": "merged"}), {})
        self.tell(f"{dropped}: merged into {keep}")


def _findings(rows: Sequence[Judgement], name: str) -> list[str]:
    """Faults that judges found in an answer."""
    found = []
    for row in rows:
        reply = row.reply or {}
        if row.turn.prompt != name or row.turn.kind != "physical":
            continue
        marks = reply.get("requirements", {}).items()
        found += [f"{what}: {mark['mark']:g}: {mark['evidence']}" for what, mark in marks if mark["mark"] < 1]
        bans = reply.get("prohibitions", {}).items()
        found += [
            f"{what}: violated ({ban['violated']}): {ban['evidence']}" for what, ban in bans if ban["violated"] != "no"
        ]
        found += [why] if (why := row.why or reply.get("why", "")) else []
    return list(dict.fromkeys(found))
