"""The bodies of sand_hourglass: everything that moves."""

from pathlib import Path

import genesis as gs
from filling import weigh
from grid_step import skip_far
from solid_walls import keep_out
from transfers import transfer_in_turn

HERE = Path(__file__).resolve().parent

# Deformable bodies: kind, solver, distance of points at rest [m], pose of the frame at the start.
DEFORMABLES = {
    "sand": {
        "kind": "granular",
        "solver": "mpm",
        "spacing": 0.009984,
        "pos": (0.0, 0.0, 0.47),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
}

# Masses of bodies that consist of particles [kg].
MASSES = {
    "sand": 5.08435355,
}


def add_sand(scene):
    """Add sand."""
    return {
        # case.yaml:39
        "sand": scene.add_entity(
            gs.morphs.Cylinder(radius=0.085, height=0.14, pos=(0.0, 0.0, 0.47)),
            material=gs.materials.MPM.Sand(E=500000.0, nu=0.2, rho=1600.0, friction_angle=35.0),
            surface=gs.surfaces.Default(
                color=(0.8627, 0.702, 0.4039, 1.0), roughness=1.0, metallic=0.0, vis_mode="particle"
            ),
            name="sand",
        )
    }


def add_bodies(scene):
    """Add all bodies that move; return the entities by name."""
    bodies = {
        **add_sand(scene),
    }
    weigh(bodies, MASSES)
    return bodies


def configure(bodies):
    """Apply the settings that need a built scene."""
    skip_far(bodies["sand"].sim)
    transfer_in_turn(bodies["sand"].sim)
    keep_out(
        [
            bodies["sand"],
        ],
        every=4,
    )
