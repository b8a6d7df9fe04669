"""Error of film frames with and without their background, against 256 samples that are not denoised.

    python -m benchmarks.still_background RUN [RUN …]

`RUN` is a run folder. Printed are the RMS differences [of 255] of the whole picture, and of what shows the background,
at a fifth and four fifths of the film, with the samples of a film that is cut down, and the time of a frame, once the
background is there.
"""

import sys
from pathlib import Path
from time import perf_counter

import numpy as np

from text2sim.recording.film_record import read_recording
from text2sim.rendering.film import Filming
from text2sim.rendering.renderer import mitsuba
from text2sim.rendering.scene import sensor
from text2sim.rendering.trace import undimmed

SIZE = (480, 270)
REFERENCE, SEED = 256, 1000
SAMPLES = (2, 4)


def measure(filming: Filming, part: float) -> str:
    """Return in words the errors of a frame, without its background and with it."""
    frames = filming.reels()[0].frames
    frame = filming._drawn[frames[int(part * len(frames))]]
    if frame not in filming._references:
        return "no standing camera"
    if (behind := filming._background(filming._references[frame], filming._how, 1)) is None:
        return "clear liquids have no background"
    kept, told = filming._references, []
    moment = filming.stage.at(frame.t, gloss=False).solid
    eye = sensor(filming._cameras.view(frame.camera, frame.t, frame.part), filming.size)
    path = mitsuba().load_dict({"type": "path", "max_depth": 6, "rr_depth": 3, "hide_emitters": True})
    many = np.array(mitsuba().render(moment, sensor=eye, integrator=path, spp=REFERENCE, seed=SEED))
    filming.trace(frame)
    for filming._references in ({}, kept):
        begin = perf_counter()
        traced = filming.trace(frame)
        spent, shown = perf_counter() - begin, filming.develop(traced).astype(float)
        assert traced.sampled is not None, "without liquids"
        still = (traced.sampled.first == behind.first).all(axis=-1)
        traced.radiance = undimmed(many[..., :3], many[..., 3])
        off = (shown - filming.develop(traced)) ** 2
        told.append(f"{np.sqrt(off.mean()):.2f}, background {np.sqrt(off[still].mean()):.2f}, {spent:.2f} s")
    return f"t = {frame.t:.2f} s: without {told[0]}; with {told[1]}"


if __name__ == "__main__":
    for name in sys.argv[1:]:
        for samples in SAMPLES:
            film = Filming(read_recording(Path(name)), size=SIZE, samples=samples)
            film.recording.film["motion_blur"] = 0.0
            for part in (0.2, 0.8):
                print(f"{Path(name).name}, {samples} samples, {measure(film, part)}", flush=True)
