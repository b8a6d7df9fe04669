"""Films a recording while it is being made."""

import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from text2sim.watching.painter.context import Canvas
from text2sim.watching.painter.live_states import LiveStates
from text2sim.watching.painter.props import Props
from text2sim.watching.painter.script import Script, projection
from text2sim.watching.painter.shaders import Shader
from text2sim.watching.painter.video import Video

PATIENCE = 0.01
"""Time [s] between looks for new states."""
GLIMPSE = 1.5
"""Time [s] after which a film is shown as far as it is, while its simulation goes on."""

Done = Callable[[str, Path, bool], None]
"""Told of a film: its camera, its file, and whether it is whole."""


class Superseded(Exception):
    """Nobody wants this film any more."""


@dataclass(frozen=True)
class Order:
    """A film to be made."""

    script: str
    """Text of the program's `render.py`."""
    out: Path
    """Run folder: states are read there, films written."""
    width: int
    """Of the picture [pixels]; less if the film has less."""
    ahead: float
    """How far [s] cameras look ahead."""
    colors: dict[str, list[float]]
    """Red, green, blue and opacity by copy, where they are not those that were recorded."""


class Studio:
    """What is kept from one film to the next: compiled shaders."""

    def __init__(self, gl: Any) -> None:
        self._gl = gl
        self._shader = Shader(gl)
        self._shader.use()

    def film(self, order: Order, wanted: Callable[[], bool], done: Done) -> int:
        """Film what is recorded, or being recorded, with each camera in turn.

        Args:
            order: What to film.
            wanted: Whether it still is.
            done: Told of each film, and of the first also when it is not whole yet.

        Returns:
            How many pictures a film has.

        Raises:
            Superseded: if nobody wants it any more.
        """
        script, recording = Script(order.script), LiveStates(order.out)
        size = _size(script.resolution, order.width)
        with ExitStack() as stack:
            canvas = Canvas(self._gl, *size)
            stack.callback(canvas.delete)
            _wait(recording, wanted, until=lambda: len(recording.time) > 0)
            if not len(recording.time):
                return 0
            props = Props(self._gl, self._shader, order.out / "geometry", recording.colors(order.colors))
            stack.callback(props.delete)
            self._shader.light(script.ambient, script.lights)
            for name, camera in script.films.items():
                path = order.out / f"{name}.mp4"
                video = Video(path, size, script.fps)
                glimpses = _Glimpses(camera, video, path.with_name("glimpse.mp4"), done)
                self._shoot(name, video, script, recording, canvas, props, order.ahead, wanted, glimpses)
                glimpses.end()
                done(camera, path, True)
        return len(script.pictures(next(iter(script.films)), float(recording.time[-1])))

    def _shoot(
        self,
        name: str,
        video: Video,
        script: Script,
        recording: LiveStates,
        canvas: Canvas,
        props: Props,
        ahead: float,
        wanted: Callable[[], bool],
        glimpses: "_Glimpses",
    ) -> None:
        aspect = canvas.width / canvas.height
        pictures, k = script.pictures(name, script.end), 0
        with ExitStack() as stack:
            stack.callback(video.drop)
            while k < len(pictures):
                reach = min(pictures[k].t + ahead, script.end)
                _wait(recording, wanted, until=lambda reach=reach: recording.time[-1] >= reach - 1e-9)
                if recording.complete:
                    pictures = script.pictures(name, float(recording.time[-1]))  # it may have ended early
                    if k >= len(pictures):
                        break
                view = script.view(pictures[k], recording)
                self._shader.look(projection(view, script.clip(pictures[k].camera), aspect), view.pos)
                canvas.clear(script.background)
                props.draw(*recording.poses(pictures[k].t), view.pos)
                video.write(canvas.read())
                k += 1
                if not recording.complete:
                    glimpses.show()
            stack.pop_all()
            video.close()


class _Glimpses:
    """Shows a film now and then while it is being made; less and less often, for each is written anew."""

    def __init__(self, name: str, video: Video, path: Path, done: Done) -> None:
        self._name, self._video, self._path, self._done = name, video, path, done
        self._begun = self._due = 0.0

    def show(self) -> None:
        """Show it, if it is time to."""
        now = time.monotonic()
        if not self._begun:  # the first picture may have to wait, which says nothing about the others
            self._begun, self._due = now, now + GLIMPSE
        if now >= self._due:
            self._due = now + max(GLIMPSE, (now - self._begun) / 3)
            if self._video.glimpse(self._path):
                self._done(self._name, self._path, False)

    def end(self) -> None:
        """Leave nothing behind."""
        self._path.unlink(missing_ok=True)


def _wait(recording: LiveStates, wanted: Callable[[], bool], until: Callable[[], bool]) -> None:
    """Wait for states; return also when no more will come."""
    while True:
        if not wanted():
            raise Superseded
        if recording.complete or (len(recording.time) and until()):
            return
        if not recording.read() and not recording.complete:
            time.sleep(PATIENCE)


def _size(resolution: tuple[int, int], width: int) -> tuple[int, int]:
    """Width and height of a preview: even, as the codec wants them."""
    width = min(width, resolution[0])
    return 2 * max(1, width // 2), 2 * max(1, round(width * resolution[1] / resolution[0] / 2))
