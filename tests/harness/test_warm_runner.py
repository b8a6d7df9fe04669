"""The warm engine where it is hard for it to start."""

import os
import queue
from contextlib import suppress
from pathlib import Path
from time import monotonic, sleep
from typing import Any

import pytest

from text2sim.runtime import warm_engine
from text2sim.runtime.child import Limits
from text2sim.runtime.progress import Clock
from text2sim.runtime.stop import Stop
from text2sim.runtime.warm_engine import Engine
from text2sim.runtime.warm_runner import WarmRunner
from text2sim.spec_schema.errors import EngineError


def test_an_engine_that_waits_for_a_processor_is_waited_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(warm_engine, "START_LIMIT", 1.5)
    monkeypatch.setattr(warm_engine, "EXTRA_WALL_TIME", 3.0)
    (tmp_path / "slow_engine.py").write_text("import sys\nsys.stdin.read()\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    engine = Engine(tmp_path, queue.Queue(), 10**10, "slow_engine")
    engine.start()
    begun = monotonic()
    while monotonic() < begun + 3.0:
        engine.guard()
        assert not engine.ended
        sleep(0.1)
    sleep(max(0.0, begun + 4.6 - monotonic()))
    engine.guard()
    assert engine.ended, "but not forever"


def test_an_engine_that_does_not_start_is_no_fault_of_the_case(tmp_path: Path) -> None:
    (tmp_path / "program").mkdir()
    (tmp_path / "program" / "scene.py").write_text("")
    runner = WarmRunner(tmp_path)
    runner._engine._module = "text2sim.no_such_module"
    for _ in range(2):
        with pytest.raises(EngineError, match="the engine does not start"):
            runner(tmp_path, flags=("--no-film",), limits=Limits(), stop=Stop(), clock=Clock(lambda _: None, 1.0))


def test_an_engine_that_was_started_early_and_never_needed_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "idle_engine.py").write_text("import sys\nsys.stdin.read()\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    runner = WarmRunner(tmp_path)
    runner._engine._module = "idle_engine"
    runner.start()
    child = runner._engine._child
    runner.start()
    assert runner._engine._child is child, "one engine, however often it is asked to start"
    begun = monotonic()
    runner.close()
    assert runner._engine.ended and monotonic() - begun < 5.0


BUILDS = """
import json, sys, time
print(json.dumps({"ready": True, "memory": 1}), flush=True)
order = json.loads(sys.stdin.readline())
print(json.dumps({"order": order["order"], "phase": "build"}), flush=True)
time.sleep(600)
"""


@pytest.mark.parametrize("live", [False, True])
def test_a_build_that_is_asked_to_stop_is_waited_for_only_if_somebody_edits(
    live: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(warm_engine, "STOP_LIMIT", 0.3)
    (tmp_path / "building_engine.py").write_text(BUILDS)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    inbox: queue.Queue[Any] = queue.Queue()
    engine = Engine(tmp_path, inbox, 10**10, "building_engine", live=live)
    engine.start()
    result, until = None, monotonic() + 20.0
    while result is None and monotonic() < until:
        if engine.idle:
            engine.simulate(1, tmp_path, tmp_path, 100.0)
        with suppress(queue.Empty):
            news = inbox.get(timeout=0.05)
            engine.receive(news.child, news.data)
        if engine.job is not None and engine.job.begun and engine.job.cancelled is None:
            engine.cancel()
            until = monotonic() + 2.0
        result = engine.guard()
    engine.kill()
    assert (result or {}).get("state") == (None if live else "interrupted")
