"""The film of squash: cadence, cameras, shots and lights, as plain data. Nothing here affects the physics.

`viewpoints.py`, `cameras.py` and `cadence.py` interpret these constants; `film.py` draws the preview. Positions are in m,
times in simulated s, angles in rad except fields of view [deg]. The direction of a light is that in which it shines. Its
strength is the irradiance at the scene, or that at a distance of 1 m for lights with a position.
"""

RESOLUTION = (1280, 720)  # width and height [pixels]
FPS = 25.0  # frames per second of film
SPEED = 1.0  # simulated seconds per second of film
START = 0.0  # span of the run that is shown [s]
END = 0.5
MOTION_BLUR = 0.0  # fraction of the time between two frames in which the shutter is open

# `video.mp4` shows the first camera, unless there are shots.
CAMERAS = {
    "main": {
        "kind": "still",
        "up": (0.0, 0.0, 1.0),
        "fov": 32.0,
        "pos": (-0.9214, 1.6752, 0.8398),
        "look_at": (0.0076, -0.0139, 0.3331),
        "frame": {
            "bodies": ["block", "lump", "weight", "step", "rod"],
            "margin": 0.08,
            "within": ((-3.0413, -3.0413, -0.0979), (3.0825, 3.0413, 3.6124)),
            "direction": (-0.55, 1.0, 0.3),
        },
    },
}
# Choices that the case leaves open, which `directing.py` makes from the recording.
AUTO = {
    "times": True,
    "camera": True,
    "turn_lights": True,
    "moving": ["block", "lump", "weight"],
    "statics": ["step", "rod"],
    "standing": ["step", "rod"],
    "clear": [],
}
# The shots of `video.mp4`, in order.
SHOTS = []

BACKGROUND = (0.6627, 0.7843, 0.8745)
AMBIENT = 0.45  # ambient light of the preview, which has no indirect light
LIGHTS = {
    "key": {
        "kind": "softbox",
        "strength": 3.8,
        "color": (1.0, 0.9569, 0.902),
        "direction": (-0.736, -0.6331, -0.85),
        "at": (0.0206, 0.0, 0.3106),
        "distance": 2.382,
        "size": 0.286,
    },
    "rim": {
        "kind": "softbox",
        "strength": 1.2,
        "color": (0.8745, 0.9137, 1.0),
        "direction": (0.276, 0.9507, -1.5),
        "at": (0.0206, 0.0, 0.3106),
        "distance": 2.382,
        "size": 0.286,
    },
    "front": {
        "kind": "sun",
        "strength": 0.16,
        "color": (1.0, 1.0, 1.0),
        "direction": (0.701, -0.7557, -0.3),
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
    "center": (0.0206, 0.0, 0.3106),
    "radius": 4.764,
    "planes": ["floor"],
    "floor": {"pattern": "slabs", "color": (0.5529, 0.5137, 0.4745), "tile": 0.5},
    "wall": "plaster",
    "window": True,
    "supports": True,
}
GAIN = 1.3591  # exposure, derived from the lights
TONE = "agx"
OVERLAY = {"title": None, "time": False, "values": [], "inset": False}
