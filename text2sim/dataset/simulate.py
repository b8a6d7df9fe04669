"""One draw of a case: checked, simulated, filmed; drawn again until it is what the recipe wants."""

import json
import re
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from hashlib import sha256
from pathlib import Path
from typing import Any

from text2sim.cluster.task import Needs, Task, TaskPlace
from text2sim.dataset.curation import is_doubtful, refusals
from text2sim.dataset.draws import Values, draw, generator, number_at, overlay_of
from text2sim.dataset.item import Item, heed, make_item
from text2sim.dataset.questions import ask, cause_in_words, what_if
from text2sim.dataset.recipe import CaseSource, Recipe
from text2sim.harness.run import Runner, run_case
from text2sim.harness.sources import package_code
from text2sim.recording.record import write_atomically
from text2sim.runtime.machine_check import needs_cuda
from text2sim.runtime.program import run_program
from text2sim.runtime.stop import Stop
from text2sim.service.examined import Examined, examine
from text2sim.spec_schema.errors import MachineError, Text2SimError
from text2sim.spec_schema.reuse.overlay import CaseOverlay

_ODD = re.compile(r"[^A-Za-z0-9_]+")


@dataclass(frozen=True)
class DrawJob:
    """A draw that is to be made, with its films and counterfactuals."""

    recipe: Recipe
    source: str
    case: Path
    name: str
    """Of the case."""
    base: CaseOverlay
    """Variant or point of a sweep."""
    number: int
    """Of the draw."""
    runs: Path
    out: Path
    """Folder for the files of its items."""
    runner: Runner = run_program
    stop: Stop | None = None

    @property
    def key(self) -> str:
        """Name of its first item."""
        words = [self.source, self.name, self.base.label, f"{self.number:03d}"]
        return "-".join(_ODD.sub("_", word) for word in words if word)


@dataclass
class DrawResult:
    """What came of a job."""

    items: list[Item] = field(default_factory=list)
    refused: list[dict[str, Any]] = field(default_factory=list)
    """Draws and items that are not taken: `key`, `stage` (check, run, expectation, item), `why`, `drawn`."""


def task_of(job: DrawJob, one: Needs) -> Task:
    """Return a job as a task.

    Args:
        job: The job.
        one: What a simulation of its case was measured to occupy.
    """
    count = 1 + len(job.recipe.sources[job.source].counterfactuals)
    needs = replace(one, seconds=None if one.seconds is None else one.seconds * count)
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
    """Do a job where it is sent to; its items, and what is said of them, are written to `place.output`.

    Args:
        place: Where the task runs: its inputs and output.
        recipe: The recipe, as JSON.
        source: Name of its source.
        file: File of the case, in the folder of the case.
        name: Name of the case.
        variants: Variants that are laid over the case.
        sets: Values that are laid over the case, as `path=value`.
        point: Names of a sweep and a point of it, if there is one.
        number: Number of the draw.
        runs: Folder of runs.
    """
    base = CaseOverlay(tuple(variants), tuple(sets), (point[0], point[1]) if point else None)
    case = place.inputs["case"] / file
    told = Recipe.model_validate(recipe)
    # On another machine runs go with the task's folder: what lies in folders with a dot stays there.
    kept = Path(runs) if Path(runs).parent.is_dir() else place.output / ".runs"
    job = DrawJob(told, source, case, name, base, number, kept, place.output, place.runner, place.stop)
    return {"fresh": make(job)}


def make(job: DrawJob) -> bool:
    """Do a job, and return whether there was anything to do, which is not so if an earlier build did it.

    What its author can put right ends up among what is refused.

    Raises:
        RunError: if somebody asked to stop before it was done.
    """
    job.out.mkdir(parents=True, exist_ok=True)
    done, digest = job.out / f"{job.key}.json", _digest(job)
    if done.is_file() and json.loads(done.read_text("utf-8"))["digest"] == digest:
        return False
    done.unlink(
        missing_ok=True
    )  # its files are about to change: a build by the earlier recipe must not take them for its own
    made = _make(job)
    rows = [asdict(item) | {"folder": ""} for item in made.items]
    write_atomically(done, json.dumps({"digest": digest, "items": rows, "refused": made.refused}))
    return True


def read_made(job: DrawJob) -> DrawResult:
    """Return what came of a job that is done."""
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


def _make(job: DrawJob) -> DrawResult:
    made, source = DrawResult(), job.recipe.sources[job.source]
    found = _simulated(job, source, made)
    if found is None:
        return made
    row, run, drawn = found
    first = _films(job, source, made, row, run, job.key, drawn, {})
    if first is None:
        return made
    for name, table in source.counterfactuals.items():
        key = f"{job.key}-{name}"
        try:
            rng = generator(job.recipe.seed, key, "physics")
            changed = draw(table, rng, _data(row))
        except Text2SimError as error:
            made.refused.append({"key": key, "stage": "check", "why": [str(error)], "drawn": []})
            continue
        told = [*drawn, *_told("physics", changed)]
        other = examine(job.case, overlay=row.overlay + overlay_of(changed))
        run_of_other = _run(job, other, key, told, made)
        if run_of_other is not None:
            about = {"counterfactual_of": first, "cause": next(iter(changed))}
            if _films(job, source, made, other, run_of_other.folder, key, told, about) is not None:
                _compare(made, first, key, *_change(row, changed))
    return made


def _simulated(
    job: DrawJob, source: CaseSource, made: DrawResult
) -> tuple[Examined, Path, list[dict[str, Any]]] | None:
    """Draw until the check and the expectations are content; return the case, its run folder, and what was drawn."""
    plain = examine(job.case, plan=False, overlay=job.base)
    for attempt in range(job.recipe.tries if source.physics else 1):
        rng = generator(job.recipe.seed, job.key, attempt, "physics")
        try:
            values: Values = draw(source.physics, rng, _data(plain)) if plain.ok else {}
        except Text2SimError as error:
            made.refused.append({"key": job.key, "stage": "check", "why": [str(error)], "drawn": []})
            return None
        row = examine(job.case, overlay=job.base + overlay_of(values))
        told = _told("physics", values)
        result = _run(job, row, job.key, told, made)
        if result is None:
            continue
        came = {name: one["ok"] for name, one in result.expectations.items()}
        wanted = [*came] if source.holds == "all" else source.holds
        missed = [f"`{name}` did not come true" for name in wanted if came.get(name) is not True]
        missed += [f"`{name}` came true" for name in source.fails if came.get(name) is not False]
        if not missed:
            return row, result.folder, told
        made.refused.append({"key": job.key, "stage": "expectation", "why": missed, "drawn": told})
    return None


def _run(job: DrawJob, row: Examined, key: str, drawn: list[dict[str, Any]], made: DrawResult) -> Any:
    """Simulate a case that the check lets through; None with the reason in `made` if it does not, or if that fails."""
    heed(job.stop)
    stage, refuse = "check", job.recipe.sources[job.source].refuse
    if row.ok and row.loaded is not None and not _unwanted(row, refuse):
        try:
            lint, how = row.findings(), {"runner": job.runner, "stop": job.stop}
            result = run_case(row.loaded, runs=job.runs, film=False, lint=lint, **how)
        except Text2SimError as error:
            if isinstance(error, MachineError) and not needs_cuda(row.loaded):  # not the draw's fault
                raise
            row.blame(error)
            stage = "run"
        else:
            heed(job.stop)  # what was stopped has evidence, too
            if result.evidence is not None:
                return result
            row.failure, stage = f"the run ended as {result.state}: {result.message}", "run"
    why = _unwanted(row, refuse) or [row.failure]
    made.refused.append({"key": key, "stage": stage, "why": why, "drawn": drawn})
    return None


def _films(
    job: DrawJob,
    source: CaseSource,
    made: DrawResult,
    row: Examined,
    run: Path,
    key: str,
    drawn: list[Any],
    about: dict[str, Any],
) -> str | None:
    """Make the items of one run; return the key of the first, None if that is refused."""
    first: str | None = None
    for number in range(source.films):
        heed(job.stop)
        name = f"{key}-film{number}" if number else key
        seen, told = row, drawn
        if number:
            found = _redressed(job, source, made, row, key, name)
            if found is None:
                continue
            seen, told = found[0], [*drawn, *found[1]]
        try:
            assert seen.loaded is not None
            item = make_item(name, run, seen.plan, seen.loaded, job.recipe, job.out / name, job.stop)
        except Text2SimError as error:
            heed(job.stop)
            made.refused.append({"key": name, "stage": "item", "why": [str(error)], "drawn": told})
            continue
        if reasons := refusals(item, job.recipe.limits):
            made.refused.append({"key": name, "stage": "item", "why": reasons, "drawn": told})
            continue
        variant = " ".join([*job.base.variants, *(job.base.point or ())])
        item.row["prompt"] = item.row["prompt"] or source.prompt
        item.row |= {"source": job.source, "variant": variant, "draw": job.number, "drawn": told, **about}
        item.row |= {"same_physics_as": first, "doubtful": is_doubtful(item.row, job.recipe.limits)}
        made.items.append(item)
        item.questions = ask(item.row, item.frames, item.folder)
        first = first or name
    return first


def _change(row: Examined, changed: Values) -> tuple[str, Any, float | None]:
    """Path and value of a cause that was changed, and the number that was there."""
    (path, value), *_ = changed.items()
    try:
        return path, value, number_at(_data(row), path)
    except Text2SimError:
        return path, value, None


def _compare(made: DrawResult, first: str, key: str, *change: Any) -> None:
    """Ask about the films of a run what a run with another cause answers."""
    other = next(item for item in made.items if item.key == key or item.row["same_physics_as"] == key)
    for item in made.items:
        if first in (item.key, item.row["same_physics_as"]):
            item.questions += what_if(item.row, other.row, cause_in_words(*change), item.frames, item.folder)


def _redressed(
    job: DrawJob, source: CaseSource, made: DrawResult, row: Examined, key: str, name: str
) -> tuple[Examined, list[dict[str, Any]]] | None:
    """Draw looks, lights and cameras for a run until the check is content; the physics has to stay the same.

    A counterfactual has the looks of what it is compared with: they depend on the draw, and not on the cause.
    """
    number = name.removeprefix(key)
    for attempt in range(job.recipe.tries):
        told, sets = [], CaseOverlay()
        for group in ("looks", "lights", "cameras"):
            rng = generator(job.recipe.seed, job.key, number, attempt, group)
            try:
                values = draw(getattr(source, group), rng, _data(row))
            except Text2SimError as error:
                made.refused.append({"key": name, "stage": "check", "why": [str(error)], "drawn": told})
                return None
            told += _told(group, values)
            sets += overlay_of(values)
        seen = examine(job.case, overlay=row.overlay + sets)
        why = _unwanted(seen, source.refuse)
        if not why and seen.plan is not None and row.plan is not None:
            if seen.plan.sim_digest == row.plan.sim_digest:
                return seen, told
            why = ["what was drawn for the film changes the simulation"]
        made.refused.append({"key": name, "stage": "check", "why": why or [seen.failure], "drawn": told})
    return None


def _unwanted(row: Examined, refuse: Sequence[str]) -> list[str]:
    """What refuses a case, without the folder that it lies in: a dataset goes to other people."""
    problems = [problem for problem in row.problems if problem.severity == "error" or problem.rule in refuse]
    return [str(replace(problem, file=Path(problem.file).name)) for problem in problems]


def _told(group: str, values: Values) -> list[dict[str, Any]]:
    return [{"group": group, "path": path, "value": json.dumps(value)} for path, value in values.items()]


def _data(row: Examined) -> Any:
    return row.loaded.data if row.loaded is not None else {}
