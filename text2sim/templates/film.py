"""Films a run of Genesis from its recorded states, whether they were simulated a moment ago or long since.

Nothing is drawn while the simulation runs, so a machine without OpenGL simulates all the same.

    OUT/video.mp4, video_<camera>.mp4, first.png, frames/       the film, its first frame, and sampled frames
    OUT/visibility.json                                         how much of each sampled frame each body fills
"""

import json
import os
from fractions import Fraction
from pathlib import Path

import numpy as np
from files import write_json
from recorder import Progress

QUATERNION_AT = {"free": 3, "ball": 0}  # within the joint's slice of qpos


class NoOpenGL(RuntimeError):
    """The scene cannot be drawn on this machine; whatever was recorded is unharmed."""


class States:
    """The recorded states of a run, read back.

    Attributes:
        layout: Content of `layout.json`.
        time: Times of the recorded frames [s], shape (F,).
        soft: States of bodies that deform; None if there is none.
    """

    def __init__(self, out: Path):
        folder = Path(out) / "states"
        self.layout = json.loads((folder / "layout.json").read_text())
        chunks = [np.load(path) for path in sorted(folder.glob("chunk_*.npz"))]
        chunks = [chunk for chunk in chunks if "time" in chunk]
        self.time, self._qpos, self._pos = (
            np.concatenate([chunk[name] for chunk in chunks]) for name in ("time", "qpos", "links_pos")
        )
        turning = [joint for joint in self.layout["joints"] if joint["kind"] in QUATERNION_AT]
        starts = [joint["q"][0] + QUATERNION_AT[joint["kind"]] for joint in turning]
        self._quaternions = np.array(starts, int)[:, None] + np.arange(4)
        links = [*enumerate(self.layout["links"])]
        self.soft = None
        if self.layout.get("deformables"):
            from soft_states import SoftStates

            self.soft = SoftStates(self.layout["deformables"], chunks)
        self._links = {(link["body"], None): i for i, link in reversed(links) if link["link"] != "world"}
        self._links |= {(link["body"], link["link"]): i for i, link in links}

    def position(self, body: str, t: float, link: str | None = None) -> np.ndarray:
        """Position of a link of a body (its first if none is named) at time `t` [m], shape (3,).

        Of a body that deforms it is the mean of its points.
        """
        a, b, w = self.around(t)
        if self.soft is not None and (centre := self.soft.centre(body, (a, b, w))) is not None:
            return centre
        pos = self._pos[:, self._links[body, link]].astype(float)
        return (1 - w) * pos[a] + w * pos[b]

    def qpos(self, t: float) -> np.ndarray:
        """Generalized positions at time `t`, shape (Q,): linear in between, spherically linear for orientations."""
        i, j, w = self.around(t)
        a, b = self._qpos[i].astype(float), self._qpos[j].astype(float)
        qpos = (1 - w) * a + w * b
        qpos[self._quaternions] = _slerp(a[self._quaternions], b[self._quaternions], w)
        return qpos.astype(np.float32)

    def around(self, t: float) -> tuple[int, int, float]:
        """Recorded frames before and after time `t`, and how far `t` is from the one to the other, 0 to 1."""
        last = len(self.time) - 1
        b = min(int(np.searchsorted(self.time, t)), last)
        a = max(b - 1, 0)
        return a, b, 1.0 if a == b else float(np.clip((t - self.time[a]) / (self.time[b] - self.time[a]), 0.0, 1.0))


def film(scene, cameras: dict, out: Path, *, fps, camera_pose, speed=1.0, start=0.0, end=None, samples=8) -> None:
    """Films recorded states, whether they were simulated a moment ago or by another process.

    Args:
        scene: Scene of the same program, built by `build`. Its rigid state is overwritten.
        cameras: Name -> camera added to the scene; the first films `video.mp4`, others `video_<name>.mp4`.
        out: Folder of the run, with `states/`.
        fps: Frames of film per second of film.
        speed: Simulated seconds per second of film.
        start: Simulated time of the first frame [s].
        end: Simulated time of the last frame [s]; the end of the recording if that is earlier.
        camera_pose: Function of (name, t, states) that returns (pos, lookat, up) of a camera.
        samples: Frames to keep as `frames/<camera>_<k>.png`, each with the share of the picture that each body fills.

    Raises:
        NoOpenGL: The machine has no usable OpenGL.
    """
    from PIL import Image

    out, states, progress = Path(out), States(out), Progress(out)
    soft = None
    if states.soft is not None:
        from soft_film import SoftFilm

        soft = SoftFilm(scene, states.soft, out / "geometry")
    _open_opengl(scene, cameras)
    (out / "frames").mkdir(exist_ok=True)
    last = float(states.time[-1])
    end = last if end is None else min(end, last)
    n_frames = max(1, round((end - start) / speed * fps))
    sampled = np.unique(np.linspace(0, n_frames - 1, samples).round().astype(int)).tolist()
    main = next(iter(cameras))
    paths = {name: out / ("video.mp4" if name == main else f"video_{name}.mp4") for name in cameras}
    videos = {name: _Video(paths[name], camera.res, fps) for name, camera in cameras.items()}
    visibility = {name: [] for name in cameras}
    for k in range(n_frames):
        t = start + k * speed / fps
        if scene.rigid_solver.n_qs:
            scene.rigid_solver.set_qpos(states.qpos(t))
        if soft is not None:
            soft.show(states.around(t))
        for name, camera in cameras.items():
            pos, lookat, up = camera_pose(name, t, states)
            camera.set_pose(pos=pos, lookat=lookat, up=up)
            # Genesis redraws when the step count moves, which it does not here: force it, once for all cameras.
            image = camera.render(force_render=name == main)[0]
            videos[name].write(image)
            if k == 0 and name == main:
                Image.fromarray(image).save(out / "first.png")
            if k in sampled:
                Image.fromarray(image).save(out / "frames" / f"{name}_{sampled.index(k)}.png")
                visibility[name].append({"t": t, "shares": _shares(scene, camera, states.layout)})
        progress("film", t - start, end - start, force=k in (0, n_frames - 1))
    for video in videos.values():
        video.close()
    if soft is not None:
        soft.close()
    write_json(out / "visibility.json", visibility)


def _open_opengl(scene, cameras: dict) -> None:
    try:
        if not scene.visualizer.is_built:
            scene.visualizer.build()
        next(iter(cameras.values())).render(force_render=True)
    except Exception as error:  # EGL, OSMesa, GLX and pyglet each raise their own
        raise NoOpenGL(f"cannot draw: {error or type(error).__name__}") from error


def _shares(scene, camera, layout: dict) -> dict[str, float]:
    """Fraction of the picture that each visible body fills."""
    pixels = np.bincount(camera.render(rgb=False, segmentation=True)[2].ravel())
    shares = {}
    for index in np.flatnonzero(pixels).tolist():
        key = scene.segmentation_idx_dict[index]
        # (entity, link), as VisOptions has it by default, or the name of a body that deforms; the background is -1
        body = layout["links"][key[1]]["body"] if isinstance(key, tuple) else key
        if isinstance(body, str):
            shares[body] = shares.get(body, 0.0) + pixels[index] / pixels.sum()
    return {body: round(float(share), 6) for body, share in sorted(shares.items())}


class _Video:
    """An H.264 file that browsers play, written frame by frame and named only when whole."""

    def __init__(self, path: Path, size: tuple[int, int], fps: float):
        import av

        self._av, self._path, self._part = av, path, path.with_name(path.name + ".part")
        self._container = av.open(str(self._part), "w", format="mp4", options={"movflags": "+faststart"})
        self._stream = self._container.add_stream("libx264", rate=Fraction(fps).limit_denominator(1000))
        self._stream.width, self._stream.height, self._stream.pix_fmt = *size, "yuv420p"
        self._stream.options = {"crf": "18", "preset": "medium", "threads": "2"}  # the bytes depend on the threads
        codec = self._stream.codec_context
        codec.colorspace = codec.color_primaries = codec.color_trc = codec.color_range = 1  # BT.709, limited range

    def write(self, image: np.ndarray) -> None:
        """Appends one picture, shape (height, width, 3), uint8."""
        frame = self._av.VideoFrame.from_ndarray(image, format="rgb24")
        frame = frame.reformat(format="yuv420p", dst_colorspace="ITU709", dst_color_range="MPEG")
        self._container.mux(self._stream.encode(frame))

    def close(self) -> None:
        self._container.mux(self._stream.encode())
        self._container.close()
        os.replace(self._part, self._path)


def _slerp(a: np.ndarray, b: np.ndarray, w: float) -> np.ndarray:
    """Turns by the fraction w of the short way from orientations a to b, shape (..., 4)."""
    cosine = (a * b).sum(axis=-1, keepdims=True)
    angle = np.arccos(np.abs(cosine).clip(0.0, 1.0))
    near = angle < 1e-4
    sine = np.where(near, 1.0, np.sin(angle))
    wa = np.where(near, 1 - w, np.sin((1 - w) * angle) / sine)
    wb = np.where(near, w, np.sin(w * angle) / sine)
    quat = wa * a + np.where(cosine < 0, -wb, wb) * b
    return quat / np.linalg.norm(quat, axis=-1, keepdims=True)
