"""One process of a benchmark: time the loop of a program, recorded or bare. Prints seconds and frames as JSON."""

import json
import sys
import time
from pathlib import Path

program, mode, steps, out = Path(sys.argv[1]), sys.argv[2], int(sys.argv[3]), Path(sys.argv[4])
sys.path.insert(0, str(program))

import bodies as bodies_module  # noqa: E402
import genesis as gs  # noqa: E402
import main  # noqa: E402
from actions import Actions  # noqa: E402
from recorder import Recorder  # noqa: E402
from scene import DT, RECORD_EVERY, start_engine  # noqa: E402

start_engine(gs.cpu)
scene, bodies, _ = main.assemble(with_cameras=False)
actions = Actions(scene, bodies)
if mode == "recorded":
    deforming = {"deformables": bodies_module.DEFORMABLES} if hasattr(bodies_module, "DEFORMABLES") else {}
    recorder = Recorder(scene, bodies, out, DT, RECORD_EVERY, steps * DT, speed_limit=1e3, **deforming)
    recorder.start()
    began, cpu = time.perf_counter(), time.process_time()
    for step in range(steps):
        actions.before_step(step)
        scene.step()
        recorder.after_step(step + 1)
    recorder.close("finished")
else:
    began, cpu = time.perf_counter(), time.process_time()
    for step in range(steps):
        actions.before_step(step)
        scene.step()
print(json.dumps({"seconds": time.perf_counter() - began, "cpu": time.process_time() - cpu}))
