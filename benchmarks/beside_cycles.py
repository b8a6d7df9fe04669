"""A moment of a run as our picture and as Cycles', Blender's path tracer, made of the run's USD export: time and looks.

    python benchmarks/beside_cycles.py RUN PYTHON OUT.png [--time 1.0] [--size 480x270] [--quality draft]

PYTHON is an interpreter with Blender as a module (`pip install bpy==4.5.4`), best in an environment of its own. Both
take the same samples and Intel's denoiser, without motion blur. OUT has ours to the left, with the studio's wall and
the textures of finishes, which USD does not carry: light, lens and bodies can be compared, not pixels.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter


def main() -> None:
    """Make both pictures and print their times."""
    import numpy as np
    from PIL import Image

    from text2sim.exchange.usd import write_usd
    from text2sim.recording.film_record import read_recording
    from text2sim.rendering.film import Filming
    from text2sim.rendering.trace import QUALITIES

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("run", type=Path)
    parser.add_argument("python", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--time", type=float, default=1.0)
    parser.add_argument("--size", default="480x270")
    parser.add_argument("--quality", default="draft", choices=sorted(QUALITIES))
    options = parser.parse_args()
    width, height = (int(n) for n in options.size.split("x"))
    filming = Filming(read_recording(options.run), options.quality, size=(width, height))
    film = filming.recording.film
    film["motion_blur"] = 0.0
    frame = min(filming.reels()[0].frames, key=lambda row: abs(row.t - options.time))
    for _ in range(2):  # kernels are compiled once on a machine
        filming.trace(frame)
    begun = perf_counter()
    ours = filming.develop(filming.trace(frame))
    seconds = perf_counter() - begun
    with tempfile.TemporaryDirectory() as folder:
        stage, picture = Path(folder) / "run.usdc", Path(folder) / "cycles.png"
        write_usd(options.run, stage)
        wanted = {"stage": str(stage), "picture": str(picture), "camera": frame.camera, "code": frame.t * film["fps"],
                  "size": [width, height], "samples": QUALITIES[options.quality].samples}  # fmt: skip
        command = [str(options.python), __file__, "--within-blender", json.dumps(wanted)]
        said = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
        theirs = np.asarray(Image.open(picture).convert("RGB"))
    Image.fromarray(np.hstack([ours, theirs])).save(options.out)
    print(f"t = {frame.t:.2f} s, {options.size}, {wanted['samples']} samples")
    print(f"text2sim {seconds:.1f} s, Cycles {float(said.splitlines()[-1]):.1f} s, of an already loaded scene")


def within_blender(wanted: dict) -> None:
    """Render a time of a stage, and print how long that took [s]; runs in Blender's Python."""
    import bpy

    bpy.ops.wm.read_factory_settings()
    for thing in list(bpy.data.objects):  # the cube, the lamp and the camera that every new scene has
        bpy.data.objects.remove(thing)
    bpy.ops.wm.usd_import(filepath=wanted["stage"])
    scene = bpy.context.scene
    cameras = {o.name.partition(".")[0]: o for o in scene.objects if o.type == "CAMERA"}
    scene.camera = cameras[wanted["camera"]]
    whole, part = divmod(wanted["code"], 1)
    scene.frame_set(int(whole), subframe=part)
    scene.render.engine, scene.cycles.device = "CYCLES", "CPU"
    scene.cycles.samples, scene.cycles.use_adaptive_sampling = wanted["samples"], False
    scene.cycles.use_denoising, scene.cycles.denoiser = True, "OPENIMAGEDENOISE"
    scene.render.resolution_x, scene.render.resolution_y = wanted["size"]
    scene.view_settings.view_transform = "AgX"
    scene.render.filepath = wanted["picture"]
    scene.render.use_persistent_data = True
    seconds = 0.0
    for _ in range(2):  # the second time, everything is loaded
        begun = perf_counter()
        bpy.ops.render.render(write_still=True)
        seconds = perf_counter() - begun
    print(f"\n{seconds}")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--within-blender"]:
        within_blender(json.loads(sys.argv[2]))
    else:
        main()
