"""View of a loop of agents: one line for each event, and on a terminal a status line."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from text2sim.cli.check import LONG_RUN
from text2sim.cli.output import say
from text2sim.runtime.progress import duration_text
from text2sim.spec_schema.plain import plain, plain_line

if TYPE_CHECKING:
    from rich.status import Status

    from text2sim.agents.journal import Listener
    from text2sim.agents.loop_result import LoopOutcome
    from text2sim.agents.session import Session

TITLES = {
    "reader": "Reader", "planner": "Planner", "scene": "Scene Writer", "bodies": "Body Writer",
    "actions": "Action Writer", "render": "Render Writer", "articulation": "Articulation agent", "mesh": "Mesh agent",
    "critic": "Critic", "viewer": "Visual Judge", "distiller": "Distiller",
}  # fmt: skip
LONG = 160


@contextmanager
def progress_view(name: str, *, quiet: bool = False) -> Iterator["Listener"]:
    """Yield a listener that shows the events of a loop."""
    if quiet:
        yield lambda event, what: None
    elif sys.stderr.isatty():
        from rich.console import Console
        from rich.status import Status

        with Status(f"{name}: working", console=Console(stderr=True)) as status:
            yield _View(name, status)
    else:
        yield _View(name)


class _View:
    """Printer of one line for each event, and of what the loop is waiting for, if there is a status line."""

    def __init__(self, name: str, status: "Status | None" = None) -> None:
        self.name, self.status = name, status
        self.waiting: dict[str, None] = {}
        self.doing = ""

    def __call__(self, event: str, what: dict[str, Any]) -> None:
        if event == "asked":
            self.waiting[what["role"]] = None
        elif event == "answered":
            self.waiting.pop(what["role"], None)
        elif event == "running":
            self.doing = "simulating"
        elif event == "progress":
            duration = f" {what['t']:.2f} of {what['duration']:g} s" if what.get("t") else ""
            self.doing = f"{what['phase']}{duration}"
        elif event == "ran":
            self.doing = ""
        for line in _lines(event, what):
            if self.status is not None:
                self.status.console.print(plain(line), markup=False, highlight=False)
            else:
                say(line, to=sys.stderr)
                sys.stderr.flush()
        if self.status is not None:
            asked = ", ".join(TITLES.get(role, role) for role in self.waiting)
            doing = f"waiting for the {asked}" if asked else self.doing or "working"
            self.status.update(plain_line(f"{self.name}: {doing}"))


def _lines(event: str, what: dict[str, Any]) -> list[str]:
    if event == "planned":
        rows = [f"plan: {what['goal']}"] if what["possible"] != "no" else [f"cannot be done: {what['why']}"]
        rows += [f"  assumed: {row}" for row in what["assumptions"]]
        return rows + [f"  expected: {row} ({name})" for name, row in what["says"].items()]
    if event == "requirements":
        return [f"  required: {row} ({name})" for name, row in what["rows"].items()]
    if event == "answered":
        cost = f"{what['tokens']:,} tokens, {duration_text(what['seconds'])}"
        return [f"  {TITLES.get(what['role'], what['role'])} answered ({cost})"]
    if event == "answer_refused":
        return [f"  {TITLES.get(what['role'], what['role'])} is asked again: {_shortened(what['reasons'][0])}"]
    if event == "attempt":
        return [
            f"attempt {what['number']}: {_shortened(what['cause'])}",
            *(f"  changed: {_shortened(row)}" for row in what["changes"][:6]),
        ]
    if event == "refined":
        return [f"  changed: {_shortened(row)}" for row in what["changes"]]
    if event in ("mending", "unsound"):
        word = "to fix" if event == "mending" else "cannot be run"
        return [f"  {word}: {_shortened(row)}" for row in what["problems"][:6]]
    if event == "running" and what.get("seconds", 0) >= LONG_RUN:
        return [f"  simulating: about {duration_text(what['seconds'])} on two idle cores, within a factor of three"]
    if event == "ran":
        marks = {True: "ok", False: "FAIL", None: "open"}
        return [f"  run {what['state']}", *(f"    {marks[ok]:4}  {name}" for name, ok in what["expect"].items())]
    if event == "judged":
        rows = [f"  Critic: {what['verdict']}, {what['score']:g} of 100{', accepted' if what['accepted'] else ''}"]
        return rows + [f"    {_shortened(row)}" for row in what["failures"][:5]]
    if event == "decided":
        rows = [f"  Planner: {what['action']}: {_shortened(what['why'])}"]
        rows += [f"    takes patch {k}" for k in what["take"]]
        return rows + [f"    {TITLES[section]}: {_shortened(text)}" for section, text in what["routes"].items()]
    if event == "trials":
        return [f"  trial {_shortened(row.removeprefix('- '))}" for row in what["rows"]]
    if event == "viewed":
        marks = ", ".join(f"{name} {mark:g}" for name, mark in what["marks"].items())
        rows = [f"  film `{what['treatment']}`: {what['total']:g} of 100 ({marks})"]
        return rows + [f"    against the request: {_shortened(row)}" for row in what.get("broken", ())]
    if event == "styled":
        return [f"  filmed as `{what['treatment']}`, {what['total']:g} of 100"]
    if event in ("not_styled", "treatments_failed"):
        return [f"  film: {_shortened(what['why'])}"]
    if event == "restated":
        return [f"  restated: {_shortened(what['what'])}"]
    if event == "cards":
        return [f"  cards for the {TITLES.get(what['role'], what['role'])}: {', '.join(what['cards'])}"]
    return []


def say_outcome(session: "Session", outcome: "LoopOutcome") -> None:
    """Print the outcome of a loop, its cost, and the paths of its files."""
    say("")
    say(f"{outcome.state.replace('_', ' ')}: {outcome.why}")
    for row in outcome.unresolved:
        say(f"  unresolved: {_shortened(row)}")
    table = session.account.table()
    wide = [max(len(row[k]) for row in table) for k in range(len(table[0]))]
    say("")
    for row in table:
        say("  ".join(f"{cell:<{wide[0]}}" if not k else f"{cell:>{wide[k]}}" for k, cell in enumerate(row)))
    if outcome.best is not None:
        say("")
        say(f"case: {session.case / 'case.yaml'} (attempt {outcome.best.number})")
        if outcome.best.run:
            run = session.case / outcome.best.run
            say(f"report: {run / 'report.html'}")


def _shortened(text: str) -> str:
    line = " ".join(str(text).split())
    return line if len(line) <= LONG else line[: LONG - 1] + "…"
