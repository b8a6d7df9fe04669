"""The bodies of newton_cradle: everything that moves."""

from pathlib import Path

import genesis as gs
import numpy as np

HERE = Path(__file__).resolve().parent


def add_ball(scene):
    """Add 5 copies of ball."""
    copies = [
        # file, pos, quat
        ("models/ball.xml", (-0.490788218, 0.0, 0.390423978), (0.953716951, 0.0, 0.3007058, 0.0)),
        ("models/ball_7ad69371.xml", (-0.102, 0.0, 0.3), (1.0, 0.0, 0.0, 0.0)),
        ("models/ball_7ad69371.xml", (0.0, 0.0, 0.3), (1.0, 0.0, 0.0, 0.0)),
        ("models/ball_7ad69371.xml", (0.102, 0.0, 0.3), (1.0, 0.0, 0.0, 0.0)),
        ("models/ball_56562ebc.xml", (0.204, 0.0, 0.3), (1.0, 0.0, 0.0, 0.0)),
    ]
    return {
        # case.yaml:25
        f"ball[{i}]": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / file),
                pos=pos,
                quat=quat,
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(),
            name=f"ball[{i}]",
        )
        for i, (file, pos, quat) in enumerate(copies)
    }


def add_bodies(scene):
    """Add everything that moves; return the entities by name."""
    return {
        **add_ball(scene),
    }


# Time constant [s] and damping ratio of the contacts of each body: a ratio of 1 lets nothing bounce.
CONTACT_DAMPING = {
    "beam": (0.2, 0.003206),
    "post[0]": (0.2, 0.003206),
    "post[1]": (0.2, 0.003206),
    "table": (0.2, 0.003206),
    "ball[0]": (0.2, 0.003206),
    "ball[1]": (0.2, 0.003206),
    "ball[2]": (0.2, 0.003206),
    "ball[3]": (0.2, 0.003206),
    "ball[4]": (0.2, 0.003206),
}


def configure(bodies):
    """Set what can be set only after the scene is built."""
    # The engine has no restitution: a contact that damps little gives back most of its speed.
    for name, (time, ratio) in CONTACT_DAMPING.items():
        for geom in bodies[name].geoms:
            geom.set_sol_params(np.array([time, ratio, 0.9, 0.95, 0.001, 0.5, 2.0]))
