"""What is expensive is refused to tests that have no fixture for it; in every process that tests begin.

A test may start the engine, the path tracer, a browser or npm only through the fixture of that name (`conftest.py`), which
is also what marks it. This file stands as `sitecustomize.py` in a folder on PYTHONPATH, so that Python imports it at its
start in child processes, too, whose environment is cleaned of everything else. Beside it lies `allowed`, what the running
test may start, and `refused`, to which a refusal is written, because a program may well live with one.
"""

import importlib.abc
import importlib.machinery
import os
import sys
from pathlib import Path

MODULES = {"genesis": "engine", "mitsuba": "tracer"}
PROGRAMS = {
    **dict.fromkeys(("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome"), "browser"),
    **dict.fromkeys(("node", "npm", "npx"), "npm"),
}
FOLDER = Path(__file__).parent


def need(kind: str, what: str) -> None:
    """Refuse something that the running test has no fixture for.

    Raises:
        ImportError: if it has none.
    """
    try:
        allowed = (FOLDER / "allowed").read_text().split()
    except OSError:  # a process that outlives the tests
        return
    if kind in allowed:
        return
    words = f"{what} was started by a test without the fixture `{kind}`"
    with (FOLDER / "refused").open("a") as file:
        file.write(words + "\n")
    raise ImportError(words)


class Refusing(importlib.abc.Loader):
    """Asks before it loads a module; looking for the module costs nothing and is free."""

    def __init__(self, kind: str, loader: importlib.abc.Loader) -> None:
        self.kind, self.loader = kind, loader

    def create_module(self, spec: importlib.machinery.ModuleSpec):
        return self.loader.create_module(spec)

    def exec_module(self, module) -> None:
        need(self.kind, f"the module {module.__name__}")
        module.__spec__.loader = module.__loader__ = self.loader
        self.loader.exec_module(module)


class Guard(importlib.abc.MetaPathFinder):
    """Finds the modules that are expensive to load."""

    def find_spec(self, fullname, path=None, target=None):
        kind = MODULES.get(fullname)
        spec = importlib.machinery.PathFinder.find_spec(fullname, path, target) if kind else None
        if kind and spec is not None and spec.loader is not None:
            spec.loader = Refusing(kind, spec.loader)
        return spec


def watch_spawning(event: str, arguments: tuple) -> None:
    """Refuse programs, as an audit hook."""
    if event == "subprocess.Popen":
        name = os.path.basename(os.fsdecode(arguments[0] or arguments[1][0]))
        if name in PROGRAMS:
            need(PROGRAMS[name], f"the program {name}")


if (FOLDER / "allowed").exists():
    sys.meta_path.insert(0, Guard())
    sys.addaudithook(watch_spawning)
