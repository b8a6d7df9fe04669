"""H.264 video for browsers, written picture by picture."""

import os
from fractions import Fraction
from pathlib import Path

import numpy as np


class Video:
    """A video file, which gets its name only when it is complete.

    Args:
        path: The file.
        size: Width and height [pixels], both even.
        fps: Pictures per second.
        crf: Constant rate factor of x264, 0 (lossless) to 51; the loss at 18 is hardly visible.
        preset: Preset of x264; slower ones give smaller files.
    """

    def __init__(self, path: Path, size: tuple[int, int], fps: float, *, crf: int = 18, preset: str = "medium"):
        import av

        self._av, self._path, self._part = av, path, path.with_name(path.name + ".part")
        self._container = av.open(str(self._part), "w", format="mp4", options={"movflags": "+faststart"})
        self._stream = self._container.add_stream("libx264", rate=Fraction(fps).limit_denominator(1000))
        self._stream.width, self._stream.height, self._stream.pix_fmt = *size, "yuv420p"
        self._stream.options = {"crf": str(crf), "preset": preset, "threads": "2"}  # the bytes depend on the threads
        codec = self._stream.codec_context
        codec.colorspace = codec.color_primaries = codec.color_trc = codec.color_range = 1  # BT.709, limited range

    def write(self, image: np.ndarray) -> None:
        """Appends one picture, shape (height, width, 3), uint8."""
        frame = self._av.VideoFrame.from_ndarray(np.ascontiguousarray(image), format="rgb24")
        frame = frame.reformat(format="yuv420p", dst_colorspace="ITU709", dst_color_range="MPEG")
        self._keep(lambda: self._container.mux(self._stream.encode(frame)))

    def close(self) -> None:
        """Completes the file."""
        self._keep(lambda: self._container.mux(self._stream.encode()))
        self._keep(self._container.close)
        os.replace(self._part, self._path)

    def _keep(self, write) -> None:
        """Calls `write`; if the disk is full, deletes the partial file and names the film in the error."""
        try:
            write()
        except OSError as error:
            self._part.unlink(missing_ok=True)
            raise OSError(error.errno, error.strerror, str(self._path)) from error
