"""The film of snow_plough: cadence, cameras, shots and light, as plain data. Nothing here can touch the physics.

`cameras.py` and `cadence.py` say what the words mean; `film.py` draws the preview. Positions are in m, times in simulated s,
angles in rad but for fields of view [deg]. Lights say which way they go; their strength is the irradiance at what they light,
or in a distance of 1 m.
"""

RESOLUTION = (1280, 720)  # width and height [pixels]
FPS = 25.0  # frames per second of film
SPEED = 0.7  # simulated seconds per second of film
START = 0.0  # the part of the run that is shown [s]
END = 2.4
MOTION_BLUR = 0.0  # part of the time between two frames in which the shutter is open

# The first makes `video.mp4`, unless there are shots.
CAMERAS = {
    "main": {
        "kind": "still",
        "up": (0.0, 0.0, 1.0),
        "fov": 33.3985,
        "f_stop": 8.0,
        "pos": (1.05, -1.2, 0.6),
        "look_at": (0.08, 0.0, 0.02),
    },
}
# One after the other.
SHOTS = []

BACKGROUND = (0.902, 0.8039, 0.698)
AMBIENT = 0.35  # light from everywhere in the preview, which has none that is thrown back
LIGHTS = {
    "sun": {
        "kind": "sun",
        "strength": 3.4,
        "color": (1.0, 0.6902, 0.4),
        "direction": (0.5113, 0.7991, -0.32),
        "angle": 0.03491,
    },
    "sky": {
        "kind": "environment",
        "strength": 0.4,
        "color": (0.4902, 0.6235, 0.8157),
        "horizon": (1.0, 0.851, 0.6902),
    },
}
BACKDROP = {
    "kind": "horizon",
    "level": None,
    "center": (0.0, 0.0, -0.05),
    "radius": 24.996,
    "planes": [],
}
GAIN = 0.71  # brightness: this makes a white sheet white that faces the strongest light
TONE = "agx"
OVERLAY = {"title": None, "time": False, "values": [], "inset": False}
