"""The bodies of tablecloth_pull: everything that moves."""

from pathlib import Path

import genesis as gs

HERE = Path(__file__).resolve().parent

# What deforms: kind of body, solver, distance of its points at rest [m], where its frame is placed.
DEFORMABLES = {
    "tablecloth": {
        "kind": "cloth",
        "solver": "ipc",
        "spacing": 0.02,
        "pos": (0.2, 0.0, 0.753),
        "quat": (1.0, 0.0, 0.0, 0.0),
    },
}


def add_tablecloth(scene):
    """Add tablecloth."""
    return {
        # case.yaml:24
        "tablecloth": scene.add_entity(
            gs.morphs.Mesh(
                file=str(HERE / "models/tablecloth.obj"),
                pos=(0.2, 0.0, 0.753),
            ),
            material=gs.materials.FEM.Cloth(
                E=1000000.0, nu=0.3, rho=250.0, thickness=0.0005, bending_stiffness=10.0, friction_mu=0.3
            ),
            surface=gs.surfaces.Default(color=(0.702, 0.149, 0.1843, 1.0), roughness=1.0, metallic=0.0),
            name="tablecloth",
        )
    }


def add_plate(scene):
    """Add 2 copies of plate."""
    copies = [
        # pos
        ((-0.025, 0.0, 0.7565),),
        ((0.425, 0.0, 0.7565),),
    ]
    return {
        # case.yaml:37
        f"plate[{i}]": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/plate.xml"),
                pos=pos,
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(rho=2549.72, coup_friction=0.35, coup_type="ipc_only"),
            surface=gs.surfaces.Default(color=(0.9569, 0.9451, 0.9176, 1.0), roughness=0.15, metallic=0.0),
            name=f"plate[{i}]",
        )
        for i, (pos,) in enumerate(copies)
    }


def add_fork(scene):
    """Add fork."""
    return {
        # case.yaml:41
        "fork": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/fork.xml"),
                pos=(-0.22, 0.16, 0.7565),
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(rho=7900.0, coup_friction=0.3, coup_type="ipc_only"),
            surface=gs.surfaces.Default(color=(0.7647, 0.7843, 0.8039, 1.0), roughness=0.3, metallic=0.8),
            name="fork",
        )
    }


def add_knife(scene):
    """Add knife."""
    return {
        # case.yaml:44
        "knife": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/knife.xml"),
                pos=(-0.22, -0.17, 0.7565),
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(rho=7900.0, coup_friction=0.3, coup_type="ipc_only"),
            surface=gs.surfaces.Default(color=(0.7647, 0.7843, 0.8039, 1.0), roughness=0.3, metallic=0.8),
            name="knife",
        )
    }


def add_bottle(scene):
    """Add bottle."""
    return {
        # case.yaml:47
        "bottle": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/bottle.xml"),
                pos=(0.0, 0.18, 0.7565),
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(rho=2583.77, coup_friction=0.35, coup_type="ipc_only"),
            name="bottle",
        )
    }


def add_cup(scene):
    """Add cup."""
    return {
        # case.yaml:50
        "cup": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/cup.xml"),
                pos=(0.0, -0.18, 0.7565),
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(rho=2452.72, coup_friction=0.4, coup_type="ipc_only"),
            surface=gs.surfaces.Default(color=(0.1843, 0.4275, 0.7098, 1.0), roughness=0.15, metallic=0.0),
            name="cup",
        )
    }


def add_clamp(scene):
    """Add clamp."""
    return {
        # case.yaml:54
        "clamp": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/clamp.xml"),
                pos=(0.82, 0.0, 0.628),
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(rho=2700.0, coup_friction=1.0, coup_type="two_way_soft_constraint"),
            surface=gs.surfaces.Default(color=(0.949, 0.6549, 0.1059, 1.0), roughness=0.4, metallic=0.0),
            name="clamp",
        )
    }


def add_bodies(scene):
    """Add everything that moves; return the entities by name."""
    return {
        **add_tablecloth(scene),
        **add_plate(scene),
        **add_fork(scene),
        **add_knife(scene),
        **add_bottle(scene),
        **add_cup(scene),
        **add_clamp(scene),
    }


# Body, joint, stiffness kp, damping kv, largest force [N or N m].
MOTORS = [
    ("clamp", "carriage", 8000.0, 800.0, 400.0),
    ("clamp", "upper", 4000.0, 200.0, 80.0),
    ("clamp", "lower", 4000.0, 200.0, 80.0),
]


def configure(bodies):
    """Set what can be set only after the scene is built."""
    for name, joint, kp, kv, limit in MOTORS:
        dofs = bodies[name].get_joint(joint).dofs_idx_local
        bodies[name].set_dofs_kp([kp] * len(dofs), dofs)
        bodies[name].set_dofs_kv([kv] * len(dofs), dofs)
        if limit is not None:
            bodies[name].set_dofs_force_range([-limit] * len(dofs), [limit] * len(dofs), dofs)
