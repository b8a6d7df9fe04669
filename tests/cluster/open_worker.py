"""A worker that calls functions of this file, without simulating."""

import os
import signal
import time
from pathlib import Path

from text2sim.cluster import task, worker
from text2sim.cluster.task import TaskPlace
from text2sim.spec_schema.errors import RunError

task.PACKAGE = ""


def write(place: TaskPlace, text: str) -> dict:
    """Write a file."""
    (place.output / "said.txt").write_text(text)
    return {"pid": os.getpid()}


def die(place: TaskPlace, times: int) -> dict:
    """Die as often as that, then live."""
    deaths = len(list(place.output.glob("death*")))
    if deaths < times:
        (place.output / f"death{deaths}").touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return {"deaths": deaths}


def refuse(place: TaskPlace) -> dict:
    """Fail in a way that the user can mend."""
    raise RunError("there is no ball")


def wait(place: TaskPlace, mark: str) -> dict:
    """Wait for a request to stop."""
    (place.output / mark).write_text(str(os.getpid()))
    while not place.stop.count:
        time.sleep(0.05)
    return {"stopped": True}


def note(place: TaskPlace, log: str, word: str, wait: bool) -> dict:
    """Write down who did what, and wait, if told to, until there is a file `<log>.go`."""
    with open(log, "a") as file:
        file.write(f"{word} {os.getpid()}\n")
    while wait and not Path(f"{log}.go").exists():
        time.sleep(0.05)
    (place.output / word).write_text(word)
    return {"word": word}


if __name__ == "__main__":
    assert Path(__file__).name == "open_worker.py"
    worker.main()
