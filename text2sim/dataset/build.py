"""Builds a dataset from a recipe: jobs run in parallel, items are written as they arrive."""

import json
import shutil
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from text2sim.cluster.estimate import measured_needs
from text2sim.cluster.run import Placement, run_tasks
from text2sim.cluster.task import Needs, Task
from text2sim.dataset.balance import Group, balanced_questions
from text2sim.dataset.card import write_card
from text2sim.dataset.curation import Likeness, same_film
from text2sim.dataset.item import Item
from text2sim.dataset.lerobot import RobotForm, RobotWriter, robot_form
from text2sim.dataset.recipe import Recipe
from text2sim.dataset.review import read_decisions
from text2sim.dataset.shards import ShardWriter
from text2sim.dataset.simulate import DrawJob, DrawResult, read_made, task_of
from text2sim.dataset.splits import deal_splits
from text2sim.dataset.tables import TableWriter
from text2sim.runtime.lock import RunLock
from text2sim.runtime.stop import Stop
from text2sim.service.examined import case_file, examine, find_cases
from text2sim.spec_schema.errors import MachineError, RunError, SpecError
from text2sim.spec_schema.reuse.overlay import CaseOverlay
from text2sim.spec_schema.reuse.sweeps import runs_of
from text2sim.spec_schema.whole_files import write_atomically


@dataclass
class Tally:
    """Counts of a build."""

    jobs: int = 0
    done: int = 0
    fresh: int = 0
    """Jobs of `done` that no earlier build had done."""
    items: Counter[str] = field(default_factory=Counter)
    """Items by split."""
    refused: Counter[str] = field(default_factory=Counter)
    """Refused draws and items by stage."""
    tables: dict[str, Counter[str]] = field(default_factory=dict)
    """Rows by table and split."""


def jobs_of(recipe: Recipe, root: Path, runs: Path, out: Path) -> list[DrawJob]:
    """Return the jobs of a recipe.

    Args:
        recipe: The recipe.
        root: Folder that its paths are relative to.
        runs: Folder of run folders.
        out: Folder for the files of items.

    Raises:
        SpecError: with the problems of the cases, such as a missing variant or sweep.
        RunError: if a case cannot be read.
    """
    jobs, problems = [], []
    for name, source in recipe.sources.items():
        for case in find_cases(root / path for path in source.cases):
            plain = examine(case, to="loaded")
            if plain.loaded is None:
                if not plain.problems:
                    raise RunError(f"{plain.title}: {plain.failure}")
                problems += plain.problems
                continue
            bases = [CaseOverlay()] if source.plain else []
            bases += [CaseOverlay(variants=(variant,)) for variant in source.variants]
            if source.sweep is not None:
                bases += [over for _, over in runs_of(plain.loaded.written, source.sweep)]
            for base in bases:
                if base and not (found := examine(case, to="loaded", overlay=base)).ok:
                    problems += found.problems
                jobs += [
                    DrawJob(recipe, name, case_file(case), plain.name, base, k, runs, out) for k in range(source.draws)
                ]
    if problems:
        raise SpecError(problems)
    # The first draws of all cases come first, so that a build that is stopped has some items of each.
    return sorted(jobs, key=lambda job: job.number)


def build(
    recipe: Recipe,
    root: Path,
    target: Path,
    runs: Path,
    *,
    where: Placement,
    decisions: Path | None = None,
    scores: Mapping[str, list[dict[str, Any]]] | None = None,
    tell: Callable[[Tally, DrawResult], None],
    announce: Callable[[Sequence[Task]], None] = lambda _: None,
    complete: Callable[[Path], None] = lambda _: None,
) -> Tally:
    """Build a dataset. The folder appears when it is complete.

    Args:
        recipe: The recipe.
        root: Folder that its paths are relative to.
        target: Folder of the dataset, which must not exist.
        runs: Folder of run folders; simulations that it has are reused.
        where: Where the jobs run, and how many at a time.
        decisions: File with a reviewer's decisions; see `read_decisions`.
        scores: Scores of judges, by digest of the simulation.
        tell: Called after each job.
        announce: Called with the tasks before they start.
        complete: Called with the folder once it has all items, before its card is written; may add files.

    Raises:
        RunError: if the folder exists, or no job gave an item.
        SpecError: with the problems of the cases, or of the decisions.
        MachineError: if this machine, or the cluster, cannot run a case, or another build into the folder is running.
        KeyboardInterrupt: if the user stopped it; the next build continues it.
    """
    _want_no_folder(target)
    # Finished jobs of a build that was stopped stay in this folder, and are reused.
    stage = target.with_name(f".{target.name}.parts")
    jobs = jobs_of(recipe, root, runs, stage / "items")
    reviewed = read_decisions(decisions, {key: None for job in jobs for key in job.item_keys})
    dropped = {key: one.note for key, one in reviewed.items() if one.decision == "drop"}
    with RunLock(stage, target.name, "built"):
        _want_no_folder(target)  # another build may just have completed it
        folder = stage / "dataset"
        shutil.rmtree(folder, ignore_errors=True)
        writer = Writer(recipe, folder, deal_splits(recipe, [(job.source, job.name) for job in jobs]), dropped, scores)
        writer.tally.jobs = len(jobs)
        known = measured_needs(runs)
        tasks = [task_of(job, known.get(job.name, Needs())) for job in jobs]
        announce(tasks)
        for fresh, result in _results(dict(zip(map(id, tasks), jobs, strict=True)), tasks, where):
            writer.tally.fresh += fresh
            writer.add(result)
            tell(writer.tally, result)
        writer.close()
        if not writer.tally.items:
            raise RunError(f"{len(jobs)} draws gave no item: {_main_reason(folder / 'refused.jsonl')}")
        complete(folder)
        write_card(folder, recipe, writer.tally.tables)
        folder.rename(target)
    shutil.rmtree(stage)
    return writer.tally


def _want_no_folder(target: Path) -> None:
    if target.exists():
        raise RunError(f"{target} already exists; name another folder, or remove it")


def _results(job_of: dict[int, DrawJob], tasks: Sequence[Task], where: Placement) -> Iterator[tuple[bool, DrawResult]]:
    """Run the tasks of jobs; yield whether each was done now, and its result."""
    with Stop() as stop:
        for done in run_tasks(tasks, where, stop):
            job = job_of[id(done.task)]
            if done.stopped:
                continue
            if done.machine:
                raise MachineError(done.error)
            if done.result is None:
                failed = DrawResult()
                failed.refuse(job.key, "error", [done.error], [])
                yield bool(done.tries), failed
            else:
                yield bool(done.tries and done.result["fresh"]), read_made(job)
        if stop.count:
            raise KeyboardInterrupt


class Writer:
    """Writes the results of jobs: tables, shards, and the list of refusals.

    Args:
        recipe: The recipe.
        folder: Folder of the dataset.
        splits: Split of each source.
        dropped: Items that a reviewer dropped, with the reasons.
        scores: Scores of judges, by digest of the simulation.
    """

    def __init__(
        self,
        recipe: Recipe,
        folder: Path,
        splits: dict[str, Any],
        dropped: Mapping[str, str] | None = None,
        scores: Mapping[str, list[dict[str, Any]]] | None = None,
    ):
        self._recipe, self._folder, self._splits = recipe, folder, splits
        self._dropped, self._scores = dropped or {}, scores or {}
        self._tables: dict[tuple[str, str], TableWriter] = {}
        self._shards: dict[str, ShardWriter] = {}
        self._robots: dict[tuple[str, RobotForm], RobotWriter] = {}
        self._likeness = Likeness(recipe.limits.alike)
        self.tally = Tally()
        folder.mkdir(parents=True)
        self._refused = (folder / "refused.jsonl").open("w", encoding="utf-8")
        self._asked = (folder / "questions.jsonl").open("w", encoding="utf-8")
        self._answers: dict[Group, Counter[str]] = {}
        write_atomically(folder / "recipe.json", recipe.model_dump_json(indent=1) + "\n")

    def add(self, result: DrawResult) -> None:
        """Write the result of a job."""
        refused, keys, kept = list(result.refused), set[str](), list[Item]()
        for item in result.items:
            if reason := self._reason(item, keys, kept):
                keys.add(item.key)
                refused.append({"key": item.key, "stage": "item", "why": [reason], "drawn": item.row["drawn"]})
            else:
                self._write(item)
                kept.append(item)
        for row in refused:
            self.tally.refused[row["stage"]] += 1
            self._refused.write(json.dumps(row, ensure_ascii=False) + "\n")
        self.tally.done += 1

    def _reason(self, item: Item, refused: set[str], kept: Sequence[Item]) -> str:
        """Return why to refuse an item, given earlier ones of the job; empty to keep it."""
        row = item.row
        if item.key in self._dropped:
            return f"review: {self._dropped[item.key] or 'dropped'}"
        if {row["same_physics_as"], row.get("counterfactual_of")} & refused:
            return "pair: the item that it belongs to is refused"
        if row["same_physics_as"] is None:
            # A counterfactual without an effect is kept: that is information, too.
            base, split = row.get("counterfactual_of"), self._splits[row["source"]]
            twin = self._likeness.twin(item.key, row["case"], split, item.folder / "states.npz", base)
            return f"duplicate: moves like {twin}" if twin else ""
        twin = same_film(item, [i for i in kept if row["same_physics_as"] in (i.key, i.row["same_physics_as"])])
        return f"duplicate: looks like {twin}" if twin else ""

    def close(self) -> None:
        """Complete all files. Questions come last, because all items decide which can be balanced."""
        self._asked.close()
        with Path(self._asked.name).open(encoding="utf-8") as lines:
            rows = (json.loads(line) for line in lines)
            for row in balanced_questions(rows, self._answers, self._recipe.seed):
                self._write_rows("questions", row.pop("split"), [row])
        Path(self._asked.name).unlink()
        for file in (*self._tables.values(), *self._shards.values(), *self._robots.values(), self._refused):
            file.close()

    def _write(self, item: Item) -> None:
        split = self._splits[item.row["source"]]
        if split not in self._shards:
            self._shards[split] = ShardWriter(self._folder / "shards", split, 1e6 * self._recipe.shard_mb)
        item.row["split"] = split
        item.row["scores"] = [*item.row["scores"], *self._scores.get(item.row["sim_digest"], [])]
        extra = {"json": json.dumps(item.row).encode()}
        item.row["shard"] = self._shards[split].add(item.key, item.folder, extra)
        if (form := robot_form(item)) is not None:
            self._robot(f"{split}-{item.row['source']}-{item.row['case']}", form).add(item)
        self._write_rows("items", split, [item.row])
        self._write_rows("frames", split, item.frames)
        for row in item.questions:
            self._asked.write(json.dumps({"split": split, "case": item.row["case"], **row}) + "\n")
            group = split, item.row["case"], row["question"]
            self._answers.setdefault(group, Counter())[row["right"]] += 1
        self.tally.items[split] += 1

    def _robot(self, name: str, form: RobotForm) -> RobotWriter:
        """The writer for episodes of a case; each form gets its own folder."""
        if (name, form) not in self._robots:
            count = sum(other == name for other, _ in self._robots)
            folder = self._folder / "lerobot" / (f"{name}-{count + 1}" if count else name)
            self._robots[name, form] = RobotWriter(folder, form)
        return self._robots[name, form]

    def _write_rows(self, table: str, split: str, rows: list[dict[str, Any]]) -> None:
        if (table, split) not in self._tables:
            path = self._folder / table / f"{split}-00000.parquet"
            self._tables[table, split] = TableWriter(path, table)
        self._tables[table, split].add(rows)
        self.tally.tables.setdefault(table, Counter())[split] += len(rows)


def _main_reason(path: Path) -> str:
    """The most frequent reason for refusals."""
    with path.open(encoding="utf-8") as lines:
        reasons = Counter(why for line in lines for why in json.loads(line)["why"])
    return reasons.most_common(1)[0][0] if reasons else "there was nothing to do"
