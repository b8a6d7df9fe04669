"""Programs that are simulated one after the other in the warm engine of `text2sim watch`.

A second rigid scene in a process builds in a fraction of a second, the first takes ten.
"""

import json
import select
import subprocess
import sys
from pathlib import Path

import pytest

from text2sim import templates
from text2sim.runtime.warm_engine import MODULE

PATIENCE = 540.0
"""Longest wait [s] for one program: a bare machine compiles the engine's kernels on the way."""


class WarmEngine:
    """A process for each precision of numbers; a crash costs one program, and the next one starts it anew."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._processes: dict[str, subprocess.Popen[str]] = {}
        self._orders = 0

    def run(self, program: Path, out: Path) -> None:
        """Simulate the program in one folder and let it write into another; fail the test if it does not finish."""
        precision = "64" if 'precision="64"' in (program / "scene.py").read_text() else "32"
        process = self._processes.get(precision) or self._start(precision)
        assert process.stdin is not None
        self._orders += 1
        order = {"order": self._orders, "program": str(program), "out": str(out)}
        try:
            process.stdin.write(json.dumps(order) + "\n")
            process.stdin.flush()
            news = self._end_of(process)
        except (EOFError, BrokenPipeError, TimeoutError) as error:
            process.kill()
            process.wait()
            del self._processes[precision]
            log = self._log(precision).read_text()[-3000:]
            pytest.fail(f"the engine {error or 'died'} (rc {process.returncode}):\n{log}")
        if news["state"] != "finished":
            pytest.fail(f"{program} ended as {news['state']}: {news.get('traceback', news['message'])}")

    def stop(self) -> None:
        """End the processes; where they end by themselves, they keep the kernels that they compiled."""
        for process in self._processes.values():
            assert process.stdin is not None
            process.stdin.close()
        for process in self._processes.values():
            try:
                process.wait(60)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self._processes.clear()

    def _end_of(self, process: subprocess.Popen[str]) -> dict:
        assert process.stdout is not None
        while True:
            ready, _, _ = select.select([process.stdout], [], [], PATIENCE)
            if not ready:
                raise TimeoutError(f"said nothing for {PATIENCE:g} s")
            line = process.stdout.readline()
            if not line:
                raise EOFError
            news = json.loads(line)
            if news.get("order") == self._orders and "state" in news:
                return news

    def _log(self, precision: str) -> Path:
        return self._folder / f"engine_{precision}.log"

    def _start(self, precision: str) -> subprocess.Popen[str]:
        command = [sys.executable, "-P", "-m", MODULE, str(Path(templates.__file__).parent), "live"]
        self._processes[precision] = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._log(precision).open("a"), text=True
        )
        return self._processes[precision]
