"""The film of wrecking_ball: cadence, cameras, shots and light, as plain data. Nothing here can touch the physics.

`cameras.py` and `cadence.py` say what the words mean; `film.py` draws the preview. Positions are in m, times in simulated s,
angles in rad but for fields of view [deg]. Lights say which way they go; their strength is the irradiance at what they light,
or in a distance of 1 m.
"""

RESOLUTION = (1280, 720)  # width and height [pixels]
FPS = 25.0  # frames per second of film
SPEED = 0.6  # simulated seconds per second of film
START = 0.0  # the part of the run that is shown [s]
END = 6.0
MOTION_BLUR = 0.4  # part of the time between two frames in which the shutter is open

# The first makes `video.mp4`, unless there are shots.
CAMERAS = {
    "main": {
        "kind": "still",
        "up": (0.0, 0.0, 1.0),
        "fov": 37.8493,
        "pos": (1.3, -5.4, 1.3),
        "look_at": (0.55, 0.0, 1.18),
    },
}
# What nobody has decided: `directing.py` does, by what was recorded.
AUTO = None
# One after the other.
SHOTS = []

BACKGROUND = (0.8902, 0.902, 0.902)
AMBIENT = 0.35  # light from everywhere in the preview, which has none that is thrown back
LIGHTS = {
    "sun": {
        "kind": "sun",
        "strength": 3.0,
        "color": (1.0, 0.9412, 0.8706),
        "direction": (0.7, 0.5, -0.9),
        "angle": 0.05236,
    },
    "sky": {
        "kind": "environment",
        "strength": 0.32,
        "color": (0.8275, 0.8863, 0.9608),
        "horizon": (0.9412, 0.9373, 0.9255),
    },
}
BACKDROP = {
    "kind": "horizon",
    "level": 0.0,
    "center": (-0.3586, 0.79, 1.6375),
    "radius": 22.81,
    "planes": [],
    "supports": True,
}
GAIN = 0.7922  # brightness: this makes a white sheet white that faces the strongest light
TONE = "agx"
OVERLAY = {"title": None, "time": False, "values": [], "inset": False}
