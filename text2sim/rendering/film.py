"""Rendering of films of a recorded run, frame by frame; resumable after an interruption.

RUN/render/frames/<digest>.png      finished frames, without the overlay
RUN/render/<quality>.mp4            the film; <quality>_<camera>.mp4 those of other cameras
"""

from collections import Counter
from collections.abc import Callable, Iterator
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf
from pathlib import Path
from time import monotonic, perf_counter
from typing import Any, Literal

import numpy as np

from text2sim.recording.film_record import FilmRecord
from text2sim.recording.run_files import read_measures
from text2sim.rendering import tone
from text2sim.rendering.backdrop import clearness
from text2sim.rendering.background import COARSE, LIGHT_SAMPLES, background_samples
from text2sim.rendering.frames import Digests, remove_abandoned, save, write_radiance
from text2sim.rendering.resting import drawn_frames, held_samples
from text2sim.rendering.scene import FilmStage, sensor
from text2sim.rendering.skies import Skies
from text2sim.rendering.standing import StandingCameras
from text2sim.rendering.trace import QUALITIES, Quality, Traced, trace
from text2sim.spec_schema.errors import RunError, did_you_mean, there_are
from text2sim.templates.cadence import MAIN, Frame, frames, reels
from text2sim.templates.cameras import Cameras
from text2sim.templates.overlays import Overlay
from text2sim.templates.video import Video

Format = Literal["png", "exr"]
PROBE_SAMPLES = 1 + LIGHT_SAMPLES / COARSE**2
"""Samples per pixel by which a moment is compared with a background."""
ENCODER = {"draft": (18, "medium"), "final": (16, "slow")}
"""Constant rate factor and preset of the encoder, by quality."""


@dataclass(frozen=True)
class FilmProgress:
    """Progress of a film."""

    film: str
    done: int
    total: int
    seconds: dict[str, float]
    """Time [s] of the last picture by step; empty if it existed already."""


@dataclass(frozen=True)
class Work:
    """What there is to trace of films."""

    pictures: int
    """Number of pictures."""
    finished: float
    """Number of whole pictures that take as long to finish."""
    samples: float
    """Samples per pixel of all pictures together, with those of backgrounds."""


@dataclass(frozen=True)
class Reel:
    """One film and its frames."""

    name: str
    """Stem of the file name."""
    frames: list[Frame]


def coarse_to_fine(count: int) -> list[int]:
    """Return 0 to count - 1 in coarse-to-fine order: the ends, the middle, the quarters, and so on."""
    steps = [1 << k for k in reversed(range(count.bit_length()))]
    return list(dict.fromkeys([0, max(count - 1, 0), *(k for step in steps for k in range(0, count, step))]))[:count]


class Filming:
    """Renders films of a run.

    Args:
        recording: The recording of the run.
        quality: One of `QUALITIES`.
        size: Width and height [pixels]; by default those of the film section.
        samples: Samples per pixel; those of the quality if None.
        fps: Pictures per second of film; by default those of the film section.
    """

    def __init__(
        self,
        recording: FilmRecord,
        quality: str = "draft",
        *,
        size: tuple[int, int] | None = None,
        samples: int | None = None,
        fps: float | None = None,
    ):
        self.recording, self.quality = recording, quality
        how = QUALITIES[quality]
        self._how = Quality(samples, how.depth, how.blur) if samples else how
        self.size = size or tuple(recording.film["resolution"])
        self.fps, self._shutter = float(fps or recording.film["fps"]), 1.0
        self.folder = recording.folder / "render"
        self._cameras = Cameras(recording.film, recording.states)
        self._digests = Digests(recording, self._how, self.size)
        self._drawn: dict[Frame, Frame] = {}
        self._samples: dict[Frame, int] = {}
        self._standing = self._standing_cameras()
        self._skies = Skies(recording.film, self._cameras, recording.states.time, self.size)

    def _standing_cameras(self) -> StandingCameras:
        gain = self.recording.film["gain"]
        return StandingCameras(lambda: self.stage, self._cameras, self.size, self._how, gain)

    @cached_property
    def stage(self) -> FilmStage:
        """The stage; built on first use, which takes seconds."""
        return FilmStage(self.recording)

    @property
    def samples(self) -> int:
        """Samples per pixel."""
        return self._how.samples

    @property
    def fewest_samples(self) -> int:
        """Samples below which a frame takes no less time: one for each moment of a motion-blurred one."""
        return self._how.blur if self.recording.film["motion_blur"] else 1

    def variant(self, size: tuple[int, int], fps: float, samples: int) -> "Filming":
        """Return a copy.

        Args:
            size: Width and height [pixels].
            fps: Frame rate [1/s].
            samples: Number of samples per pixel.
        """
        other = copy(self)
        other.size, other.fps, other._how, other._drawn = size, fps, replace(self._how, samples=samples), {}
        other._shutter = self._shutter * min(1.0, fps / self.fps)  # fewer pictures are no more blurred
        other._samples, other._standing = {}, other._standing_cameras()
        other._digests = Digests(self.recording, other._how, size)
        other._skies = replace(self._skies, size=size)
        return other

    def reels(
        self, camera: str = "", span: tuple[int, int] | None = None, during: tuple[float, float] | None = None
    ) -> list[Reel]:
        """Return the films of the run.

        Args:
            camera: Name of the only camera to film with; empty for all.
            span: First frame, and the one after the last.
            during: First and last simulated time [s].

        Raises:
            RunError: If there is no such camera or frame.
        """
        film: dict[str, Any] = self.recording.film | {"fps": self.fps}
        film["motion_blur"] *= self._shutter
        found = reels(film)
        if camera:
            if camera not in film["cameras"]:
                known = film["cameras"]
                raise RunError(f"there is no camera `{camera}`{there_are(known, None)}{did_you_mean(camera, known)}")
            whole = {"camera": camera, "from": film["start"], "to": film["end"], "speed": film["speed"], "hold": 0.0}
            found = {f"{MAIN}_{camera}": [whole]}
        paths = []
        for name, shots in found.items():
            pictures = frames(film, shots, self.recording.last)
            drawn = drawn_frames(pictures, self.recording, self._cameras, self.size[1])
            self._drawn |= drawn
            self._samples |= {frame: held_samples(self.samples, k) for frame, k in Counter(drawn.values()).items()}
            self._standing.add(drawn.values())
            if span is not None:
                if not pictures[slice(*span)]:
                    raise RunError(
                        f"the film has pictures 0 to {len(pictures) - 1}, none of {span[0]} to {span[1] - 1}"
                    )
                pictures = pictures[slice(*span)]
            if during is not None:
                begin, end = during
                shown = [picture for picture in pictures if begin <= picture.t <= end]
                if not shown:
                    times = f"{pictures[0].t:g} s to {pictures[-1].t:g} s"
                    raise RunError(f"the film shows {times}, and no picture from {begin:g} s to {end:g} s")
                pictures = shown
            paths.append(Reel(name.replace(MAIN, self.quality, 1), pictures))
        return paths

    def excerpt(self, reel: Reel, few: list[Frame]) -> Reel:
        """Return a film of a few frames, and plan backgrounds and samples for these alone.

        Args:
            reel: The film.
            few: Some of its frames, in order.
        """
        self._samples, self._standing = {}, self._standing_cameras()
        self._standing.add(map(self._shown, few))
        return Reel(reel.name, few)

    def samples_of(self, frame: Frame) -> int:
        """Return the samples per pixel of a frame: more if it is held."""
        return self._samples.get(self._shown(frame), self.samples)

    def has_background(self, frame: Frame) -> bool:
        """Return whether the frame shows a still background, see `background.py`."""
        return self._shown(frame) in self._standing.references

    def missing(self, reels: list[Reel], share: float = 1.0) -> Work:
        """Return what there is to trace.

        Args:
            reels: The films.
            share: Share of the picture that is traced where there is a background; see `traced_share`.
        """
        frames = {self.finished(frame): self._shown(frame) for reel in reels for frame in reel.frames}
        todo = [frame for path, frame in frames.items() if not path.is_file()]
        samples = finished = 0.0
        behind = set()
        for frame in todo:
            part = 1.0
            if (reference := self._standing.references.get(frame)) is not None:
                part = share
                samples += PROBE_SAMPLES * len(frame.moments(self._how.blur))
                behind.add((reference, self.samples_of(frame)))
            samples += part * self.samples_of(frame)
            finished += part
        many = len({reference for reference, _ in behind})
        samples += background_samples(self.samples) * many + sum(few for _, few in behind)
        return Work(len(todo), finished + many + len(behind), samples)

    def traced_share(self, reel: Reel) -> float:
        """Return the share of the picture that differs from its background, from some frames of a film."""
        return self._standing.share(map(self._shown, reel.frames))

    def trace(self, frame: Frame, *, with_background: bool = True) -> Traced:
        """Trace one frame, in front of its still background if it has one; times are measured without."""
        frame = self._shown(frame)
        how = replace(self._how, samples=self.samples_of(frame))
        start = perf_counter()
        behind = self._standing.behind(frame, how.samples) if with_background else None
        behind_took = perf_counter() - start
        start = perf_counter()
        stage, moments, view = self.stage, [], None
        for t, part in frame.moments(how.blur):
            view = self._cameras.view(frame.camera, t, part)
            moments.append((stage.at(t), sensor(view, self.size)))
        update = perf_counter() - start
        traced = trace(moments, how, self.recording.film["gain"], behind)
        traced.seconds |= {"update": update, "background": behind_took}
        if view is not None:
            traced.behind, traced.haze = self._skies.behind(view, frame.camera), stage.haze(view.pos)
        return traced

    def _shown(self, frame: Frame) -> Frame:
        """Return the frame that is drawn for a frame."""
        return self._drawn.get(frame, frame)

    def develop(self, traced: Traced) -> Any:
        """Return a traced frame as displayed, uint8."""
        film = self.recording.film
        shown = tone.developed(traced.radiance, film["gain"], film.get("tone", "agx"))
        alpha = traced.alpha * clearness(traced.haze, traced.depth, traced.alpha, edge="skyline" in film["backdrop"])
        behind = film["background"] if traced.behind is None else traced.behind
        return tone.bytes_of(tone.over(shown, alpha, behind))

    def finished(self, frame: Frame, format: Format = "png") -> Path:
        """Return the path of a frame, which may not exist yet."""
        drawn = self._shown(frame)
        digest = self._digests(drawn, self.samples_of(drawn), self._standing.references.get(drawn))
        return self.folder / "frames" / f"{digest}.{format}"

    def render(
        self,
        reel: Reel,
        tell: Callable[[FilmProgress], None],
        *,
        shard: tuple[int, int] = (0, 1),
        format: Format = "png",
        until: float = inf,
    ) -> list[Path]:
        """Trace the missing frames and return the paths of all.

        The order is coarse to fine, so that the frames of an interrupted film are spread over it.

        Args:
            reel: The film.
            tell: Called after each frame.
            shard: (i, n): only every n-th frame, starting with the i-th.
            format: png for the displayed frame, exr for radiance.
            until: Time of `monotonic` [s] after which no frame is started.
        """
        remove_abandoned(self.folder / "frames")
        own = reel.frames[shard[0] :: shard[1]]
        paths = [self.finished(frame, format) for frame in own]
        for done, k in enumerate(coarse_to_fine(len(own)), 1):
            frame, path = own[k], paths[k]
            if monotonic() > until and not path.is_file():
                break
            seconds: dict[str, float] = {}
            if not path.is_file():
                traced = self.trace(frame)
                save(path, lambda part, traced=traced: self._write(part, traced, format))
                seconds = traced.seconds
            tell(FilmProgress(reel.name, done, len(own), seconds))
        return paths

    def rendered(self, reel: Reel) -> list[Path]:
        """Return the paths of a film's frames.

        Raises:
            RunError: If some are not rendered.
        """
        paths = [self.finished(frame) for frame in reel.frames]
        missing = [str(k) for k, path in enumerate(paths) if not path.is_file()]
        if missing:
            some = ", ".join(missing[:8]) + (", …" if len(missing) > 8 else "")
            raise RunError(f"{len(missing)} of {len(paths)} pictures of {reel.name} are not rendered yet: {some}")
        return paths

    def held(self, reel: Reel) -> Reel:
        """Return a film of the traced frames: each is held until the next one.

        Raises:
            RunError: If there are none.
        """
        finished = [frame for frame in reel.frames if self.finished(frame).is_file()]
        if not finished:
            raise RunError(f"no picture of {reel.name} is rendered yet")
        starts = np.array([frame.k for frame in finished])
        last = [max(int(np.searchsorted(starts, frame.k, "right")) - 1, 0) for frame in reel.frames]
        return Reel(reel.name, [finished[k] for k in last])

    def encode(self, reel: Reel, part: str = "") -> Path:
        """Encode a film whose frames are all rendered.

        Args:
            reel: The film.
            part: Suffix of the file name if it is not the whole film.

        Raises:
            RunError: If some are not rendered.
        """
        paths = self.rendered(reel)
        crf, preset = ENCODER.get(self.quality, ENCODER["final"])
        target = self.folder / f"{reel.name}{part}.mp4"
        video = Video(target, self.size, self.fps, crf=crf, preset=preset)
        for image in self.pictures(reel, paths):
            video.write(image)
        video.close()
        return target

    def pictures(self, reel: Reel, paths: list[Path]) -> Iterator[Any]:
        """Yield finished pictures with their overlays."""
        from PIL import Image

        film = self.recording.film
        shown = film | {"overlay": film["overlay"] | {"pace": False}}  # only the preview shows the derived pace
        overlay = Overlay(shown, self._values()) if reel.name == self.quality else None
        for frame, path in zip(reel.frames, paths, strict=True):
            with Image.open(path) as picture:
                image = np.asarray(picture.convert("RGB"))
            yield image if overlay is None else overlay.draw(image, frame)

    def _values(self) -> Callable[[float], list[str]]:
        """Return a function from time [s] to the lines with the values of measures."""
        times, series = read_measures(self.recording.folder)
        names = [name for name in self.recording.film["overlay"]["values"] if name in series]

        def rows(t: float) -> list[str]:
            return [f"{name.replace('_', ' ')} {np.interp(t, times, series[name]):.3g}" for name in names]

        return rows

    def _write(self, path: Path, traced: Traced, format: Format) -> None:
        if format == "exr":
            # EXR has premultiplied alpha: https://openexr.com/en/latest/TechnicalIntroduction.html
            layers = np.dstack([traced.radiance * traced.alpha[..., None], traced.alpha]).astype(np.float32)
            write_radiance(path, layers)
            return
        from PIL import Image

        Image.fromarray(self.develop(traced)).save(path, format="png", compress_level=4)
