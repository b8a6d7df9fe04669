"""The film of brick_wall: cadence, cameras, shots and lights, as plain data. Nothing here affects the physics.

`viewpoints.py`, `cameras.py` and `cadence.py` interpret these constants; `film.py` draws the preview. Positions are in m,
times in simulated s, angles in rad except fields of view [deg]. The direction of a light is that in which it shines. Its
strength is the irradiance at the scene, or that at a distance of 1 m for lights with a position.
"""

RESOLUTION = (1280, 720)  # width and height [pixels]
FPS = 25.0  # frames per second of film
SPEED = 0.3  # simulated seconds per second of film
START = 0.0  # span of the run that is shown [s]
END = 2.4
MOTION_BLUR = 0.4  # fraction of the time between two frames in which the shutter is open

# `video.mp4` shows the first camera, unless there are shots.
CAMERAS = {
    "main": {
        "kind": "still",
        "up": (0.0, 0.0, 1.0),
        "fov": 37.8493,
        "f_stop": 5.6,
        "focus": (0.0, 0.0, 0.45),
        "pos": (1.55, -2.55, 0.8),
        "look_at": (0.1, 0.25, 0.42),
    },
}
# Choices that the case leaves open, which `directing.py` makes from the recording.
AUTO = None
# The shots of `video.mp4`, in order.
SHOTS = []

BACKGROUND = (0.8667, 0.8902, 0.9098)
AMBIENT = 0.35  # ambient light of the preview, which has no indirect light
LIGHTS = {
    "sun": {
        "kind": "sun",
        "strength": 3.0,
        "color": (1.0, 0.9412, 0.8706),
        "direction": (-0.8, 0.45, -0.85),
        "angle": 0.05236,
    },
    "sky": {
        "kind": "environment",
        "strength": 0.3,
        "color": (0.8118, 0.8784, 0.9608),
        "horizon": (0.9255, 0.9373, 0.949),
    },
}
BACKDROP = {
    "kind": "horizon",
    "level": 0.0,
    "center": (0.0, -1.0867, 0.42),
    "radius": 13.861,
    "planes": [],
    "floor": {"pattern": "slabs", "color": (0.6627, 0.6431, 0.6078), "tile": 0.5},
    "sky": (0.5255, 0.6941, 0.8706),
    "skyline": "wood",
    "supports": True,
    "own_lights": True,
}
GAIN = 0.8044  # exposure, derived from the lights
TONE = "agx"
OVERLAY = {"title": None, "time": False, "values": [], "inset": False}
