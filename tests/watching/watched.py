"""A watched case, with processes that only speak the protocol."""

import json
import threading
import time
from pathlib import Path
from typing import Any

from text2sim.service.examined import examine
from text2sim.spec_schema.errors import Problem
from text2sim.watching.live_run import LiveRun
from text2sim.watching.page_state import PageState
from text2sim.watching.protocols import Checked
from text2sim.watching.session import Options, WatchSession

CASE = """\
text2sim: 2
name: drop
prompt: A ball falls.
scene: {duration: 0.4, statics: {floor: {shape: {kind: plane}}}}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 1.5]}, look: {color: red}}
actions:
  measures: {height: {kind: position, of: ball, axis: z}}
  expect: {falls: {measure: height, at: end, below: 1.2}}
"""


class Watched:
    """A case that is being watched, and what was said about it."""

    def __init__(self, folder: Path, text: str = CASE, **options: Any) -> None:
        self.file = folder / "drop" / "case.yaml"
        self.file.parent.mkdir()
        self.file.write_text(text)
        self.runs = folder / "watch-drop"
        self.runs.mkdir()
        self.state = PageState(case="drop", file="case.yaml")
        self.said: list[tuple[str, Any]] = []
        """What the listener was told, in order."""
        self.stops = 0
        options = {"engine": "fake_engine", **options}
        self.session = WatchSession(
            self.file, self.runs, lambda: examine(self.file), self.state, self, Options(**options)
        )
        self._thread = threading.Thread(target=self.session.run, args=(lambda: self.stops,))

    def start(self) -> "Watched":
        self._thread.start()
        return self

    def stop(self) -> None:
        self.stops += 1
        self._thread.join(30)
        assert not self._thread.is_alive()

    def save(self, *changes: tuple[str, str]) -> None:
        """Save the text with changes to it, in the way of most editors."""
        text = self.file.read_text()
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        part = self.file.with_name("case.yaml.tmp")
        part.write_text(text)
        part.replace(self.file)

    def wait(self, kind: str, after: int = 0, timeout: float = 20.0) -> Any:
        """Wait until something of a kind was said after the first `after` things; return it."""
        until = time.monotonic() + timeout
        while time.monotonic() < until:
            for name, value in self.said[after:]:
                if name == kind:
                    return value
            time.sleep(0.005)
        raise AssertionError(f"no {kind} in {self.said[after:]} after {self.said[:after]}")

    def content(self) -> dict[str, Any]:
        return json.loads(self.state.read()[1])

    # As a listener.

    def checked(self, case: Checked, seconds: float) -> None:
        self.said.append(("checked", [problem.rule for problem in case.problems]))

    def status(self, words: str) -> None:
        self.said.append(("status", words))

    def trouble(self, words: str, problem: Problem | None) -> None:
        self.said.append(("trouble", (words, problem)))

    def done(self, take: LiveRun, evidence: dict[str, Any] | None, no_scene: str) -> None:
        done = {"take": take.number, "state": take.state, "what": set(take.seconds), "no_scene": no_scene}
        found = {name: row["ok"] for name, row in (evidence or {}).get("expect", {}).items()}
        self.said.append(("done", {**done, "expect": found}))
