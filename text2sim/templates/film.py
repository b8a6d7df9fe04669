"""Films a run of Genesis from its recorded states.

Nothing is drawn during the simulation, so a machine without OpenGL can still simulate.

    OUT/video.mp4, video_<camera>.mp4, first.png, frames/       the films, the first frame, and sampled frames
    OUT/visibility.json                                         share of each sampled frame that each body fills
"""

from pathlib import Path

import numpy as np
from ambience import faded, shaded
from cadence import MAIN, frames, reels
from cameras import Cameras
from directing import directed
from files import write_json
from overlays import Overlay
from playback import States
from recorder import Progress
from video import Video
from viewpoints import clip


class NoOpenGL(RuntimeError):
    """The scene cannot be drawn on this machine. The recording is not affected."""


def vis_options(script: dict):
    """Background and lights for the rasteriser, which has only directional and point lights; softboxes become suns."""
    import genesis as gs

    lights = []
    for light in script["lights"].values():
        if light["kind"] in ("lamp", "spot"):
            lights.append(
                gs.options.vis.PointLight(pos=light["pos"], color=light["color"], intensity=light["strength"])
            )
        elif light["kind"] != "environment":
            color = light.get("color", (1.0, 1.0, 1.0))
            direction = light["direction"]
            lights.append(gs.options.vis.DirectionalLight(dir=direction, color=color, intensity=light["strength"]))
    ambient = (script["ambient"],) * 3
    return gs.options.VisOptions(background_color=script["background"], ambient_light=ambient, lights=lights)


def add_cameras(scene, script: dict) -> dict:
    """Adds the cameras to a scene that is not yet built, and returns them by name."""
    cameras = {}
    for name, camera in script["cameras"].items():
        near, far = clip(camera)
        cameras[name] = scene.add_camera(res=script["resolution"], fov=camera["fov"], near=near, far=far)
    return cameras


def film(scene, cameras: dict, out: Path, script: dict, *, samples: int = 8) -> None:
    """Films the recorded states of this or an earlier run of the program.

    Args:
        scene: Scene of the same program, built by `build`. The positions of its rigid bodies are overwritten.
        cameras: Name -> camera of the scene.
        out: Folder of the run, with `states/`.
        script: Constants of `render.py` by lower-case name.
        samples: Number of frames of each film to keep as `frames/<camera>_<n>.png`, and to measure for
            `visibility.json`.

    Raises:
        NoOpenGL: If the machine has no usable OpenGL.
    """
    from PIL import Image

    out, states, progress = Path(out), States(out), Progress(out)
    soft = None
    if states.soft is not None:
        from soft_film import SoftFilm

        soft = SoftFilm(scene, states.soft, out / "geometry")
    springs = None
    if script.get("springs"):
        from spring_film import SpringFilm

        springs = SpringFilm(scene, states, script["springs"])
    _open_opengl(scene, cameras)
    (out / "frames").mkdir(exist_ok=True)
    script = directed(script, states)
    views, last = Cameras(script, states), float(states.time[-1])
    films = {name: frames(script, reel, last) for name, reel in reels(script).items()}
    grounds = _grounds(scene)
    done, total = 0, sum(map(len, films.values()))
    visibility = {name: [] for name in cameras}
    for name, pictures in films.items():
        video = Video(out / f"{name}.mp4", script["resolution"], script["fps"])
        overlay = Overlay(script) if name == MAIN else None
        sampled = set(np.linspace(0, len(pictures) - 1, samples).round().astype(int).tolist())
        for frame in pictures:
            if scene.rigid_solver.n_qs:
                scene.rigid_solver.set_qpos(states.qpos(frame.t))
            if states.removed:
                _hide(scene.rigid_solver, states, frame.t)
            if soft is not None:
                soft.show(states.around(frame.t))
            if springs is not None:
                springs.show(frame.t)
            camera = cameras[frame.camera]
            view = views.view(frame.camera, frame.t, frame.part)
            camera._fov = view.fov  # Genesis has no public way to change it; the rasteriser reads it with the pose
            camera.set_pose(pos=view.pos, lookat=view.look_at, up=view.up)
            # Genesis redraws only after a step, and there are none here.
            image, depth = camera.render(depth=True, force_render=True)[:2]
            image = shaded(faded(image, depth, view, grounds, script["background"]), depth, view.fov)
            if frame.k in sampled:
                seen = visibility[frame.camera]
                Image.fromarray(image).save(out / "frames" / f"{frame.camera}_{len(seen)}.png")
                seen.append({"t": frame.t, "shares": _shares(scene, camera, states.layout)})
            if overlay is not None:
                image = overlay.draw(image, frame)
            video.write(image)
            if frame.k == 0 and name == MAIN:
                Image.fromarray(image).save(out / "first.png")
            done += 1
            progress("film", done / script["fps"], total / script["fps"], force=done in (1, total))
        video.close()
    if soft is not None:
        soft.close()
    if springs is not None:
        springs.clear()
    write_json(out / "visibility.json", visibility)


def _grounds(scene) -> list:
    """Centre [m] and half the side length [m] of each horizontal ground plane."""
    planes = [entity.morph for entity in scene.rigid_solver.entities if type(entity.morph).__name__ == "Plane"]
    flat = [plane for plane in planes if plane.quat is None or max(map(abs, plane.quat[1:3])) < 1e-3]
    return [(plane.pos, min(plane.plane_size) / 2) for plane in flat]


def _hide(solver, states: States, t: float) -> None:
    """Moves removed bodies out of sight, and those not yet removed back."""
    chosen = [link.idx for link in solver.links if link.parent_idx < 0]
    chosen = [k for k in chosen if states.layout["links"][k]["body"] in states.removed]
    solver.set_base_links_pos(states.poses(t)[0][chosen], chosen, relative=True)


def _open_opengl(scene, cameras: dict) -> None:
    try:
        if not scene.visualizer.is_built:
            scene.visualizer.build()
        next(iter(cameras.values())).render(force_render=True)
    except Exception as error:  # EGL, OSMesa, GLX and pyglet each raise their own
        said = " ".join(str(error).split())[:200]  # some messages have many lines
        raise NoOpenGL(f"cannot draw: {said or type(error).__name__}") from error


def _shares(scene, camera, layout: dict) -> dict[str, float]:
    """Fraction of the picture that each visible body fills."""
    pixels = np.bincount(camera.render(rgb=False, segmentation=True)[2].ravel())
    shares = {}
    for index in np.flatnonzero(pixels).tolist():
        key = scene.segmentation_idx_dict[index]
        # (entity, link) is the default of VisOptions; deformable bodies have their name, and the background has -1
        body = layout["links"][key[1]]["body"] if isinstance(key, tuple) else key
        if isinstance(body, str):
            shares[body] = shares.get(body, 0.0) + pixels[index] / pixels.sum()
    return {body: round(float(share), 6) for body, share in sorted(shares.items())}
