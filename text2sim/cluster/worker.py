"""Worker that runs one task after another, with an engine that stays warm between them.

Each line of the standard input is an order, `{"order": 1, "function": …}`, or `{"cancel": 1}`, after which no task
begins; the end of the input ends the process. Each line of the standard output is a message.
"""

import json
import os
import queue
import sys
import threading
import traceback
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from text2sim.cluster.task import TaskPlace, call_task
from text2sim.runtime.stop import Stop
from text2sim.spec_schema.errors import MachineError, Text2SimError

STOP_GRACE = 30.0
"""Time [s] that a task has to end after the end of the input."""


class Worker:
    """Runs tasks; `folder` is for the engine's log, and `warm` keeps an engine warm."""

    def __init__(self, folder: Path, *, warm: bool) -> None:
        from text2sim.runtime.program import run_program
        from text2sim.runtime.warm_runner import WarmRunner

        os.environ.setdefault("QD_NUM_THREADS", "1")  # the others need the other cores
        self._warm = WarmRunner(folder) if warm else None
        self._runner = self._warm or run_program
        self.stop = Stop()
        """Requests to stop, after which no task begins."""

    def perform(self, order: Mapping[str, Any]) -> dict[str, Any]:
        """Run a task, and return its `result`, or its `error`."""
        inputs = {name: Path(path) for name, path in order["inputs"].items()}
        try:
            place = TaskPlace(inputs, Path(order["output"] or "."), self.stop, self._runner)
            return {"result": call_task(order, place)}
        except (Text2SimError, OSError) as error:
            return {"error": str(error), "machine": isinstance(error, MachineError | OSError)}
        except Exception as error:
            traceback.print_exc()
            return {"error": f"{type(error).__name__}: {error}", "bug": True}

    def close(self) -> None:
        """End the engine."""
        if self._warm is not None:
            self._warm.close()


def main() -> None:
    """Run orders until the input ends."""
    news = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    orders: queue.Queue[dict[str, Any] | None] = queue.Queue()
    worker = Worker(Path(sys.argv[1]), warm="warm" in sys.argv[2:])

    def listen() -> None:
        for line in sys.stdin:
            order = json.loads(line)
            if "cancel" in order:
                worker.stop.request()
            else:
                orders.put(order)
        orders.put(None)
        worker.stop.request()
        timer = threading.Timer(STOP_GRACE, os._exit, (1,))
        timer.daemon = True
        timer.start()

    threading.Thread(target=listen, name="orders", daemon=True).start()
    print(json.dumps({"ready": True}), file=news, flush=True)
    while (order := orders.get()) is not None:
        print(json.dumps({"order": order["order"], **worker.perform(order)}), file=news, flush=True)
    worker.close()


if __name__ == "__main__":
    main()
