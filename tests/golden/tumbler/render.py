"""The film of tumbler: cadence, cameras, shots and light, as plain data. Nothing here can touch the physics.

`cameras.py` and `cadence.py` say what the words mean; `film.py` draws the preview. Positions are in m, times in simulated s,
angles in rad but for fields of view [deg]. Lights say which way they go; their strength is the irradiance at what they light,
or in a distance of 1 m.
"""

RESOLUTION = (1280, 720)  # width and height [pixels]
FPS = 25.0  # frames per second of film
SPEED = 1.0  # simulated seconds per second of film
START = 0.0  # the part of the run that is shown [s]
END = 7.0
MOTION_BLUR = 0.0  # part of the time between two frames in which the shutter is open

# The first makes `video.mp4`, unless there are shots.
CAMERAS = {
    "main": {
        "kind": "still",
        "up": (0.0, 0.0, 1.0),
        "fov": 34.0,
        "pos": (0.35, -2.35, 0.28),
        "look_at": (0.0, 0.0, -0.06),
    },
}
# One after the other.
SHOTS = []

BACKGROUND = (0.7882, 0.8078, 0.8314)
AMBIENT = 0.35  # light from everywhere in the preview, which has none that is thrown back
LIGHTS = {
    "key": {
        "kind": "softbox",
        "strength": 3.2,
        "color": (1.0, 1.0, 1.0),
        "direction": (-0.3, 1.0, -0.6),
        "at": (0.0, 0.0, -0.1729),
        "distance": 5.237,
        "size": 2.619,
    },
    "fill": {
        "kind": "softbox",
        "strength": 1.2,
        "color": (1.0, 1.0, 1.0),
        "direction": (0.8, 0.6, -0.5),
        "at": (0.0, 0.0, -0.1729),
        "distance": 5.237,
        "size": 2.619,
    },
    "ambient": {
        "kind": "environment",
        "strength": 0.16,
        "color": (1.0, 1.0, 1.0),
        "horizon": (1.0, 1.0, 1.0),
    },
}
BACKDROP = {
    "kind": "cyclorama",
    "level": -0.75,
    "center": (0.0, 0.0, -0.1729),
    "radius": 18.33,
    "planes": [],
}
GAIN = 0.8485  # brightness: this makes a white sheet white that faces the strongest light
TONE = "agx"
OVERLAY = {"title": None, "time": False, "values": [], "inset": False}
