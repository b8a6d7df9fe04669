"""The film of curtains: cadence, cameras, shots and lights, as plain data. Nothing here affects the physics.

`viewpoints.py`, `cameras.py` and `cadence.py` interpret these constants; `film.py` draws the preview. Positions are in m,
times in simulated s, angles in rad except fields of view [deg]. The direction of a light is that in which it shines. Its
strength is the irradiance at the scene, or that at a distance of 1 m for lights with a position.
"""

RESOLUTION = (1280, 720)  # width and height [pixels]
FPS = 25.0  # frames per second of film
SPEED = 1.4  # simulated seconds per second of film
START = 0.0  # span of the run that is shown [s]
END = 9.0
MOTION_BLUR = 0.0  # fraction of the time between two frames in which the shutter is open

# `video.mp4` shows the first camera, unless there are shots.
CAMERAS = {
    "main": {
        "kind": "still",
        "up": (0.0, 0.0, 1.0),
        "fov": 31.8908,
        "pos": (0.8, -4.2, 1.35),
        "look_at": (0.0, 0.0, 1.24),
    },
}
# Choices that the case leaves open, which `directing.py` makes from the recording.
AUTO = None
# The shots of `video.mp4`, in order.
SHOTS = []

BACKGROUND = (0.7882, 0.8078, 0.8314)
AMBIENT = 0.35  # ambient light of the preview, which has no indirect light
LIGHTS = {
    "key": {
        "kind": "softbox",
        "strength": 3.2,
        "color": (1.0, 0.9647, 0.9255),
        "direction": (0.6526, 0.5824, -1.0),
        "at": (0.0, 0.0, 1.615),
        "distance": 9.67,
        "size": 2.321,
    },
    "rim": {
        "kind": "softbox",
        "strength": 1.1,
        "color": (0.8392, 0.8941, 1.0),
        "direction": (-0.421, -0.9964, -1.4),
        "at": (0.0, 0.0, 1.615),
        "distance": 9.67,
        "size": 2.321,
    },
    "front": {
        "kind": "sun",
        "strength": 0.3,
        "color": (1.0, 1.0, 1.0),
        "direction": (-0.4327, 0.9356, -0.3),
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
    "level": 0.0,
    "center": (0.0, 0.0, 1.615),
    "radius": 19.34,
    "planes": [],
    "supports": True,
}
GAIN = 1.2022  # exposure, derived from the lights
TONE = "agx"
OVERLAY = {"title": None, "time": False, "values": [], "inset": False}
