"""The film of catch_net: cadence, cameras, shots and lights, as plain data. Nothing here affects the physics.

`viewpoints.py`, `cameras.py` and `cadence.py` interpret these constants; `film.py` draws the preview. Positions are in m,
times in simulated s, angles in rad except fields of view [deg]. The direction of a light is that in which it shines. Its
strength is the irradiance at the scene, or that at a distance of 1 m for lights with a position.
"""

RESOLUTION = (1280, 720)  # width and height [pixels]
FPS = 25.0  # frames per second of film
SPEED = 1.0  # simulated seconds per second of film
START = 0.0  # span of the run that is shown [s]
END = 6.0
MOTION_BLUR = 0.4  # fraction of the time between two frames in which the shutter is open

# `video.mp4` shows the first camera, unless there are shots.
CAMERAS = {
    "main": {
        "kind": "still",
        "up": (0.0, 0.0, 1.0),
        "fov": 37.8493,
        "f_stop": 5.6,
        "pos": (1.25, -2.35, 2.35),
        "look_at": (0.05, 0.0, 1.35),
    },
}
# Choices that the case leaves open, which `directing.py` makes from the recording.
AUTO = None
# The shots of `video.mp4`, in order.
SHOTS = [
    {"name": "fall", "camera": "main", "from": 0.0, "to": 1.6, "speed": 0.4, "hold": 0.0},
    {"name": "rest", "camera": "main", "from": 1.6, "to": 2.8, "speed": 1.0, "hold": 0.0},
]

BACKGROUND = (0.6627, 0.7843, 0.8745)
AMBIENT = 0.45  # ambient light of the preview, which has no indirect light
LIGHTS = {
    "key": {
        "kind": "softbox",
        "strength": 3.8,
        "color": (1.0, 0.9569, 0.902),
        "direction": (0.7551, 0.6102, -0.85),
        "at": (0.0, 0.0, 1.6884),
        "distance": 11.37,
        "size": 1.364,
    },
    "rim": {
        "kind": "softbox",
        "strength": 1.2,
        "color": (0.8745, 0.9137, 1.0),
        "direction": (-0.3051, -0.9418, -1.5),
        "at": (0.0, 0.0, 1.6884),
        "distance": 11.37,
        "size": 1.364,
    },
    "front": {
        "kind": "sun",
        "strength": 0.16,
        "color": (1.0, 1.0, 1.0),
        "direction": (-0.6774, 0.7769, -0.3),
        "angle": 0.61087,
    },
    "fill": {
        "kind": "environment",
        "strength": 0.03,
        "color": (0.9412, 0.9569, 0.9843),
        "horizon": (0.902, 0.902, 0.8941),
    },
}
BACKDROP = {
    "kind": "wall",
    "level": 0.0,
    "center": (0.0, 0.0, 1.6884),
    "radius": 22.739,
    "planes": [],
    "floor": {"pattern": "slabs", "color": (0.7255, 0.749, 0.7686), "tile": 1.0},
    "wall": "plaster",
    "window": True,
    "supports": True,
}
GAIN = 0.9131  # exposure, derived from the lights
TONE = "agx"
OVERLAY = {"title": None, "time": False, "values": [], "inset": False}
