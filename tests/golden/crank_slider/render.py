"""The film of crank_slider: cadence, cameras, shots and lights, as plain data. Nothing here affects the physics.

`viewpoints.py`, `cameras.py` and `cadence.py` interpret these constants; `film.py` draws the preview. Positions are in m,
times in simulated s, angles in rad except fields of view [deg]. The direction of a light is that in which it shines. Its
strength is the irradiance at the scene, or that at a distance of 1 m for lights with a position.
"""

RESOLUTION = (1280, 720)  # width and height [pixels]
FPS = 25.0  # frames per second of film
SPEED = 1.0  # simulated seconds per second of film
START = 0.0  # span of the run that is shown [s]
END = 6.0
MOTION_BLUR = 0.2  # fraction of the time between two frames in which the shutter is open

# `video.mp4` shows the first camera, unless there are shots.
CAMERAS = {
    "main": {
        "kind": "still",
        "up": (0.0, 0.0, 1.0),
        "fov": 26.9915,
        "f_stop": 8.0,
        "focus": (0.2, 0.0, 0.0),
        "pos": (0.52, -0.94, 0.27),
        "look_at": (0.21, 0.0, -0.025),
    },
}
# Choices that the case leaves open, which `directing.py` makes from the recording.
AUTO = None
# The shots of `video.mp4`, in order.
SHOTS = []

BACKGROUND = (0.4196, 0.4549, 0.4902)
AMBIENT = 0.35  # ambient light of the preview, which has no indirect light
LIGHTS = {
    "key": {
        "kind": "softbox",
        "strength": 3.2,
        "color": (1.0, 0.9647, 0.9255),
        "direction": (0.5713, 0.6623, -1.0),
        "at": (0.22, -0.01, -0.155),
        "distance": 2.41,
        "size": 0.578,
    },
    "rim": {
        "kind": "softbox",
        "strength": 1.1,
        "color": (0.8392, 0.8941, 1.0),
        "direction": (-0.2879, -1.0426, -1.4),
        "at": (0.22, -0.01, -0.155),
        "distance": 2.41,
        "size": 0.578,
    },
    "front": {
        "kind": "sun",
        "strength": 0.3,
        "color": (1.0, 1.0, 1.0),
        "direction": (-0.5506, 0.8714, -0.3),
        "angle": 0.87266,
    },
    "fill": {
        "kind": "environment",
        "strength": 0.12,
        "color": (0.9333, 0.9529, 0.9804),
        "horizon": (0.8745, 0.8902, 0.9098),
    },
}
BACKDROP = {
    "kind": "cyclorama",
    "level": -0.16,
    "center": (0.22, -0.01, -0.155),
    "radius": 4.821,
    "planes": [],
    "supports": True,
}
GAIN = 1.2885  # exposure, derived from the lights
TONE = "agx"
OVERLAY = {"title": None, "time": False, "values": [], "inset": False}
