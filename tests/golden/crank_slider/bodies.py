"""The bodies of crank_slider: everything that moves."""

from pathlib import Path

import genesis as gs

HERE = Path(__file__).resolve().parent


def add_engine(scene):
    """Add engine."""
    return {
        # case.yaml:34
        "engine": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/engine.xml"),
                pos=(0.0, 0.0, 0.0),
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(),
            name="engine",
        )
    }


def add_bodies(scene):
    """Add all bodies that move; return the entities by name."""
    return {
        **add_engine(scene),
    }


# Motors: body, joint, stiffness kp, damping kv, largest force [N or N m].
MOTORS = [
    ("engine", "crank", 0.0, 50.0, 200.0),
]


def configure(bodies):
    """Apply the settings that need a built scene."""
    for name, joint, kp, kv, limit in MOTORS:
        dofs = bodies[name].get_joint(joint).dofs_idx_local
        bodies[name].set_dofs_kp([kp] * len(dofs), dofs)
        bodies[name].set_dofs_kv([kv] * len(dofs), dofs)
        if limit is not None:
            bodies[name].set_dofs_force_range([-limit] * len(dofs), [limit] * len(dofs), dofs)
