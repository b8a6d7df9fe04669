"""The bodies of squeeze_through: everything that moves."""

from pathlib import Path

import genesis as gs
from filling import weigh

HERE = Path(__file__).resolve().parent

# What deforms: kind of body, solver, distance of its points at rest [m], where its frame is placed.
DEFORMABLES = {
    "jelly": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.008896,
        "pos": (-0.22, 0.0, 0.0),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
}

# What bodies of particles weigh [kg].
MASSES = {
    "jelly": 2.9489083,
}


def add_jelly(scene):
    """Add jelly."""
    return {
        # case.yaml:33
        "jelly": scene.add_entity(
            gs.morphs.Mesh(
                file=str(HERE / "models/jelly.obj"),
                pos=(-0.22, 0.0, 0.0),
            ),
            material=gs.materials.MPM.Elastic(E=40000.0, nu=0.3, rho=1000.0, model="neohooken"),
            surface=gs.surfaces.Default(
                color=(0.2353, 0.702, 0.4431, 1.0), roughness=0.5, metallic=0.0, vis_mode="particle"
            ),
            name="jelly",
        )
    }


def add_bodies(scene):
    """Add everything that moves; return the entities by name."""
    bodies = {
        **add_jelly(scene),
    }
    weigh(bodies, MASSES)
    return bodies


def configure(bodies):
    """Set what can be set only after the scene is built."""
