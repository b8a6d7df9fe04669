"""An H.264 file that browsers play, made quickly."""

import os
from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

AHEAD = 4
"""Most pictures that wait to be encoded."""


class Video:
    """Written picture by picture, and named only when whole.

    Pictures are encoded in a thread of its own, while the next is drawn.
    """

    def __init__(self, path: Path, size: tuple[int, int], fps: float) -> None:
        import av

        self._av, self._path, self._part = av, path, path.with_name(path.name + ".part")
        self._container = av.open(str(self._part), "w", format="mp4", options={"movflags": "+faststart"})
        self._stream = self._container.add_stream("libx264", rate=Fraction(fps).limit_denominator(1000))
        self._stream.width, self._stream.height = size
        self._stream.pix_fmt = "yuv420p"
        # A key picture every second: one jumps about in a preview.
        self._stream.options = {"crf": "21", "preset": "ultrafast", "threads": "1", "g": str(max(1, round(fps)))}
        codec = self._stream.codec_context
        codec.colorspace = codec.color_primaries = codec.color_trc = codec.color_range = 1  # BT.709, limited range
        self._packets: list[tuple[bytes, int | None, int | None, bool]] = []
        self._thread = ThreadPoolExecutor(1, "encoder")
        self._waiting: deque[Future[None]] = deque()

    def write(self, image: np.ndarray) -> None:
        """Append a picture, shape (height, width, 4), uint8."""
        self._waiting.append(self._thread.submit(self._encode, np.array(image, order="C")))
        if len(self._waiting) > AHEAD:
            self._waiting.popleft().result()

    def glimpse(self, path: Path) -> bool:
        """Write what there is so far into another file, which can be played; return whether there is anything."""
        self._settle()
        if not self._packets:
            return False
        part = path.with_name(path.name + ".part")
        with self._av.open(str(part), "w", format="mp4", options={"movflags": "+faststart"}) as container:
            stream = container.add_stream_from_template(self._stream)
            for content, pts, dts, key in self._packets:
                packet = self._av.Packet(content)
                packet.stream, packet.time_base = stream, self._stream.time_base
                packet.pts, packet.dts, packet.is_keyframe = pts, dts, key
                container.mux(packet)
        os.replace(part, path)
        return True

    def close(self) -> None:
        """Finish the file and put it in its place."""
        self._settle()
        self._thread.shutdown()
        self._mux(self._stream.encode())
        self._container.close()
        os.replace(self._part, self._path)

    def drop(self) -> None:
        """Leave it: nobody wants it any more."""
        self._thread.shutdown(cancel_futures=True)
        self._container.close()
        self._part.unlink(missing_ok=True)

    def _settle(self) -> None:
        while self._waiting:
            self._waiting.popleft().result()

    def _encode(self, image: np.ndarray) -> None:
        frame = self._av.VideoFrame.from_ndarray(image, format="rgba")
        frame = frame.reformat(format="yuv420p", dst_colorspace="ITU709", dst_color_range="MPEG", threads=1)
        self._mux(self._stream.encode(frame))

    def _mux(self, packets: Any) -> None:
        for packet in packets:
            self._packets.append((bytes(packet), packet.pts, packet.dts, packet.is_keyframe))
            self._container.mux(packet)
