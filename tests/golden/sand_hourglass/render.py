"""The film of sand_hourglass: cadence, cameras, shots and lights, as plain data. Nothing here affects the physics.

`viewpoints.py`, `cameras.py` and `cadence.py` interpret these constants; `film.py` draws the preview. Positions are in m,
times in simulated s, angles in rad except fields of view [deg]. The direction of a light is that in which it shines. Its
strength is the irradiance at the scene, or that at a distance of 1 m for lights with a position.
"""

RESOLUTION = (1280, 720)  # width and height [pixels]
FPS = 25.0  # frames per second of film
SPEED = 0.4  # simulated seconds per second of film
START = 0.0  # span of the run that is shown [s]
END = 3.5
MOTION_BLUR = 0.0  # fraction of the time between two frames in which the shutter is open

# `video.mp4` shows the first camera, unless there are shots.
CAMERAS = {
    "main": {
        "kind": "still",
        "up": (0.0, 0.0, 1.0),
        "fov": 31.8908,
        "f_stop": 5.6,
        "pos": (0.55, -1.35, 0.42),
        "look_at": (0.0, 0.0, 0.225),
    },
}
# Choices that the case leaves open, which `directing.py` makes from the recording.
AUTO = None
# The shots of `video.mp4`, in order.
SHOTS = [
    {"name": "runs_out", "camera": "main", "from": 0.0, "to": 1.7, "speed": 0.4, "hold": 0.0},
]

BACKGROUND = (0.2902, 0.2667, 0.2392)
AMBIENT = 0.12  # ambient light of the preview, which has no indirect light
LIGHTS = {
    "key": {
        "kind": "softbox",
        "strength": 3.0,
        "color": (1.0, 0.9451, 0.8784),
        "direction": (0.0429, 0.5574, -1.0),
        "at": (0.0, 0.0, 0.1835),
        "distance": 2.325,
        "size": 0.558,
    },
    "rim": {
        "kind": "softbox",
        "strength": 1.2,
        "color": (0.8588, 0.898, 0.9686),
        "direction": (-0.1612, -0.9295, -1.3),
        "at": (0.0, 0.0, 0.1835),
        "distance": 2.325,
        "size": 0.558,
    },
    "fill": {
        "kind": "environment",
        "strength": 0.02,
        "color": (0.502, 0.5647, 0.6902),
        "horizon": (0.251, 0.2824, 0.3451),
    },
}
BACKDROP = {
    "kind": "cyclorama",
    "level": -0.06,
    "center": (0.0, 0.0, 0.1835),
    "radius": 4.65,
    "planes": [],
    "supports": True,
}
GAIN = 1.1858  # exposure, derived from the lights
TONE = "agx"
OVERLAY = {"title": None, "time": False, "values": [], "inset": False}
