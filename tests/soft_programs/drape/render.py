"""The film of drape: cameras, lights and cadence. Nothing here can touch the physics."""

import genesis as gs

RESOLUTION = (1280, 720)  # width and height [pixels]
FPS = 25.0  # frames per second of film
SPEED = 1.0  # simulated seconds per second of film
START, END = 0.0, 0.5  # the part of the run that is shown [s]


def vis_options():
    """Background and lights, which the scene must know when it is made."""
    return gs.options.VisOptions(
        background_color=(0.851, 0.8863, 0.9255),
        ambient_light=(0.35, 0.35, 0.35),
        lights=[
            gs.options.vis.DirectionalLight(dir=(-0.5, 0.8, -1.0), color=(1.0, 1.0, 1.0), intensity=3.6),
        ],
    )


def add_cameras(scene):
    """Add the cameras; return them by name. The first makes `video.mp4`."""
    return {
        "main": scene.add_camera(res=RESOLUTION, fov=40.0, near=0.0379, far=60.0),
    }


def camera_pose(name, t, states):
    """Return where a camera stands, what it looks at, and which way is up, at simulated time `t` [s]."""
    if name == "main":
        return (0.8355, -1.5191, 0.9596), (0.0, 0.0, 0.2), (0.0, 0.0, 1.0)
    raise KeyError(name)
