"""Runs compiled programs one after the other in one process, through their own functions.

A second rigid scene in a process builds in a fraction of a second, the first takes ten. Every line of the standard
input is an order, `{"program": folder, "out": folder}`; every line of the standard output an answer, `{"error": null}`
or a traceback, with `cpu`, the processor seconds of the simulation. What the engine prints goes to the standard error.
"""

import importlib
import json
import os
import sys
import time
import traceback
from pathlib import Path


def fresh_main(program: str):
    """Import the program in a folder as if no other had been imported before; some of its modules come later."""
    for module in Path(program).glob("*.py"):
        sys.modules.pop(module.stem, None)
    importlib.invalidate_caches()
    sys.path[0] = program
    return importlib.import_module("main")


def main() -> None:
    """Serve orders until the input ends."""
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    sys.dont_write_bytecode = True
    sys.path.insert(0, "")
    started = False
    for line in sys.stdin:
        order = json.loads(line)
        error, began = None, time.process_time()
        try:
            program = fresh_main(order["program"])
            if not started:
                program.start_engine(program.gs.cpu)
                started = True
            scene, bodies, _ = program.assemble(with_cameras=False)
            began = time.process_time()
            program.simulate(scene, bodies, Path(order["out"]))
        except Exception:
            error = traceback.format_exc()
        answers.write(json.dumps({"error": error, "cpu": time.process_time() - began}) + "\n")
        answers.flush()


if __name__ == "__main__":
    main()
