"""Anonymised copies of films."""

import os
from fractions import Fraction
from pathlib import Path

from text2sim.spec_schema.errors import RunError

MOST_FRAMES = 18_000
"""Frames of a film: five minutes at 60 per second."""
LONGEST_SIDE = 4096
"""Largest width or height of a frame [pixels]."""


def anonymise_film(source: Path, target: Path) -> None:
    """Re-encode a film with the settings of all others, without sound, tags, names and dates.

    Raises:
        RunError: If it is not a film, or is too large.
    """
    import av
    import av.error

    try:
        with av.open(str(source)) as film, av.open(str(target), "w", format="mp4", options=_OPTIONS) as made:
            if not film.streams.video:
                raise RunError(f"{source}: the film has no frames")
            pictures = film.streams.video[0]
            old = pictures.codec_context
            if max(old.width, old.height) > LONGEST_SIDE:
                raise RunError(f"{source}: its frames are larger than {LONGEST_SIDE} pixels")
            rate = pictures.average_rate or Fraction(25)
            stream = made.add_stream("libx264", rate=rate)
            stream.width, stream.height, stream.pix_fmt = old.width // 2 * 2, old.height // 2 * 2, "yuv420p"
            stream.options = {"crf": "14", "preset": "veryfast", "threads": "2"}
            for name in ("colorspace", "color_primaries", "color_trc", "color_range"):
                setattr(stream.codec_context, name, getattr(old, name))
            count = 0
            for count, frame in enumerate(film.decode(pictures), 1):
                if count > MOST_FRAMES:
                    raise RunError(f"{source}: it has more than {MOST_FRAMES:,} frames")
                plain = frame.reformat(stream.width, stream.height, "yuv420p")
                plain.pts, plain.time_base, plain.pict_type = count - 1, 1 / rate, 0
                made.mux(stream.encode(plain))
            made.mux(stream.encode())
        if not count:
            raise RunError(f"{source}: the film has no frames")
    except (av.error.FFmpegError, ValueError, OverflowError) as error:
        raise RunError(f"{source}: the film cannot be read: {error}") from None
    os.utime(target, (0, 0))


_OPTIONS = {"movflags": "+faststart", "fflags": "+bitexact"}
