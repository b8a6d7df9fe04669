"""Error and time of film frames with and without their background, against 256 samples that are not denoised.

    python -m benchmarks.still_background RUN [RUN …]

`RUN` is a run folder. Printed are the root mean square of the differences [of 255] and the time of a frame, at a fifth
and four fifths of the film, once the background is there, and the share of the picture that is traced in front of it.
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

SIZE = (960, 540)
PASSES, SAMPLES_OF_PASS, SEED = 4, 64, 1000
SAMPLES = (2, 8)


def measure(filming: Filming, part: float) -> str:
    """Return in words the errors and times of a frame, without its background and with it."""
    frames = filming.reels()[0].frames
    frame = filming._shown(frames[int(part * len(frames))])
    if not filming.has_background(frame):
        return "no standing camera"
    behind = filming._standing.behind(frame, filming.samples)
    if behind is None:
        return "clear liquids have no background"
    moment = filming.stage.at(frame.t, gloss=False).solid
    eye = sensor(filming._cameras.view(frame.camera, frame.t, frame.part), filming.size)
    path = mitsuba().load_dict({"type": "path", "max_depth": 6, "rr_depth": 3, "hide_emitters": True})
    passes = (
        mitsuba().render(moment, sensor=eye, integrator=path, spp=SAMPLES_OF_PASS, seed=SEED + k) for k in range(PASSES)
    )
    many = np.mean([np.array(one) for one in passes], axis=0)
    told = []
    for with_background in (False, True):
        filming.trace(frame, with_background=with_background)
        begin = perf_counter()
        traced = filming.trace(frame, with_background=with_background)
        spent, shown = perf_counter() - begin, filming.develop(traced).astype(float)
        traced.radiance = undimmed(many[..., :3], many[..., 3])
        off = float(np.sqrt(np.mean((shown - filming.develop(traced)) ** 2)))
        told.append(f"{off:.2f}, {spent:.2f} s")
    return f"t = {frame.t:.2f} s: without {told[0]}; with {told[1]}, {100 * behind[1].mean():.0f} % traced"


if __name__ == "__main__":
    for name in sys.argv[1:]:
        for samples in SAMPLES:
            film = Filming(read_recording(Path(name)), size=SIZE, samples=samples)
            film.recording.film["motion_blur"] = 0.0
            for part in (0.2, 0.8):
                print(f"{Path(name).name}, {samples} samples, {measure(film, part)}", flush=True)
