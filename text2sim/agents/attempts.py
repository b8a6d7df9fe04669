"""Folder of the attempts of a loop, which runs, stores and recalls them."""

import json
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace
from math import inf
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

from text2sim.agents.assembly import Examination, examine
from text2sim.agents.attempt import Attempt
from text2sim.agents.contract import numbered_copies
from text2sim.agents.counterfactual import TITLE, Found, causes_text, compare_causes, untried_causes, were_tried
from text2sim.agents.facts import compute_facts, facts_as_data
from text2sim.agents.models.exchange import Image
from text2sim.agents.pictures import frame_sheet, sheet_png
from text2sim.agents.refinement import with_finer_steps
from text2sim.agents.replies import CasePlan
from text2sim.agents.run_summary import citable_items, evidence_text
from text2sim.agents.tracks import track_rows, tracks_text
from text2sim.agents.trials import MAX_TRACKS, Outcome, Settings, trials_text
from text2sim.recording.record import RunRecord
from text2sim.spec_schema.errors import Problem, RunError
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.whole_files import write_atomically, write_json

if TYPE_CHECKING:
    from text2sim.harness.result import RunResult
    from text2sim.runtime.warm_runner import WarmRunner

MAX_REPEAT_SHARE, MAX_FINER_SHARE = 0.25, 0.1
"""Largest parts of the time left that a second run may take: without a cause, once all expectations are true, and with
finer steps."""
DURATION_RULE = "slow-scene"
"""The rule that estimates the duration of a run; ignored once a run was timed."""
UNJUDGED_RULES = (DURATION_RULE, "unused-param")
"""Rules whose warnings say nothing about a run."""


class Attempts:
    """The folder of attempts of a case."""

    def __init__(self, case: Path) -> None:
        self.case, self.folder = case, case / "generation" / "attempts"
        self._minutes: dict[int, list[float | None]] = {}
        """Minutes left at each question to the Planner, by attempt; None without a limit."""
        self._asked: Counter[int] = Counter()
        self._warm: WarmRunner | None = None
        self._told: set[tuple[str, str]] = set()
        """Rule and path of the intended warnings that stood in the evidence of an earlier run."""

    @property
    def runner(self) -> "WarmRunner":
        """Runner whose engine process stays warm between attempts; created on first use."""
        if self._warm is None:
            from text2sim.runtime.warm_runner import WarmRunner

            self.folder.mkdir(parents=True, exist_ok=True)
            self._warm = WarmRunner(self.folder.parent)
        return self._warm

    def close(self) -> None:
        """End the engine process."""
        if self._warm is not None:
            self._warm.close()
            self._warm = None

    def folder_of(self, number: int) -> Path:
        """Return the folder of an attempt."""
        return self.folder / f"{number:02}"

    def keep(self, attempt: Attempt) -> None:
        """Write an attempt's files; not before it is run or refused, since a resumed loop may recall what is there."""
        if not (attempt.run or attempt.problems):
            return
        folder = self.folder_of(attempt.number)
        folder.mkdir(parents=True, exist_ok=True)
        write_atomically(folder / "case.yaml", attempt.text)
        data = {name: value for name, value in vars(attempt).items() if name != "text"}
        write_json(folder / "attempt.json", data)

    def minutes_left(self, attempt: Attempt, now: float | None) -> float | None:
        """Record the minutes left by the clock, None without a limit; return them as a resumed loop has told them."""
        estimates, asked = self._told_minutes(attempt.number), self._asked[attempt.number]
        if len(estimates) <= asked:
            estimates.append(now)
            # Not in attempt.json, which may hold results that a resumed loop is about to recall.
            write_json(self.folder_of(attempt.number) / "minutes.json", estimates)
        self._asked[attempt.number] += 1
        return estimates[asked]

    def crowding(self, attempt: Attempt) -> float:
        """Return how much longer a run takes on this machine than if it were idle; recorded like the minutes left."""
        from text2sim.runtime.machine import crowding

        file = self.folder_of(attempt.number) / "crowding.json"
        try:
            return float(json.loads(file.read_text("utf-8")))
        except (OSError, ValueError, TypeError):
            now = round(crowding(), 2)
            write_json(file, now)
            return now

    def too_late(self, attempt: Attempt, now: float | None, reserve: float = 0.0) -> bool:
        """Whether the time left is less than half of the wall time of an attempt's run, or than a reserve.

        False if a resumed loop repeats a question, since its answer is stored.

        Args:
            attempt: The attempt.
            now: Minutes left by the clock; None without a limit.
            reserve: Minutes that are kept for something else.
        """
        return now is not None and not self.repeats(attempt) and 60 * now < max(attempt.wall / 2, 60 * reserve)

    def repeats(self, attempt: Attempt) -> bool:
        """Whether a resumed loop is about to repeat a question about an attempt."""
        return len(self._told_minutes(attempt.number)) > self._asked[attempt.number]

    def _told_minutes(self, number: int) -> list[float | None]:
        if number not in self._minutes:
            try:
                minutes = json.loads((self.folder_of(number) / "minutes.json").read_text("utf-8"))
                self._minutes[number] = [one if one is None else float(one) for one in minutes]
            except (OSError, ValueError, TypeError):
                self._minutes[number] = []
        return self._minutes[number]

    def recall(self, attempt: Attempt) -> bool:
        """Restore the results of an earlier run of a text, and its finer steps; return whether there were any."""
        folder = self.folder_of(attempt.number)
        try:
            data = json.loads((folder / "attempt.json").read_text("utf-8"))
            text = (folder / "case.yaml").read_text("utf-8")
            coarse = data.get("coarse_text", "")
            if (coarse or text) != attempt.text or data["state"] in ("unsound", "interrupted", "running"):
                return False
            names = ("state", "run", "evidence", "expect", "cites", "pictures", "wall", "took", "pace", "facts")
            found = {name: data[name] for name in names} | {"coarse_text": coarse, "text": text}
            if not all((folder / name).is_file() for name in found["pictures"]):
                return False
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            return False
        vars(attempt).update(found)  # all or nothing: what is not recalled is run again from the text as it was
        return True

    def images(self, attempt: Attempt) -> tuple[Image, ...]:
        """Return the pictures of an attempt."""
        folder = self.folder_of(attempt.number)
        return tuple(Image(name, "image/png", (folder / name).read_bytes()) for name in attempt.pictures)

    def run(
        self,
        attempt: Attempt,
        examined: Examination,
        given: Sequence[str],
        timeout: float,
        on_progress: Callable[[Any], None],
        patience: float = inf,
        finer_within: float = 0.0,
    ) -> None:
        """Simulate an attempt, repeat it with finer steps if bodies sink into each other, and record its evidence.

        Args:
            attempt: The attempt; updated with the result, and with the finer steps.
            examined: Its checked case.
            given: Names of the expectations that come from the request.
            timeout: Longest wall time of the simulation [s].
            on_progress: Callback for the simulation's progress.
            patience: Expected wall time [s] from which it is stopped as soon as its speed is known.
            finer_within: Longest expected wall time [s] of a second run with finer steps; 0 for none.

        Raises:
            MachineError: If this machine cannot run the simulation.
            KeyboardInterrupt: If the user stopped it.
        """
        from text2sim.harness.run import run_case

        assert examined.loaded is not None
        begun = monotonic()
        rest: dict[str, Any] = {"timeout": timeout, "on_progress": on_progress}
        try:
            result = self._simulated(examined.loaded, patience=patience, lint=_lint_rows(examined), **rest)
            examined, result = self._refined(attempt, examined, result, finer_within, rest)
        except RunError as error:
            attempt.state, attempt.problems = "failed", [str(error)]
            return
        loaded = examined.loaded
        assert loaded is not None
        record = RunRecord.read(result.folder)
        attempt.wall = round(result.wall, 1)
        attempt.state, attempt.run = result.state, result.folder.relative_to(self.case).as_posix()
        attempt.expect = {
            name: {k: row[k] for k in ("ok", "wanted", "why")} for name, row in result.expectations.items()
        }
        attempt.pictures, frames, pictured = self._pictures(
            attempt, result.folder, lambda: run_case(loaded, runs=self.case / "runs", lint=_lint_rows(examined), **rest)
        )
        bodies = [*loaded.case.bodies, *loaded.case.scene.statics]
        asked = [one for name in given for one in numbered_copies(name, result.expectations)]
        recorded = vars(record) if record is not None else {}
        if record is not None and record.time > 0:
            attempt.pace = round(record.timings.get("simulate", 0.0) / record.time, 2)
        summary = evidence_text(result.folder, result.evidence, recorded, asked, pictured)
        attempt.evidence = "\n\n".join([summary, *_further_evidence(result, examined, loaded, self._told)])
        self._told |= examined.intended.keys()
        attempt.cites = sorted(citable_items(result.evidence, frames, bodies))
        attempt.took = round(monotonic() - begun, 1)
        self.keep(attempt)

    def _refined(
        self, attempt: Attempt, examined: Examination, result: "RunResult", within: float, options: dict[str, Any]
    ) -> tuple[Examination, "RunResult"]:
        """Repeat a run with finer steps if bodies sank into each other and that takes less than `within` [s].

        Returns:
            Check and result of the finer run if it finished, whose text the attempt gets; otherwise of the first run.
        """
        assert examined.loaded is not None
        text, factor = with_finer_steps(attempt.text, examined.loaded, result.evidence or {})
        record = RunRecord.read(result.folder)
        seconds = max(result.wall, record.wall if record is not None else 0.0)  # this call may only have judged the run
        if factor == 1 or factor * seconds >= within:
            return examined, result
        finer = examine(text, self.case / "case.yaml")
        assert finer.loaded is not None
        try:
            again = self._simulated(finer.loaded, lint=_lint_rows(finer), **options)
        except RunError:
            return examined, result
        if again.state != "finished":
            return examined, result
        finer.intended = examined.intended
        attempt.coarse_text, attempt.text = attempt.text, text
        return finer, again

    def refilm(self, loaded: LoadedCase) -> None:
        """Update the run of a case whose `render` section or looks alone have changed; its film is traced later.

        Raises:
            RunError: If the case would have to be simulated again.
            KeyboardInterrupt: If the user stopped it.
        """
        from text2sim.compiler.build import plan_case
        from text2sim.harness.run import run_case

        runs = self.case / "runs"
        run = runs / f"{loaded.case.name}-{plan_case(loaded).sim_digest[:10]}"
        if not (run / "states").is_dir():
            raise RunError("this film would require another simulation")
        if run_case(loaded, runs=runs, film=False).stopped:
            raise KeyboardInterrupt

    def record_facts(self, attempt: Attempt, plan: CasePlan, loaded: LoadedCase) -> None:
        """Compute the facts that the plan binds to requirements, except those about causes.

        Args:
            attempt: The attempt; its facts are replaced and stored.
            plan: The plan that binds facts to requirements.
            loaded: The case of the attempt.
        """
        about_causes = [row for row in attempt.facts if row.get("about_cause")]
        attempt.facts = [*facts_as_data(compute_facts(plan.facts, loaded, self.case / attempt.run)), *about_causes]
        self.keep(attempt)

    def rerun_without_causes(
        self,
        attempt: Attempt,
        plan: CasePlan,
        timeout: float,
        on_progress: Callable[[Any], None],
        now: float | None = None,
        earlier: Sequence[Attempt] = (),
    ) -> None:
        """Rerun a successful attempt without each of its causes, and add the effects to its evidence.

        If an earlier attempt has the same run and the same causes, the runs without them exist as well: they are only
        judged again, whatever time is left, because expectations may have changed.

        Args:
            attempt: The attempt; the effects are added to it and stored.
            plan: The plan that names the causes.
            timeout: Limit of each run [s].
            on_progress: Callback for the progress of each run.
            now: Minutes left by the clock; None without a limit.
            earlier: The attempts before; the slowest of all runs predicts how long another takes.

        Raises:
            KeyboardInterrupt: If the user stopped one of these runs.
        """

        def simulate(loaded: LoadedCase) -> tuple[str, Found]:
            result = self._simulated(loaded, timeout=timeout, on_progress=on_progress)
            return result.state, result.expectations

        if plan.causes and TITLE not in attempt.evidence:
            begun, seconds = monotonic(), max(one.wall for one in (attempt, *earlier))
            there = any(one.run == attempt.run and were_tried(one.facts, plan) for one in earlier)
            if now is not None and not there and seconds > MAX_REPEAT_SHARE * 60 * now:
                facts = [untried_causes(plan, seconds)]
            else:
                path = self.case / "case.yaml"
                facts = compare_causes(plan, attempt.text, path, simulate, self.case / attempt.run)
            attempt.evidence = f"{attempt.evidence}\n\n{causes_text(facts)}"
            attempt.facts += facts_as_data(replace(fact, about_cause=True) for fact in facts)
            attempt.cites = sorted({*attempt.cites, "diagnostic:causes"})
            attempt.took = round(attempt.took + monotonic() - begun, 1)
            self.keep(attempt)

    def trials(
        self,
        attempt: Attempt,
        text: str,
        settings: Sequence[Settings],
        seconds: float,
        on_progress: Callable[[Any], None],
    ) -> str:
        """Run a case with several settings of its parameters, and describe the outcomes, one line each.

        Args:
            attempt: The attempt that the Planner decides about; the outcomes are stored in its folder.
            text: The case.
            settings: Parameters of each trial.
            seconds: Wall time that all of them may take [s].
            on_progress: Callback for the progress of each run.

        Raises:
            KeyboardInterrupt: If the user stopped one of these runs.
        """

        def simulate(loaded: LoadedCase, limit: float) -> Outcome:
            result = self._simulated(loaded, timeout=limit, on_progress=on_progress)
            if result.evidence is None:
                return Outcome(result.state)
            tracks = track_rows(result.folder, loaded.case, result.evidence["events"], MAX_TRACKS)
            return Outcome(result.state, result.evidence, tracks)

        store = self.folder_of(attempt.number) / "trials.json"
        return trials_text(text, settings, self.case / "case.yaml", store, seconds, simulate)

    def _simulated(self, loaded: LoadedCase, **options: Any) -> "RunResult":
        """Run a case without a film: the Critic sees path-traced frames, and a preview takes longer than most runs."""
        from text2sim.harness.run import run_case

        result = run_case(loaded, runs=self.case / "runs", film=False, runner=self.runner, **options)
        if result.stopped:
            raise KeyboardInterrupt  # before any of it is stored
        return result

    def _pictures(self, attempt: Attempt, run: Path, preview: Callable[[], Any]) -> tuple[list[str], int, str]:
        """Make the sheet of numbered frames for the Critic; return its file name, the number of frames, and a note."""
        sheet, count, note = frame_sheet(run, preview)
        if sheet is None:
            return [], 0, ""
        folder = self.folder_of(attempt.number)
        folder.mkdir(parents=True, exist_ok=True)
        write_atomically(folder / "frames.png", sheet_png(sheet))
        return ["frames.png"], count, note

    def publish(self, attempt: Attempt) -> None:
        """Copy an attempt's case to `case.yaml`."""
        self.case.mkdir(parents=True, exist_ok=True)
        write_atomically(self.case / "case.yaml", attempt.text)


def _further_evidence(
    result: "RunResult", examined: Examination, loaded: LoadedCase, told: Collection[tuple[str, str]]
) -> Iterator[str]:
    """Yield what is told besides the summary of a run: tracks, derived settings, warnings, and what is to blame.

    Intended warnings that were told before are left out.
    """
    if result.evidence is not None and (tracks := tracks_text(result.folder, loaded.case, result.evidence["events"])):
        yield tracks
    if examined.derived:
        yield examined.derived
    if warnings := _judged_warnings(examined, told):
        yield "## Warnings of the lint\n\n" + "\n".join(
            f"- {p.path}: {p.message} [{p.rule}]{_intended_note(examined.intended.get((p.rule, p.path)))}"
            for p in warnings[:10]
        )
    if result.problem is not None:
        yield f"To blame: {result.problem.path or f'line {result.problem.line}'}: {result.problem.message}"


def _lint_rows(examined: Examination) -> list[dict[str, Any]]:
    return [{"rule": p.rule, "path": p.path, "message": p.message, "reason": None} for p in examined.warnings]


def _judged_warnings(examined: Examination, told: Collection[tuple[str, str]]) -> list[Problem]:
    known = examined.intended.keys() & told
    return [p for p in examined.warnings if p.rule not in UNJUDGED_RULES and (p.rule, p.path) not in known]


def _intended_note(why: str | None) -> str:
    return "" if why is None else f" (intended, says its owner{f': {why}' if why else ''})"
