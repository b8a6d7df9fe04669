"""The bodies of soft_press: everything that moves."""

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
        "spacing": 0.009984,
        "pos": (-0.051, -0.051, 0.04),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "block[1]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.009984,
        "pos": (0.051, -0.051, 0.04),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "block[2]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.009984,
        "pos": (-0.051, 0.051, 0.04),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "block[3]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.009984,
        "pos": (0.051, 0.051, 0.04),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "block[4]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.009984,
        "pos": (-0.051, -0.051, 0.142),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "block[5]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.009984,
        "pos": (0.051, -0.051, 0.142),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "block[6]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.009984,
        "pos": (-0.051, 0.051, 0.142),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "block[7]": {
        "kind": "soft",
        "solver": "mpm",
        "spacing": 0.009984,
        "pos": (0.051, 0.051, 0.142),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
}

# Masses of bodies that consist of particles [kg].
MASSES = {
    "block[0]": 0.343,
    "block[1]": 0.343,
    "block[2]": 0.343,
    "block[3]": 0.343,
    "block[4]": 0.343,
    "block[5]": 0.343,
    "block[6]": 0.343,
    "block[7]": 0.343,
}


def add_block(scene):
    """Add 8 copies of block."""
    copies = [
        # pos, color
        ((-0.051, -0.051, 0.04), (0.8196, 0.2863, 0.3569, 1.0)),
        ((0.051, -0.051, 0.04), (0.9294, 0.6824, 0.2863, 1.0)),
        ((-0.051, 0.051, 0.04), (0.2471, 0.6118, 0.4863, 1.0)),
        ((0.051, 0.051, 0.04), (0.2353, 0.4314, 0.6235, 1.0)),
        ((-0.051, -0.051, 0.142), (0.9412, 0.5412, 0.2941, 1.0)),
        ((0.051, -0.051, 0.142), (0.4902, 0.3569, 0.651, 1.0)),
        ((-0.051, 0.051, 0.142), (0.1647, 0.6471, 0.6275, 1.0)),
        ((0.051, 0.051, 0.142), (0.898, 0.5608, 0.6902, 1.0)),
    ]
    return {
        # case.yaml:31
        f"block[{i}]": scene.add_entity(
            gs.morphs.Mesh(
                file=str(HERE / "models/block.obj"),
                pos=pos,
            ),
            material=Corotated(E=50000.0, nu=0.3, rho=1000.0),
            surface=gs.surfaces.Default(color=color, roughness=0.5, metallic=0.0, vis_mode="particle"),
            name=f"block[{i}]",
        )
        for i, (pos, color) in enumerate(copies)
    }


def add_piston(scene):
    """Add piston."""
    return {
        # case.yaml:42
        "piston": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/piston.xml"),
                pos=(0.0, 0.0, 0.68),
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(coup_friction=0.5, coup_softness=0.00195),
            surface=gs.surfaces.Default(color=(0.7255, 0.7608, 0.8, 1.0), roughness=0.45, metallic=0.8),
            name="piston",
        )
    }


def add_bodies(scene):
    """Add all bodies that move; return the entities by name."""
    bodies = {
        **add_block(scene),
        **add_piston(scene),
    }
    weigh(bodies, MASSES)
    return bodies


# Motors: body, joint, stiffness kp, damping kv, largest force [N or N m].
MOTORS = [
    ("piston", "ram", 20000.0, 800.0, 2000.0),
    ("piston", "head", 300.0, 10.0, 300.0),
]


def configure(bodies):
    """Apply the settings that need a built scene."""
    for name, joint, kp, kv, limit in MOTORS:
        dofs = bodies[name].get_joint(joint).dofs_idx_local
        bodies[name].set_dofs_kp([kp] * len(dofs), dofs)
        bodies[name].set_dofs_kv([kv] * len(dofs), dofs)
        if limit is not None:
            bodies[name].set_dofs_force_range([-limit] * len(dofs), [limit] * len(dofs), dofs)
    skip_far(bodies["block[0]"].sim)
    transfer_in_turn(bodies["block[0]"].sim)
