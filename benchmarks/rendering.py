"""Where the time of a path-traced picture goes, beside bare Mitsuba on the same scene with the same samples.

    python benchmarks/rendering.py RUN [--size 1280x720] [--pictures 3] [--quality draft]
    python benchmarks/rendering.py RUN --flicker [--size 1280x720] [--quality draft]
    python benchmarks/rendering.py RUN --equal [--size 1280x720] [--quality draft]

Times are of the processor over all its cores, divided by their number: what an idle machine would take. Flicker is the
difference between the last two pictures of the main film, where nothing moved. Equal is how long bare Mitsuba would
take to come as near to a picture of very many samples: error falls with the root of their number.
"""

import argparse
import os
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from text2sim.recording.film_record import read_recording
from text2sim.rendering.film import Filming
from text2sim.rendering.frames import save
from text2sim.rendering.renderer import find_variant, mitsuba
from text2sim.rendering.scene import sensor
from text2sim.rendering.trace import QUALITIES, ROULETTE, Quality, trace
from text2sim.templates.cadence import Frame
from text2sim.templates.cameras import Cameras
from text2sim.templates.video import Video

MANY = 400
"""Samples of the picture that others are compared with."""

WARM = 2
"""Pictures before those that count."""


def main() -> None:
    """Trace some pictures and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("run", type=Path)
    parser.add_argument("--size", default="1280x720")
    parser.add_argument("--pictures", type=int, default=3)
    parser.add_argument("--quality", default="draft", choices=["draft", "final"])
    parser.add_argument("--flicker", action="store_true")
    parser.add_argument("--equal", action="store_true")
    options = parser.parse_args()
    width, height = (int(n) for n in options.size.split("x"))
    filming = Filming(read_recording(options.run), options.quality, size=(width, height))
    # A blurred picture is made of several: beside it, a bare one would be another picture.
    filming.recording.film["motion_blur"] = 0.0
    every = filming.reels()[0].frames
    if options.flicker:
        print(flicker(filming, every[-2:]))
        return
    if options.equal:
        print(equal(filming, every[len(every) // 2]))
        return
    frames = [every[k] for k in np.linspace(0, len(every) - 1, options.pictures + WARM).astype(int)]
    mi, how, cores = mitsuba(), QUALITIES[options.quality], os.cpu_count() or 1
    cameras = Cameras(filming.recording.film, filming.recording.states)
    integrator = bare_path(how)
    spent = dict.fromkeys(("bare", "whole", "write", "encode"), 0.0)
    parts: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as folder:
        video = Video(Path(folder) / "film.mp4", (width, height), 25.0)
        for k, frame in enumerate(frames):
            scene = filming.stage.at(frame.t).solid
            camera = sensor(cameras.view(frame.camera, frame.t, frame.part), (width, height))
            bare = 0.0
            for _ in range(2):  # the second time, its kernel is there, as it is for the whole picture after it
                begun = process_time()
                np.array(mi.render(scene, sensor=camera, integrator=integrator, spp=how.samples, seed=0))
                bare = process_time() - begun
            spent["bare"] += bare
            begun = process_time()
            traced = filming.trace(frame)
            spent["whole"] += process_time() - begun
            for name, value in traced.seconds.items():
                parts[name] = parts.get(name, 0.0) + value
            begun = process_time()
            save(Path(folder) / "picture.png", lambda part, traced=traced: filming._write(part, traced, "png"))
            spent["write"] += process_time() - begun
            begun = process_time()
            video.write(filming.develop(traced))
            spent["encode"] += process_time() - begun
            if k < WARM:  # kernels are compiled once on a machine, some of them not before the second picture
                spent, parts = dict.fromkeys(spent, 0.0), {}
        video.close()
    table = Table("part", "s per picture")
    table.title = f"{options.run.name}, {options.size}, {how.samples} samples, {find_variant().name}, {cores} cores"
    for name, value in spent.items():
        table.add_row(name, f"{value / options.pictures / cores:.2f}")
    table.add_row("whole / bare", f"{spent['whole'] / spent['bare']:.2f}")
    for name, value in parts.items():
        table.add_row(f"  {name} (by the clock)", f"{value / options.pictures:.2f}")
    Console().print(table)


def bare_path(how: Quality) -> Any:
    """Return Mitsuba's path tracer, set as for our pictures."""
    return mitsuba().load_dict({"type": "path", "max_depth": how.depth, "rr_depth": ROULETTE, "hide_emitters": True})


def flicker(filming: Filming, pair: list[Frame]) -> str:
    """Return in words how two pictures differ where they show the same things in the same places."""
    first, second = (filming.trace(frame) for frame in pair)
    still = np.abs(first.depth - second.depth) <= 1e-5 * np.maximum(first.depth, second.depth)
    away = np.abs(filming.develop(first).astype(int) - filming.develop(second)).max(axis=-1)
    moved = f"the others by {away[~still].mean():.2f}" if (~still).any() else "nothing moves"
    return (
        f"t = {pair[0].t:.3f} and {pair[1].t:.3f} s: {100 * still.mean():.1f} % of the pixels show nothing that moves; "
        f"of 255 these differ by {away[still].mean():.3f} on average, by {np.percentile(away[still], 99):.0f} or more "
        f"in 1 % of them, by {away[still].max()} at most; {moved}"
    )


def equal(filming: Filming, frame: Frame) -> str:
    """Return in words what a picture, as it is shown, costs with and without what is done about its noise.

    Clear glass is left out of all pictures.

    Raises:
        SystemExit: If there are clear liquids, whose pictures are kept only as they are shown.
    """
    film, how = filming.recording.film, QUALITIES[filming.quality]
    view = Cameras(film, filming.recording.states).view(frame.camera, frame.t, frame.part)
    moments = [(filming.stage.at(frame.t), sensor(view, filming.size))]

    def pictures(samples: int) -> tuple[np.ndarray, np.ndarray]:
        """Return a picture before and after denoising, of 255, each (h, w, 3)."""
        traced = trace(moments, Quality(samples, how.depth, 1), film["gain"])
        if traced.surfaces is None:
            raise SystemExit("--equal needs a case without clear liquids")
        kept = (traced.surfaces.noisy, traced.surfaces.smooth)
        noisy, smooth = (filming.develop(replace(traced, radiance=radiance)).astype(float) for radiance in kept)
        return noisy, smooth

    def spent(work: Callable[[], Any]) -> float:
        for _ in range(WARM):
            work()
        begun = process_time()
        work()
        return (process_time() - begun) / (os.cpu_count() or 1)

    mi, (moment, camera) = mitsuba(), moments[0]
    path = bare_path(how)
    noisy = spent(lambda: np.array(mi.render(moment.solid, sensor=camera, integrator=path, spp=how.samples)))
    seconds = spent(lambda: pictures(how.samples))
    wanted, (bare, ours) = pictures(MANY)[0], pictures(how.samples)
    away, off = (float(np.sqrt(np.mean((shown - wanted) ** 2))) for shown in (ours, bare))
    times = (off / away) ** 2
    return (
        f"t = {frame.t:.2f} s, {how.samples} samples: bare {noisy:.2f} s, off by {off:.1f} of 255 (root mean square); "
        f"whole {seconds:.2f} s, off by {away:.1f}; for that, bare would need {how.samples * times:.0f} samples and "
        f"{noisy * times:.1f} s, {noisy * times / seconds:.1f} times as long"
    )


if __name__ == "__main__":
    main()
