"""The bodies of snow_plough: everything that moves."""

from pathlib import Path

import genesis as gs
from filling import weigh

HERE = Path(__file__).resolve().parent

# What deforms: kind of body, solver, distance of its points at rest [m], where its frame is placed.
DEFORMABLES = {
    "snow": {"kind": "snow", "solver": "mpm", "spacing": 0.0128, "pos": (0.1, 0.0, 0.05), "quat": (1.0, 0.0, 0.0, 0.0)},
}

# What bodies of particles weigh [kg].
MASSES = {
    "snow": 10.8,
}


def add_snow(scene):
    """Add snow."""
    return {
        # case.yaml:19
        "snow": scene.add_entity(
            gs.morphs.Box(size=(0.9, 0.5, 0.08), pos=(0.1, 0.0, 0.05)),
            material=gs.materials.MPM.Snow(E=500000.0, nu=0.2, rho=300.0, yield_lower=0.025, yield_higher=0.0045),
            surface=gs.surfaces.Default(
                color=(0.9569, 0.9725, 1.0, 1.0), roughness=0.9, metallic=0.0, vis_mode="particle"
            ),
            name="snow",
        )
    }


def add_plough(scene):
    """Add plough."""
    return {
        # case.yaml:25
        "plough": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/plough.xml"),
                pos=(-0.6, 0.0, 0.09),
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(coup_friction=0.1),
            surface=gs.surfaces.Default(color=(0.8863, 0.4431, 0.1137, 1.0), roughness=0.5, metallic=0.0),
            name="plough",
        )
    }


def add_bodies(scene):
    """Add everything that moves; return the entities by name."""
    bodies = {
        **add_snow(scene),
        **add_plough(scene),
    }
    weigh(bodies, MASSES)
    return bodies


# Body, joint, stiffness kp, damping kv, largest force [N or N m].
MOTORS = [
    ("plough", "plough", 20000.0, 2000.0, 4000.0),
]


def configure(bodies):
    """Set what can be set only after the scene is built."""
    for name, joint, kp, kv, limit in MOTORS:
        dofs = bodies[name].get_joint(joint).dofs_idx_local
        bodies[name].set_dofs_kp([kp] * len(dofs), dofs)
        bodies[name].set_dofs_kv([kv] * len(dofs), dofs)
        if limit is not None:
            bodies[name].set_dofs_force_range([-limit] * len(dofs), [limit] * len(dofs), dofs)
