"""The bodies of squash: everything that moves."""

from pathlib import Path

import genesis as gs
from corotated import Corotated
from filling import weigh
from grid_step import skip_far
from transfers import transfer_in_turn

HERE = Path(__file__).resolve().parent

# Deformable bodies: kind, solver, distance of points at rest [m], pose of the frame at the start.
DEFORMABLES = {
    "block[0]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.00768,
        "pos": (-0.1, 0.0, 0.2),
        "quat": (0.984807753, 0.0, 0.0, 0.173648178),
    },
    "block[1]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.00768,
        "pos": (0.05, 0.0, 0.22),
        "quat": (0.984807753, 0.0, 0.0, 0.173648178),
    },
    "block[2]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.00768,
        "pos": (0.2, 0.0, 0.24),
        "quat": (0.984807753, 0.0, 0.0, 0.173648178),
    },
    "lump": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.00768,
        "pos": (0.0, 0.15, 0.3),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
}

# Masses of bodies that consist of particles [kg].
MASSES = {
    "block[0]": 0.2592,
    "block[1]": 0.2592,
    "block[2]": 0.2592,
    "lump": 0.268082573,
}


def add_block(scene):
    """Add 3 copies of block."""
    copies = [
        # pos, color, E
        ((-0.1, 0.0, 0.2), (1.0, 0.0, 0.0, 1.0), 50000.0),
        ((0.05, 0.0, 0.22), (0.0, 0.502, 0.0, 1.0), 100000.0),
        ((0.2, 0.0, 0.24), (0.0, 0.0, 1.0, 1.0), 150000.0),
    ]
    return {
        # case.yaml:11
        f"block[{i}]": scene.add_entity(
            gs.morphs.Mesh(
                file=str(HERE / "models/block.obj"),
                pos=pos,
                quat=(0.984807753, 0.0, 0.0, 0.173648178),
            ),
            material=Corotated(E=E, nu=0.35, rho=900.0),
            surface=gs.surfaces.Default(color=color, roughness=0.9, metallic=0.0, vis_mode="particle"),
            name=f"block[{i}]",
        )
        for i, (pos, color, E) in enumerate(copies)
    }


def add_lump(scene):
    """Add lump."""
    return {
        # case.yaml:18
        "lump": scene.add_entity(
            gs.morphs.Mesh(
                file=str(HERE / "models/lump.obj"),
                pos=(0.0, 0.15, 0.3),
            ),
            material=gs.materials.MPM.ElastoPlastic(E=100000.0, nu=0.3, rho=1000.0, von_mises_yield_stress=1632.99),
            surface=gs.surfaces.Default(
                color=(0.8353, 0.3686, 0.0, 1.0), roughness=0.9, metallic=0.0, vis_mode="particle"
            ),
            name="lump",
        )
    }


def add_weight(scene):
    """Add weight."""
    return {
        # case.yaml:23
        "weight": scene.add_entity(
            gs.morphs.Box(size=(0.1, 0.1, 0.05), pos=(0.0, 0.15, 0.5)),
            material=gs.materials.Rigid(rho=2000.0, friction=0.5, coup_friction=0.5, coup_softness=0.0015),
            surface=gs.surfaces.Default(color=(0.3373, 0.7059, 0.9137, 1.0), roughness=0.9, metallic=0.0),
            name="weight",
        )
    }


def add_bodies(scene):
    """Add all bodies that move; return the entities by name."""
    bodies = {
        **add_block(scene),
        **add_lump(scene),
        **add_weight(scene),
    }
    weigh(bodies, MASSES)
    return bodies


def configure(bodies):
    """Apply the settings that need a built scene."""
    skip_far(bodies["block[0]"].sim)
    transfer_in_turn(bodies["block[0]"].sim)
