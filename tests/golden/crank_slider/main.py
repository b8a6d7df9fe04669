"""Simulate crank_slider, record the run, and film the recording.

    python main.py --out DIR              simulate, then film
    python main.py --out DIR --film-only  film the recorded states in DIR

Needs genesis-world 1.4 and numpy. States are written to disk chunk by chunk; after Ctrl-C the recorded ones remain.
"""

import argparse
import json
import signal
import sys
from pathlib import Path

import genesis as gs
import render
from actions import Actions
from bodies import add_bodies, configure
from cadence import film_of
from film import NoOpenGL, add_cameras, film, vis_options
from recorder import Divergence, Progress, Recorder, build
from scene import DT, MAX_SPEED, RECORD_EVERY, STEPS, add_statics, make_scene, start_engine

FILM = film_of(render)
FINISHED, DIVERGED, FAILED, INTERRUPTED = 0, 3, 4, 130

signals = []  # received so far


class Interrupted(KeyboardInterrupt):
    """A signal asked the run to stop."""


def assemble(with_cameras=True):
    """Build the scene; return it with its entities and cameras by name."""
    scene = make_scene(vis_options(FILM))
    bodies = {**add_statics(scene), **add_bodies(scene)}
    cameras = add_cameras(scene, FILM) if with_cameras else {}
    build(scene)
    configure(bodies)
    heed()
    return scene, bodies, cameras


def simulate(scene, bodies, out):
    """Run all steps and record them in the folder `out`."""
    actions = Actions(scene, bodies)
    recorder = Recorder(scene, bodies, out, DT, RECORD_EVERY, STEPS * DT, speed_limit=MAX_SPEED)
    state = "failed"
    try:
        recorder.start()
        for step in range(STEPS):
            heed()
            actions.before_step(step)
            scene.step()
            recorder.after_step(step + 1)
        state = "finished"
    except Divergence:
        state = "diverged"
        raise
    except Interrupted:
        state = "interrupted"
        raise
    except gs.GenesisException as error:
        if (divergence := recorder.diverged(error)) is None:
            raise
        state = "diverged"
        raise divergence from error
    finally:
        recorder.close(state)


def main():
    """Run the program; return its exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True, help="folder for states and film")
    parser.add_argument("--film-only", action="store_true", help="film the recorded states of the folder")
    parser.add_argument("--no-film", action="store_true", help="simulate only")
    parser.add_argument("--backend", choices=["cpu", "gpu"], default="cpu")
    options = parser.parse_args()
    out = options.out.resolve()
    out.mkdir(parents=True, exist_ok=True)
    signal.signal(signal.SIGINT, interrupt)
    signal.signal(signal.SIGTERM, interrupt)
    progress = Progress(out)
    progress("start", force=True)
    code, status = FINISHED, {"state": "finished"}
    scene = None
    try:
        start_engine(gs.cpu if options.backend == "cpu" else gs.gpu)
        progress("build", force=True)
        scene, bodies, cameras = assemble(with_cameras=not options.no_film)
        if not options.film_only:
            simulate(scene, bodies, out)
    except Divergence as error:
        code = DIVERGED
        where = {"body": error.body, "quantity": error.quantity, "time": error.time}
        status = {"state": "diverged", "message": str(error), "where": where}
    except Interrupted:
        code, status = INTERRUPTED, {"state": "interrupted", "message": "stopped from outside"}
    except Exception as error:
        if not options.film_only:
            write_status(out, {"state": "failed", "message": f"{type(error).__name__}: {error}"})
        raise
    if not options.film_only:
        write_status(out, status)
    if code in (FINISHED, DIVERGED) and not options.no_film:
        try:
            film(scene, cameras, out, FILM)
        except NoOpenGL as error:
            print(f"no film: {error}", file=sys.stderr)
        except Interrupted:
            code = INTERRUPTED
    return code


def interrupt(number, frame):
    """Turn the first signal into an exception; a second one ends the process."""
    signal.signal(number, signal.SIG_DFL)
    signals.append(number)
    raise Interrupted


def heed():
    """Stop if a signal arrived while the engine was compiling, which swallows exceptions."""
    if signals:
        raise Interrupted


def write_status(out, status):
    """Write how the run ended, for the parent process."""
    (out / "status.json").write_text(json.dumps(status, indent=1) + "\n")


if __name__ == "__main__":
    sys.exit(main())
