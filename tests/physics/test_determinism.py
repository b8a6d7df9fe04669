"""The same program gives the same bytes, whatever ran before it in the process, and in a process of its own."""

import subprocess
import sys
from pathlib import Path

LIVELY = """
scene: {duration: 1.0, dt: 0.01, statics: {floor: {shape: {kind: plane}}}}
bodies:
  block: {kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, repeat: {kind: packing, count: 12, region: {kind: box, min: [-0.3, -0.3, 0.1], max: [0.3, 0.3, 0.8]}, seed: 3}}
  can: {kind: rigid, shape: {kind: cup, radius: 0.1, height: 0.15, thickness: 0.01}, pose: {pos: [0.8, 0, 0.2], euler_deg: [30, 20, 10]}}
  chain: {kind: chain, links: 4, link_length: 0.1, radius: 0.02, direction: x, pose: {pos: [0, 0, 1.2]}}
  door: {kind: rigid, shape: {kind: box, size: [0.4, 0.04, 0.5]}, pose: {pos: [0, -0.8, 0.3]}, mount: {kind: hinge, axis: z, anchor: [-0.2, 0, 0], actuator: {stiffness: 20, damping: 2}}}
  lift: {kind: driven, shape: {kind: box, size: [0.2, 0.2, 0.05]}, pose: {pos: [-0.8, 0, 0.1]}, motion: {kind: oscillate, axis: z, amplitude: 0.05, frequency: 2}}
actions:
  controls:
    open: {kind: drive, joint: door, position: {kind: ramp, from: 0, to: 1, start: 0, end: 0.5}}
    throw: {kind: initial_velocity, body: can, linear: [-2, 0, 0], angular: [1, 2, 3]}
    glue: {kind: attach, body: "block[0]", to: "block[1]", at: 0.3}
"""
OTHER = """
scene: {duration: 0.1, dt: 0.002}
bodies: {ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, repeat: {kind: line, count: 3, step: [0.15, 0, 0]}}}
"""


def content(folder: Path) -> dict[str, bytes]:
    """Every file of the states."""
    return {path.name: path.read_bytes() for path in (folder / "states").iterdir()}


def test_a_program_gives_the_same_bytes_after_other_programs(simulate):
    first = simulate(LIVELY)
    simulate(OTHER)
    again = simulate(LIVELY)
    assert len(first.states.contact("step")) > 100
    assert content(first.folder) == content(again.folder)


def test_a_program_gives_the_same_bytes_in_a_process_of_its_own(simulate, warm_engine, tmp_path):
    """As users run it, which also tries the program's own main function; and however slow the machine is."""
    trial = simulate(LIVELY)
    recorder = trial.folder / "program/recorder.py"
    text = recorder.read_text().replace("SECONDS_IN_HAND = 5.0", "SECONDS_IN_HAND = 0.0")
    recorder.write_text(text.replace("FRAMES_PER_CHUNK = 100", "FRAMES_PER_CHUNK = 20"))  # as the warm engine has it
    warm_engine.stop()  # on a bare machine, the other process finds the kernels compiled
    main = trial.folder / "program/main.py"
    done = subprocess.run(
        [sys.executable, main, "--out", tmp_path, "--no-film"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "status.json").read_text().split() == ["{", '"state":', '"finished"', "}"]
    assert content(trial.folder) == content(tmp_path)
