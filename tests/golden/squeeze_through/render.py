"""The film of squeeze_through: cadence, cameras, shots and light, as plain data. Nothing here can touch the physics.

`cameras.py` and `cadence.py` say what the words mean; `film.py` draws the preview. Positions are in m, times in simulated s,
angles in rad but for fields of view [deg]. Lights say which way they go; their strength is the irradiance at what they light,
or in a distance of 1 m.
"""

RESOLUTION = (1280, 720)  # width and height [pixels]
FPS = 25.0  # frames per second of film
SPEED = 0.25  # simulated seconds per second of film
START = 0.0  # the part of the run that is shown [s]
END = 1.3
MOTION_BLUR = 0.0  # part of the time between two frames in which the shutter is open

# The first makes `video.mp4`, unless there are shots.
CAMERAS = {
    "main": {
        "kind": "still",
        "up": (0.0, 0.0, 1.0),
        "fov": 35.0511,
        "pos": (0.42, -1.38, 0.3),
        "look_at": (0.2, 0.0, -0.01),
    },
}
# What nobody has decided: `directing.py` does, by what was recorded.
AUTO = None
# One after the other.
SHOTS = []

BACKGROUND = (0.3216, 0.3647, 0.4118)
AMBIENT = 0.35  # light from everywhere in the preview, which has none that is thrown back
LIGHTS = {
    "key": {
        "kind": "softbox",
        "strength": 3.0,
        "color": (1.0, 0.9647, 0.9255),
        "direction": (0.9, 0.4, -0.6),
        "at": (-0.064, 0.0, 0.0),
        "distance": 1.902,
        "size": 0.666,
    },
    "rim": {
        "kind": "softbox",
        "strength": 1.6,
        "color": (0.8588, 0.898, 0.9686),
        "direction": (-0.9, -0.5, -0.35),
        "at": (-0.064, 0.0, 0.0),
        "distance": 1.902,
        "size": 0.666,
    },
    "fill": {
        "kind": "environment",
        "strength": 0.1,
        "color": (0.9333, 0.9529, 0.9804),
        "horizon": (0.8745, 0.8902, 0.9098),
    },
}
BACKDROP = {
    "kind": "cyclorama",
    "level": None,
    "center": (-0.064, 0.0, 0.0),
    "radius": 3.804,
    "planes": [],
    "supports": True,
}
GAIN = 1.5428  # brightness: this makes a white sheet white that faces the strongest light
TONE = "agx"
OVERLAY = {"title": None, "time": False, "values": [], "inset": False}
