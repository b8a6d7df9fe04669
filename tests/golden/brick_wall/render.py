"""The film of brick_wall: cadence, cameras, shots and light, as plain data. Nothing here can touch the physics.

`cameras.py` and `cadence.py` say what the words mean; `film.py` draws the preview. Positions are in m, times in simulated s,
angles in rad but for fields of view [deg]. Lights say which way they go; their strength is the irradiance at what they light,
or in a distance of 1 m.
"""

RESOLUTION = (1280, 720)  # width and height [pixels]
FPS = 25.0  # frames per second of film
SPEED = 0.6  # simulated seconds per second of film
START = 0.0  # the part of the run that is shown [s]
END = 4.0
MOTION_BLUR = 0.0  # part of the time between two frames in which the shutter is open

# The first makes `video.mp4`, unless there are shots.
CAMERAS = {
    "main": {
        "kind": "still",
        "up": (0.0, 0.0, 1.0),
        "fov": 42.0,
        "pos": (2.4, -3.2, 1.4),
        "look_at": (0.0, 0.2, 0.35),
    },
}
# One after the other.
SHOTS = []

BACKGROUND = (0.7882, 0.8078, 0.8314)
AMBIENT = 0.35  # light from everywhere in the preview, which has none that is thrown back
LIGHTS = {
    "key": {
        "kind": "softbox",
        "strength": 3.4,
        "color": (1.0, 1.0, 1.0),
        "direction": (-0.55, 0.75, -1.0),
        "at": (0.0, -1.0867, 0.42),
        "distance": 6.93,
        "size": 3.465,
    },
    "fill": {
        "kind": "softbox",
        "strength": 1.0,
        "color": (0.8745, 0.9137, 1.0),
        "direction": (0.9, 0.5, -0.6),
        "at": (0.0, -1.0867, 0.42),
        "distance": 6.93,
        "size": 3.465,
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
    "level": 0.0,
    "center": (0.0, -1.0867, 0.42),
    "radius": 24.256,
    "planes": [],
}
GAIN = 0.805  # brightness: this makes a white sheet white that faces the strongest light
TONE = "agx"
OVERLAY = {"title": None, "time": False, "values": [], "inset": False}
