"""The process that keeps Genesis warm: it simulates one freshly compiled program after the other.

The first scene of a process takes ten seconds or more, to import and to load kernels; the next takes a tenth of a
second to build. A program records the same, bit for bit, as in a process of its own.

Every line of the standard input is an order, `{"order": 1, "program": folder, "out": folder}`, or `{"cancel": 1}`; the
end of the input ends the process. Every line of the standard output is news. What the engine prints goes to the
standard error. Nothing here needs text2sim: programs contain all that they use.
"""

import gc
import importlib
import json
import os
import queue
import sys
import threading
import traceback
from pathlib import Path
from typing import Any

FRAMES_PER_CHUNK = 20
"""Recorded frames in a chunk, small enough for the page to show them before the end."""
STOP_GRACE = 5.0
"""Time [s] that a simulation has to stop when the input has ended."""
_KEPT_MODULES = frozenset({"engine"})
"""Modules of programs that are not reloaded, since kernels refer to the functions in them."""


class Warm:
    """Genesis, imported and with its kernels loaded."""

    def __init__(self, templates: Path, *, live: bool) -> None:
        import genesis

        self._gs: Any = genesis
        self._live = live
        self._started = False
        self._kept: dict[Any, Any] = {}
        self._path: str | None = None
        # The file of a kernel's function must stay readable, and programs come and go: theirs are copies of this one.
        sys.path.insert(0, str(templates))
        importlib.import_module("engine")
        sys.path.remove(str(templates))
        _skip_tracebacks()
        _keep_shapes()
        if live:  # what is written here is read within a second, and need not survive a power cut
            os.fsync = lambda fd: None

    def load(self, folder: Path) -> Any:
        """Import the program in a folder, as if no other had been imported before; return its main module."""
        names = {path.stem for path in folder.glob("*.py")} - _KEPT_MODULES
        for name in names:
            sys.modules.pop(name, None)
        importlib.invalidate_caches()
        if self._path is not None:
            sys.path.remove(self._path)
        self._path = str(folder)  # stays until the next: some modules are imported only when they are needed
        sys.path.insert(0, self._path)
        program = importlib.import_module("main")
        if self._live:
            sys.modules["recorder"].FRAMES_PER_CHUNK = FRAMES_PER_CHUNK  # type: ignore[attr-defined]
        return program

    def start(self, program: Any) -> None:
        """Start the engine for a program; for later programs, only the seed is set."""
        program.start_engine(self._gs.cpu)
        if not self._started:
            self._started = True
            self._gs.init = _reinitialise

    def forget(self, scene: Any | None) -> None:
        """Release a scene that was simulated, but not what makes the next one fast."""
        for solver in scene.sim.solvers if scene is not None else ():
            collider = getattr(solver, "collider", None)
            for holder in (solver, collider, getattr(collider, "gjk", None)):
                for value in list(vars(holder).values()) if holder is not None else ():
                    if type(value).__name__.endswith("StaticConfig"):
                        # A kernel is found again by a weak reference to the first of equal configurations.
                        self._kept.setdefault((type(value), value), value)
        _empty_dispatchers()


def _reinitialise(*, seed: int | None = None, **options: Any) -> None:
    """Stand in for `gs.init`, which may be called once in a process: all programs give it the same options."""
    from genesis.utils.misc import set_random_seed

    if seed is not None:
        set_random_seed(seed)


def _skip_tracebacks() -> None:
    """Keep quadrants from making a traceback for every array of a scene, which takes half the time of a build."""
    for name, module in list(sys.modules.items()):
        if name.startswith("quadrants") and hasattr(module, "get_traceback"):
            module.get_traceback = lambda stacklevel=1: ""  # type: ignore[attr-defined]


def _keep_shapes() -> None:
    """Keep what was computed for the shapes of the last scene only, since the next is much like it."""
    from genesis.utils import cache

    cache.enable_owned_cache_release()  # releases what no scene uses any more
    cache.disable_owned_cache_release()


def _empty_dispatchers() -> None:
    """Release the arrays of past scenes, which a dispatcher keeps with the kernels that it chose for them."""
    from genesis.engine.solvers.rigid.constraint import solver

    dispatcher = solver.func_solve_body
    for name, value in vars(dispatcher).items():
        if name.endswith("_by_geometry_hash") and isinstance(value, dict):
            value.clear()
    dispatcher._first_eval_completed.clear()
    dispatcher._cached_args = dispatcher._cached_kwargs = dispatcher._cached_impl = None


class CommandLoop:
    """Takes orders from the standard input, and sends news to the standard output."""

    def __init__(self) -> None:
        self._news = os.fdopen(os.dup(1), "w", encoding="utf-8")
        os.dup2(2, 1)
        self._cancelled: set[int] = set()
        self._running: tuple[int, list[int]] | None = None
        self._lock = threading.Lock()
        self.started = False
        """Whether the engine has been imported."""
        self.orders: queue.Queue[dict[str, Any] | None] = queue.Queue()
        """Orders to carry out; None at the end."""
        threading.Thread(target=self._listen, name="orders", daemon=True).start()

    def tell(self, **news: Any) -> None:
        """Report something."""
        self._news.write(json.dumps(news) + "\n")
        self._news.flush()

    def begin(self, order: int, signals: list[int]) -> None:
        """Say which order is being carried out; a number in `signals` stops it at the next step."""
        with self._lock:
            self._running = (order, signals)
            if order in self._cancelled:
                signals.append(0)

    def end(self) -> None:
        """Say that nothing is being carried out."""
        with self._lock:
            self._running = None

    def _listen(self) -> None:
        for line in sys.stdin:
            order = json.loads(line)
            if "cancel" in order:
                self._cancel(order["cancel"])
            else:
                self.orders.put(order)
        # Whoever gave the orders is gone.
        if not self.started:
            os._exit(0)
        self.orders.put(None)
        with self._lock:
            if self._running is None:
                return  # the process saves the kernels that it compiled as it ends: give it time
            self._running[1].append(0)
        timer = threading.Timer(STOP_GRACE, os._exit, (1,))  # for a step that never ends
        timer.daemon = True
        timer.start()

    def _cancel(self, order: int) -> None:
        with self._lock:
            self._cancelled.add(order)
            if self._running is not None and self._running[0] == order:
                self._running[1].append(0)


def _simulate(warm: Warm, commands: CommandLoop, order: dict[str, Any]) -> dict[str, Any]:
    """Carry out an order; return its result."""
    number, folder, out = order["order"], Path(order["program"]), Path(order["out"])
    scene, program = None, None
    answer: dict[str, Any] = {"state": "finished"}
    try:
        commands.tell(order=number, phase="build")
        program = warm.load(folder)
        commands.begin(number, program.signals)
        warm.start(program)
        scene, bodies, _ = program.assemble(with_cameras=False)
        _keep_shapes()
        commands.tell(order=number, phase="simulate")
        program.simulate(scene, bodies, out)
    except Exception as error:
        answer = _failure(error, program)
    except KeyboardInterrupt:
        answer = {"state": "interrupted", "message": "stopped from outside"}
    finally:
        commands.end()
    warm.forget(scene)
    status = {key: answer[key] for key in ("state", "message", "where") if key in answer}
    (out / "status.json").write_text(json.dumps(status, indent=1) + "\n")
    return answer


def _failure(error: Any, program: Any | None) -> dict[str, Any]:
    if program is not None and isinstance(error, program.Divergence):
        where = {"body": error.body, "quantity": error.quantity, "time": error.time}
        return {"state": "diverged", "message": str(error), "where": where}
    message = f"{type(error).__name__}: {error}"
    return {"state": "failed", "message": message, "traceback": traceback.format_exc()}


def main() -> None:
    """Carry out orders until the input ends."""
    sys.dont_write_bytecode = True
    commands = CommandLoop()
    warm = Warm(Path(sys.argv[1]), live="live" in sys.argv[2:])
    commands.started = True
    commands.tell(ready=True, memory=_memory())
    first = True
    while (order := commands.orders.get()) is not None:
        gc.disable()
        answer = _simulate(warm, commands, order)
        commands.tell(order=order["order"], **answer)
        # Now, when nobody waits.
        gc.enable()
        gc.collect()
        if first:  # the engine's own objects need not be searched again
            gc.freeze()
            first = False
        commands.tell(memory=_memory())


def _memory() -> int:
    """Return the resident memory of this process [bytes]."""
    import psutil

    return psutil.Process().memory_info().rss


if __name__ == "__main__":
    main()
