"""Draws of a case, checked, simulated and filmed; drawn again until they meet the recipe."""

import json
import re
from dataclasses import asdict, dataclass, field, replace
from hashlib import sha256
from pathlib import Path
from typing import Any

from text2sim.cluster.task import Needs, Task, TaskPlace
from text2sim.dataset.curation import is_doubtful, refusals
from text2sim.dataset.draws import Values, draw, generator, number_at, overlay_of
from text2sim.dataset.item import Item, make_item, raise_if_stopped
from text2sim.dataset.questions import candidate_questions, cause_in_words, what_if
from text2sim.dataset.recipe import FILM_GROUPS, Recipe
from text2sim.harness.result import RunResult
from text2sim.harness.run import Runner, run_case
from text2sim.harness.sources import package_code
from text2sim.runtime.machine_check import needs_cuda
from text2sim.runtime.program import run_program
from text2sim.runtime.stop import Stop
from text2sim.service.examined import Examined, examine
from text2sim.spec_schema.errors import MachineError, Text2SimError
from text2sim.spec_schema.reuse.overlay import CaseOverlay
from text2sim.spec_schema.whole_files import write_atomically

_ODD = re.compile(r"[^A-Za-z0-9_]+")


@dataclass(frozen=True)
class DrawJob:
    """The job of making a draw with its films and counterfactuals."""

    recipe: Recipe
    source: str
    case: Path
    name: str
    """Name of the case."""
    base: CaseOverlay
    """Variant or point of a sweep."""
    number: int
    """Number of the draw."""
    runs: Path
    out: Path
    """Folder for the files of its items."""
    runner: Runner = run_program
    stop: Stop | None = None

    @property
    def key(self) -> str:
        """Key of its first item."""
        words = [self.source, self.name, self.base.label, f"{self.number:03d}"]
        return "-".join(_ODD.sub("_", word) for word in words if word)

    @property
    def item_keys(self) -> list[str]:
        """Keys of all items that it may give."""
        source = self.recipe.sources[self.source]
        runs = [self.key, *(f"{self.key}-{name}" for name in source.counterfactuals)]
        return [_film_key(run, number) for run in runs for number in range(source.films)]


@dataclass
class DrawResult:
    """The result of a job."""

    items: list[Item] = field(default_factory=list)
    refused: list[dict[str, Any]] = field(default_factory=list)
    """Refused draws and items: `key`, `stage` (check, run, expectation, item), `why`, `drawn`."""

    def refuse(self, key: str, stage: str, why: list[str], drawn: list[dict[str, Any]]) -> None:
        """Add a refused draw or item.

        Args:
            key: Its key.
            stage: Stage that refused it.
            why: The reasons.
            drawn: Its drawn values.
        """
        self.refused.append({"key": key, "stage": stage, "why": why, "drawn": drawn})


def task_of(job: DrawJob, measured: Needs) -> Task:
    """Return a job as a task with the measured needs of a simulation of its case."""
    count = 1 + len(job.recipe.sources[job.source].counterfactuals)
    needs = replace(measured, seconds=None if measured.seconds is None else measured.seconds * count)
    own = job.recipe.model_copy(update={"sources": {job.source: job.recipe.sources[job.source]}})
    arguments = {
        "recipe": own.model_dump(mode="json", exclude_unset=True),
        "source": job.source,
        "file": job.case.name,
        "name": job.name,
        "variants": job.base.variants,
        "sets": job.base.sets,
        "point": job.base.point,
        "number": job.number,
        "runs": str(job.runs.absolute()),
    }
    return Task(f"{__name__}:work", arguments, job.key, needs, {"case": job.case.parent}, job.out)


def work(
    place: TaskPlace,
    *,
    recipe: dict[str, Any],
    source: str,
    file: str,
    name: str,
    variants: list[str],
    sets: list[str],
    point: list[str] | None,
    number: int,
    runs: str,
) -> dict[str, Any]:
    """Do a job on the machine of its task; its items and its result are written to `place.output`.

    Args:
        place: Inputs and output of the task.
        recipe: The recipe, as JSON.
        source: Name of its source.
        file: File of the case, in the folder of the case.
        name: Name of the case.
        variants: Variants of the overlay.
        sets: Values of the overlay, as `path=value`.
        point: Names of a sweep and a point of it, if there is one.
        number: Number of the draw.
        runs: Folder of runs.
    """
    base = CaseOverlay(tuple(variants), tuple(sets), (point[0], point[1]) if point else None)
    case = place.inputs["case"] / file
    # Another machine keeps runs in the task's folder: folders whose names begin with a dot are not sent back.
    kept = Path(runs) if Path(runs).parent.is_dir() else place.output / ".runs"
    own = Recipe.model_validate(recipe)
    job = DrawJob(own, source, case, name, base, number, kept, place.output, place.runner, place.stop)
    return {"fresh": make(job)}


def make(job: DrawJob) -> bool:
    """Do a job unless an earlier build did it; return whether it was done now.

    Problems that the author can fix become refusals.

    Raises:
        RunError: if the user asked to stop before it was done.
    """
    job.out.mkdir(parents=True, exist_ok=True)
    done, digest = job.out / f"{job.key}.json", _digest(job)
    if done.is_file() and json.loads(done.read_text("utf-8"))["digest"] == digest:
        return False
    # The files of the job are about to change: a build of the earlier recipe must not use them.
    done.unlink(missing_ok=True)
    made = _DrawMaker(job).make()
    rows = [asdict(item) | {"folder": ""} for item in made.items]
    write_atomically(done, json.dumps({"digest": digest, "items": rows, "refused": made.refused}))
    return True


def read_made(job: DrawJob) -> DrawResult:
    """Return the result of a finished job."""
    saved = json.loads((job.out / f"{job.key}.json").read_text("utf-8"))
    items = [Item(**{**item, "folder": job.out / item["key"]}) for item in saved["items"]]
    return DrawResult(items, saved["refused"])


def _digest(job: DrawJob) -> str:
    own = job.recipe.model_dump(
        mode="json", exclude={"splits", "description", "sources", "shard_mb", "benchmarks", "judged"}
    )
    source = job.recipe.sources[job.source].model_dump(mode="json", exclude={"cases", "split", "draws"})
    case = job.case.read_text("utf-8", "replace")
    return sha256(json.dumps([own, source, repr(job.base), case, package_code()]).encode()).hexdigest()


class _DrawMaker:
    """Makes the items of a job.

    Attributes:
        made: Items and refusals so far.
    """

    def __init__(self, job: DrawJob) -> None:
        self._job, self._source = job, job.recipe.sources[job.source]
        self.made = DrawResult()

    def make(self) -> DrawResult:
        found = self._simulate_draw()
        if found is None:
            return self.made
        case, run, drawn = found
        first = self._make_films(case, run, self._job.key, drawn, {})
        if first is None:
            return self.made
        for name, table in self._source.counterfactuals.items():
            key = f"{self._job.key}-{name}"
            try:
                changed = draw(table, generator(self._job.recipe.seed, key, "physics"), _data(case))
            except Text2SimError as error:
                self.made.refuse(key, "check", [str(error)], [])
                continue
            all_drawn = [*(row for row in drawn if row["path"] not in changed), *_drawn_rows("physics", changed)]
            other = examine(self._job.case, overlay=case.overlay + overlay_of(changed))
            if other.plan is not None and case.plan is not None and other.plan.sim_digest == case.plan.sim_digest:
                path, value = next(iter(changed.items()))
                why = f"duplicate: {path}={json.dumps(value)} does not change the simulation of {self._job.key}"
                self.made.refuse(key, "item", [why], all_drawn)
                continue
            run_of_other = self._run(other, key, all_drawn)
            if run_of_other is not None:
                about = {"counterfactual_of": first, "cause": next(iter(changed))}
                first_of_other = self._make_films(other, run_of_other.folder, key, all_drawn, about)
                if first_of_other is not None:
                    self._ask_what_if(first, first_of_other, _cause(case, changed))
        return self.made

    def _simulate_draw(self) -> tuple[Examined, Path, list[dict[str, Any]]] | None:
        """Draw until check and expectations pass; return the case, its run folder, and the drawn values."""
        job, source = self._job, self._source
        plain = examine(job.case, to="loaded", overlay=job.base)
        for attempt in range(job.recipe.tries if source.physics else 1):
            rng = generator(job.recipe.seed, job.key, attempt, "physics")
            try:
                values: Values = draw(source.physics, rng, _data(plain)) if plain.ok else {}
            except Text2SimError as error:
                self.made.refuse(job.key, "check", [str(error)], [])
                return None
            case = examine(job.case, overlay=job.base + overlay_of(values))
            drawn = _drawn_rows("physics", values)
            result = self._run(case, job.key, drawn)
            if result is None:
                continue
            met = {name: expectation["ok"] for name, expectation in result.expectations.items()}
            wanted = [*met] if source.holds == "all" else source.holds
            why = [f"`{name}` was not met" for name in wanted if met.get(name) is not True]
            why += [f"`{name}` was met" for name in source.fails if met.get(name) is not False]
            if not why:
                return case, result.folder, drawn
            self.made.refuse(job.key, "expectation", why, drawn)
        return None

    def _run(self, case: Examined, key: str, drawn: list[dict[str, Any]]) -> RunResult | None:
        """Simulate a case that passes the check; None, with the reason in `made`, if check or simulation fail."""
        job, stage = self._job, "check"
        raise_if_stopped(job.stop)
        if case.ok and case.loaded is not None and not self._refusing_problems(case):
            stage = "run"
            try:
                result = run_case(
                    case.loaded, runs=job.runs, film=False, lint=case.findings(), runner=job.runner, stop=job.stop
                )
            except Text2SimError as error:
                if isinstance(error, MachineError) and not needs_cuda(case.loaded):  # not the draw's fault
                    raise
                case.blame(error)
            else:
                raise_if_stopped(job.stop)  # a stopped run has evidence, too
                if result.evidence is not None:
                    return result
                case.failure = f"the run ended as {result.state}: {result.message}"
        self.made.refuse(key, stage, self._refusing_problems(case) or [case.failure], drawn)
        return None

    def _make_films(
        self, case: Examined, run: Path, key: str, drawn: list[dict[str, Any]], about: dict[str, Any]
    ) -> str | None:
        """Make the items of a run; return the key of the first accepted one, None if there is none."""
        job, first = self._job, None
        for number in range(self._source.films):
            raise_if_stopped(job.stop)
            name = _film_key(key, number)
            filmed, all_drawn = case, drawn
            if number:
                found = self._draw_film(case, key, name)
                if found is None:
                    continue
                filmed, all_drawn = found[0], [*drawn, *found[1]]
            try:
                assert filmed.loaded is not None
                item = make_item(name, run, filmed.plan, filmed.loaded, job.recipe, job.out / name, job.stop)
            except Text2SimError as error:
                raise_if_stopped(job.stop)
                self.made.refuse(name, "item", [str(error)], all_drawn)
                continue
            if reasons := refusals(item, job.recipe.limits):
                self.made.refuse(name, "item", reasons, all_drawn)
                continue
            variant = " ".join([*job.base.variants, *(job.base.point or ())])
            item.row["prompt"] = item.row["prompt"] or self._source.prompt
            item.row |= {"source": job.source, "variant": variant, "draw": job.number, "drawn": all_drawn, **about}
            item.row |= {"same_physics_as": first, "doubtful": is_doubtful(item.row, job.recipe.limits)}
            self.made.items.append(item)
            item.questions = candidate_questions(item.row, item.frames, item.folder)
            first = first or name
        return first

    def _ask_what_if(self, first: str, first_of_other: str, cause: str) -> None:
        """Add questions about the films of a run that its counterfactual answers."""
        other = next(item for item in self.made.items if item.key == first_of_other)
        for item in self.made.items:
            if first in (item.key, item.row["same_physics_as"]):
                item.questions += what_if(item.row, other.row, cause, item.frames, item.folder)

    def _draw_film(self, case: Examined, key: str, name: str) -> tuple[Examined, list[dict[str, Any]]] | None:
        """Draw looks, lights and cameras for a run until the check passes; the simulation must not change.

        A counterfactual has the looks of its base: they depend on the draw, not on the cause.
        """
        job, number = self._job, name.removeprefix(key)
        for attempt in range(job.recipe.tries):
            drawn, sets = [], CaseOverlay()
            for group in FILM_GROUPS:
                rng = generator(job.recipe.seed, job.key, number, attempt, group)
                try:
                    values = draw(getattr(self._source, group), rng, _data(case))
                except Text2SimError as error:
                    self.made.refuse(name, "check", [str(error)], drawn)
                    return None
                drawn += _drawn_rows(group, values)
                sets += overlay_of(values)
            filmed = examine(job.case, overlay=case.overlay + sets)
            why = self._refusing_problems(filmed)
            if not why and filmed.plan is not None and case.plan is not None:
                if filmed.plan.sim_digest == case.plan.sim_digest:
                    return filmed, drawn
                why = ["the draws for the film change the simulation"]
            self.made.refuse(name, "check", why or [filmed.failure], drawn)
        return None

    def _refusing_problems(self, case: Examined) -> list[str]:
        """The problems that refuse a case, without its folder, because a dataset goes to other people."""
        refuse = self._source.refuse
        problems = [problem for problem in case.problems if problem.severity == "error" or problem.rule in refuse]
        return [str(replace(problem, file=Path(problem.file).name)) for problem in problems]


def _film_key(key: str, number: int) -> str:
    """The key of a film of the run with this key."""
    return f"{key}-film{number}" if number else key


def _cause(case: Examined, changed: Values) -> str:
    """The changed cause of a counterfactual, in words."""
    (path, value), *_ = changed.items()
    try:
        return cause_in_words(path, value, number_at(_data(case), path))
    except Text2SimError:
        return cause_in_words(path, value, None)


def _drawn_rows(group: str, values: Values) -> list[dict[str, Any]]:
    return [{"group": group, "path": path, "value": json.dumps(value)} for path, value in values.items()]


def _data(case: Examined) -> Any:
    return case.loaded.data if case.loaded is not None else {}
