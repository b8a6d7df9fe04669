"""The bodies of pour: everything that moves."""

from pathlib import Path

import genesis as gs
from filling import weigh
from grid_step import skip_far
from hardening_snow import HardeningSnow
from liquid_volume import keep_volume
from scene import DT
from solid_walls import keep_out
from transfers import transfer_in_turn

HERE = Path(__file__).resolve().parent

# Deformable bodies: kind, solver, distance of points at rest [m], pose of the frame at the start.
DEFORMABLES = {
    "sand": {
        "kind": "granular",
        "solver": "mpm",
        "spacing": 0.0064,
        "pos": (-0.3, 0.0, 0.16),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "water": {
        "kind": "liquid",
        "solver": "mpm",
        "spacing": 0.0064,
        "pos": (0.0, 0.0, 0.16),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "snow": {"kind": "snow", "solver": "mpm", "spacing": 0.0064, "pos": (0.3, 0.0, 0.16), "quat": (1.0, 0.0, 0.0, 0.0)},
}

# Masses of bodies that consist of particles [kg].
MASSES = {
    "sand": 1.25663706,
    "water": 0.64,
    "snow": 0.0628318531,
}


def add_sand(scene):
    """Add sand."""
    return {
        # case.yaml:13
        "sand": scene.add_entity(
            gs.morphs.Cylinder(radius=0.05, height=0.1, pos=(-0.3, 0.0, 0.16)),
            material=gs.materials.MPM.Sand(E=500000.0, nu=0.2, rho=1600.0, friction_angle=30.0),
            surface=gs.surfaces.Default(
                color=(0.7843, 0.6627, 0.4157, 1.0), roughness=0.9, metallic=0.0, vis_mode="particle"
            ),
            name="sand",
        )
    }


def add_water(scene):
    """Add water."""
    return {
        # case.yaml:18
        "water": scene.add_entity(
            gs.morphs.Box(size=(0.08, 0.08, 0.1), pos=(0.0, 0.0, 0.16)),
            material=gs.materials.MPM.Liquid(E=1800000.0, nu=0.2, rho=1000.0, viscous=False),
            surface=gs.surfaces.Default(
                color=(0.2471, 0.5333, 0.7725, 1.0), roughness=0.05, metallic=0.0, vis_mode="particle"
            ),
            name="water",
        )
    }


def add_snow(scene):
    """Add snow."""
    return {
        # case.yaml:22
        "snow": scene.add_entity(
            gs.morphs.Mesh(
                file=str(HERE / "models/snow.obj"),
                pos=(0.3, 0.0, 0.16),
            ),
            material=HardeningSnow(
                substep=DT / 142, cell=0.01, E=500000.0, nu=0.2, rho=300.0, yield_lower=0.025, yield_higher=0.0045
            ),
            surface=gs.surfaces.Default(
                color=(0.9451, 0.9569, 0.9686, 1.0), roughness=0.9, metallic=0.0, vis_mode="particle"
            ),
            name="snow",
        )
    }


def add_bodies(scene):
    """Add all bodies that move; return the entities by name."""
    bodies = {
        **add_sand(scene),
        **add_water(scene),
        **add_snow(scene),
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
            bodies["water"],
            bodies["snow"],
        ],
        every=35,
    )
    keep_volume(bodies, {"sand": 1600.0, "water": 1000.0, "snow": 300.0}, ["water"], every=35)
