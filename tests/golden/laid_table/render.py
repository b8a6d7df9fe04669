"""The film of laid_table: cadence, cameras, shots and light, as plain data. Nothing here can touch the physics.

`cameras.py` and `cadence.py` say what the words mean; `film.py` draws the preview. Positions are in m, times in simulated s,
angles in rad but for fields of view [deg]. Lights say which way they go; their strength is the irradiance at what they light,
or in a distance of 1 m.
"""

RESOLUTION = (1280, 720)  # width and height [pixels]
FPS = 25.0  # frames per second of film
SPEED = 0.4  # simulated seconds per second of film
START = 0.0  # the part of the run that is shown [s]
END = 2.5
MOTION_BLUR = 0.4  # part of the time between two frames in which the shutter is open

# The first makes `video.mp4`, unless there are shots.
CAMERAS = {
    "main": {
        "kind": "keyframed",
        "up": (0.0, 0.0, 1.0),
        "fov": 33.3985,
        "f_stop": 4.0,
        "focus": (0.1, 0.15, 0.85),
        "times": [0.0, 0.35, 1.5],
        "positions": [(0.8, -0.92, 1.24), (0.8, -0.92, 1.24), (1.3, -1.7, 1.4)],
        "look_at": [(0.1, 0.08, 0.79), (0.1, 0.08, 0.79), (0.62, 0.15, 0.52)],
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
        "direction": (0.3564, 0.7988, -1.0),
        "at": (0.0, 0.0, 0.725),
        "distance": 6.413,
        "size": 2.245,
    },
    "rim": {
        "kind": "softbox",
        "strength": 1.1,
        "color": (0.8392, 0.8941, 1.0),
        "direction": (0.0246, -1.0814, -1.4),
        "at": (0.0, 0.0, 0.725),
        "distance": 6.413,
        "size": 2.245,
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
    "center": (0.0, 0.0, 0.725),
    "radius": 12.826,
    "planes": [],
    "supports": True,
}
GAIN = 1.2885  # brightness: this makes a white sheet white that faces the strongest light
TONE = "agx"
OVERLAY = {"title": None, "time": False, "values": [], "inset": False}
