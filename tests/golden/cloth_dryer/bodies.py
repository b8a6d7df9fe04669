"""The bodies of cloth_dryer: everything that moves."""

from pathlib import Path

import genesis as gs

HERE = Path(__file__).resolve().parent

# What deforms: kind of body, solver, distance of its points at rest [m], where its frame is placed.
DEFORMABLES = {
    "cloth[0]": {
        "kind": "cloth",
        "solver": "pbd",
        "spacing": 0.015,
        "pos": (0.0, 0.0, -0.12),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "cloth[1]": {
        "kind": "cloth",
        "solver": "pbd",
        "spacing": 0.015,
        "pos": (0.0, 0.0, -0.089),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "cloth[2]": {
        "kind": "cloth",
        "solver": "pbd",
        "spacing": 0.015,
        "pos": (0.0, 0.0, -0.058),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "cloth[3]": {
        "kind": "cloth",
        "solver": "pbd",
        "spacing": 0.015,
        "pos": (0.0, 0.0, -0.027),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "cloth[4]": {
        "kind": "cloth",
        "solver": "pbd",
        "spacing": 0.015,
        "pos": (0.0, 0.0, 0.004),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
    "cloth[5]": {
        "kind": "cloth",
        "solver": "pbd",
        "spacing": 0.015,
        "pos": (0.0, 0.0, 0.035),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
}


def add_drum(scene):
    """Add drum."""
    return {
        # case.yaml:15
        "drum": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/drum.xml"),
                pos=(0.0, 0.0, 0.0),
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(coup_friction=0.6),
            name="drum",
        )
    }


def add_cloth(scene):
    """Add 6 copies of cloth."""
    copies = [
        # pos, color
        ((0.0, 0.0, -0.12), (0.8196, 0.2863, 0.3569, 1.0)),
        ((0.0, 0.0, -0.089), (0.9294, 0.6824, 0.2863, 1.0)),
        ((0.0, 0.0, -0.058), (0.2471, 0.6118, 0.4863, 1.0)),
        ((0.0, 0.0, -0.027), (0.2353, 0.4314, 0.6235, 1.0)),
        ((0.0, 0.0, 0.004), (0.9412, 0.5412, 0.2941, 1.0)),
        ((0.0, 0.0, 0.035), (0.6902, 0.4863, 0.7765, 1.0)),
    ]
    return {
        # case.yaml:18
        f"cloth[{i}]": scene.add_entity(
            gs.morphs.Mesh(
                file=str(HERE / "models/cloth.obj"),
                pos=pos,
            ),
            material=gs.materials.PBD.Cloth(
                rho=0.25,
                static_friction=0.3,
                kinetic_friction=0.3,
                stretch_compliance=1e-07,
                bending_compliance=0.001,
                air_resistance=0.001,
            ),
            surface=gs.surfaces.Default(color=color, roughness=1.0, metallic=0.0),
            name=f"cloth[{i}]",
        )
        for i, (pos, color) in enumerate(copies)
    }


def add_bodies(scene):
    """Add everything that moves; return the entities by name."""
    return {
        **add_drum(scene),
        **add_cloth(scene),
    }


# Body, joint, stiffness kp, damping kv, largest force [N or N m].
MOTORS = [
    ("drum", "drum", 0.0, 5000.0, 5000.0),
]


def configure(bodies):
    """Set what can be set only after the scene is built."""
    for name, joint, kp, kv, limit in MOTORS:
        dofs = bodies[name].get_joint(joint).dofs_idx_local
        bodies[name].set_dofs_kp([kp] * len(dofs), dofs)
        bodies[name].set_dofs_kv([kv] * len(dofs), dofs)
        if limit is not None:
            bodies[name].set_dofs_force_range([-limit] * len(dofs), [limit] * len(dofs), dofs)
