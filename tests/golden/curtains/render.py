"""The film of curtains: cadence, cameras, shots and light, as plain data. Nothing here can touch the physics.

`cameras.py` and `cadence.py` say what the words mean; `film.py` draws the preview. Positions are in m, times in simulated s,
angles in rad but for fields of view [deg]. Lights say which way they go; their strength is the irradiance at what they light,
or in a distance of 1 m.
"""

RESOLUTION = (1280, 720)  # width and height [pixels]
FPS = 25.0  # frames per second of film
SPEED = 1.4  # simulated seconds per second of film
START = 0.0  # the part of the run that is shown [s]
END = 9.0
MOTION_BLUR = 0.0  # part of the time between two frames in which the shutter is open

# The first makes `video.mp4`, unless there are shots.
CAMERAS = {
    "main": {
        "kind": "still",
        "up": (0.0, 0.0, 1.0),
        "fov": 31.8908,
        "pos": (0.8, -4.2, 1.35),
        "look_at": (0.0, 0.0, 1.24),
    },
}
# What nobody has decided: `directing.py` does, by what was recorded.
AUTO = None
# One after the other.
SHOTS = []

BACKGROUND = (0.7882, 0.8078, 0.8314)
AMBIENT = 0.35  # light from everywhere in the preview, which has none that is thrown back
LIGHTS = {
    "key": {
        "kind": "softbox",
        "strength": 3.2,
        "color": (1.0, 0.9647, 0.9255),
        "direction": (0.6526, 0.5824, -1.0),
        "at": (0.0, 0.0, 1.615),
        "distance": 9.67,
        "size": 3.384,
    },
    "rim": {
        "kind": "softbox",
        "strength": 1.1,
        "color": (0.8392, 0.8941, 1.0),
        "direction": (-0.421, -0.9964, -1.4),
        "at": (0.0, 0.0, 1.615),
        "distance": 9.67,
        "size": 3.384,
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
GAIN = 1.2022  # brightness: this makes a white sheet white that faces the strongest light
TONE = "agx"
OVERLAY = {"title": None, "time": False, "values": [], "inset": False}
