"""Modules of programs, loaded without the engine."""

import importlib.util
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import text2sim.templates


def load_module(name: str, **missing: Any) -> ModuleType:
    """Return a module of `text2sim/templates` as a program has it.

    Args:
        name: Its name.
        missing: What stands for modules that it imports and that cannot be imported here, by name.
    """
    path = Path(text2sim.templates.__path__[0]) / f"{name}.py"
    spec = importlib.util.spec_from_file_location(f"{name}_of_a_program", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    missing = {name: stand_in for name, stand_in in missing.items() if name not in sys.modules}
    sys.modules.update(missing)
    try:
        spec.loader.exec_module(module)
    finally:
        for name in missing:
            del sys.modules[name]
    return module
