"""Error and time of film frames by samples per pixel, denoised, against 64 samples.

    python -m benchmarks.film_samples RUN [RUN …]

`RUN` is a run folder; `text2sim run cases/laid_table` makes one.
"""

import sys
from pathlib import Path
from time import perf_counter

import numpy as np

from text2sim.recording.film_record import read_recording
from text2sim.rendering.film import Filming

SIZE = (1280, 720)
REFERENCE = 64
SAMPLES = (8, 4, 2)


def frame(run: Path, samples: int) -> tuple[np.ndarray, float]:
    """Return the middle frame of the film (h, w, 3) and the wall time of tracing it [s], kernels compiled before."""
    filming = Filming(read_recording(run), size=SIZE, samples=samples)
    frames = filming.reels()[0].frames
    filming.trace(frames[0])
    begin = perf_counter()
    traced = filming.trace(frames[len(frames) // 2])
    return filming.develop(traced).astype(float), perf_counter() - begin


def run(folder: Path) -> None:
    """Print the RMS difference [of 255] and the time of each number of samples."""
    reference, _ = frame(folder, REFERENCE)
    for samples in SAMPLES:
        picture, seconds = frame(folder, samples)
        error = np.sqrt(np.mean((picture - reference) ** 2))
        print(
            f"{folder.name}: {samples} samples differ by {error:.2f} of 255 (RMS) and take {seconds:.1f} s", flush=True
        )


if __name__ == "__main__":
    for name in sys.argv[1:]:
        run(Path(name))
