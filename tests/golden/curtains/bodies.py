"""The bodies of curtains: everything that moves."""

from pathlib import Path

import genesis as gs
from cloth_friction import add_friction

HERE = Path(__file__).resolve().parent

# Deformable bodies: kind, solver, distance of points at rest [m], pose of the frame at the start.
DEFORMABLES = {
    "left": {
        "kind": "cloth",
        "solver": "pbd",
        "spacing": 0.025,
        "pos": (-0.52, 0.0, 1.35),
        "quat": (0.707106781, 0.707106781, 0.0, 0.0),
    },
    "right": {
        "kind": "cloth",
        "solver": "pbd",
        "spacing": 0.025,
        "pos": (0.52, 0.0, 1.35),
        "quat": (0.707106781, 0.707106781, 0.0, 0.0),
    },
}


def add_left_hook(scene):
    """Add 8 copies of left_hook."""
    copies = [
        # pos
        ((-0.02, 0.0, 2.0),),
        ((-0.162857143, 0.0, 2.0),),
        ((-0.305714286, 0.0, 2.0),),
        ((-0.448571429, 0.0, 2.0),),
        ((-0.591428571, 0.0, 2.0),),
        ((-0.734285714, 0.0, 2.0),),
        ((-0.877142857, 0.0, 2.0),),
        ((-1.02, 0.0, 2.0),),
    ]
    return {
        # case.yaml:22
        f"left_hook[{i}]": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/left_hook.xml"),
                pos=pos,
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(needs_coup=False),
            surface=gs.surfaces.Default(color=(0.7098, 0.651, 0.2588, 1.0), roughness=0.1, metallic=0.9),
            name=f"left_hook[{i}]",
        )
        for i, (pos,) in enumerate(copies)
    }


def add_right_hook(scene):
    """Add 8 copies of right_hook."""
    copies = [
        # pos
        ((0.02, 0.0, 2.0),),
        ((0.162857143, 0.0, 2.0),),
        ((0.305714286, 0.0, 2.0),),
        ((0.448571429, 0.0, 2.0),),
        ((0.591428571, 0.0, 2.0),),
        ((0.734285714, 0.0, 2.0),),
        ((0.877142857, 0.0, 2.0),),
        ((1.02, 0.0, 2.0),),
    ]
    return {
        # case.yaml:30
        f"right_hook[{i}]": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/right_hook.xml"),
                pos=pos,
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(needs_coup=False),
            surface=gs.surfaces.Default(color=(0.7098, 0.651, 0.2588, 1.0), roughness=0.1, metallic=0.9),
            name=f"right_hook[{i}]",
        )
        for i, (pos,) in enumerate(copies)
    }


def add_left(scene):
    """Add left."""
    return {
        # case.yaml:38
        "left": scene.add_entity(
            gs.morphs.Mesh(
                file=str(HERE / "models/left.obj"),
                pos=(-0.52, 0.0, 1.35),
                quat=(0.707106781, 0.707106781, 0.0, 0.0),
            ),
            material=gs.materials.PBD.Cloth(
                rho=0.5,
                static_friction=0.3,
                kinetic_friction=0.3,
                stretch_compliance=1e-07,
                bending_compliance=0.05,
                air_resistance=0.00016,
            ),
            surface=gs.surfaces.Default(
                diffuse_texture=gs.textures.ImageTexture(image_path=str(HERE / "models/left_3517717a.png")),
                roughness=0.9,
                metallic=0.0,
                double_sided=True,
            ),
            name="left",
        )
    }


def add_right(scene):
    """Add right."""
    return {
        # case.yaml:45
        "right": scene.add_entity(
            gs.morphs.Mesh(
                file=str(HERE / "models/right.obj"),
                pos=(0.52, 0.0, 1.35),
                quat=(0.707106781, 0.707106781, 0.0, 0.0),
            ),
            material=gs.materials.PBD.Cloth(
                rho=0.5,
                static_friction=0.3,
                kinetic_friction=0.3,
                stretch_compliance=1e-07,
                bending_compliance=0.05,
                air_resistance=0.00016,
            ),
            surface=gs.surfaces.Default(
                diffuse_texture=gs.textures.ImageTexture(image_path=str(HERE / "models/right_2b8eaf0e.png")),
                roughness=0.9,
                metallic=0.0,
                double_sided=True,
            ),
            name="right",
        )
    }


def add_bodies(scene):
    """Add all bodies that move; return the entities by name."""
    return {
        **add_left_hook(scene),
        **add_right_hook(scene),
        **add_left(scene),
        **add_right(scene),
    }


# Motors: body, joint, stiffness kp, damping kv, largest force [N or N m].
MOTORS = [
    ("left_hook[0]", "left_hook", 400.0, 40.0, 60.0),
    ("left_hook[1]", "left_hook", 400.0, 40.0, 60.0),
    ("left_hook[2]", "left_hook", 400.0, 40.0, 60.0),
    ("left_hook[3]", "left_hook", 400.0, 40.0, 60.0),
    ("left_hook[4]", "left_hook", 400.0, 40.0, 60.0),
    ("left_hook[5]", "left_hook", 400.0, 40.0, 60.0),
    ("left_hook[6]", "left_hook", 400.0, 40.0, 60.0),
    ("left_hook[7]", "left_hook", 400.0, 40.0, 60.0),
    ("right_hook[0]", "right_hook", 400.0, 40.0, 60.0),
    ("right_hook[1]", "right_hook", 400.0, 40.0, 60.0),
    ("right_hook[2]", "right_hook", 400.0, 40.0, 60.0),
    ("right_hook[3]", "right_hook", 400.0, 40.0, 60.0),
    ("right_hook[4]", "right_hook", 400.0, 40.0, 60.0),
    ("right_hook[5]", "right_hook", 400.0, 40.0, 60.0),
    ("right_hook[6]", "right_hook", 400.0, 40.0, 60.0),
    ("right_hook[7]", "right_hook", 400.0, 40.0, 60.0),
]


def configure(bodies):
    """Apply the settings that need a built scene."""
    for name, joint, kp, kv, limit in MOTORS:
        dofs = bodies[name].get_joint(joint).dofs_idx_local
        bodies[name].set_dofs_kp([kp] * len(dofs), dofs)
        bodies[name].set_dofs_kv([kv] * len(dofs), dofs)
        if limit is not None:
            bodies[name].set_dofs_force_range([-limit] * len(dofs), [limit] * len(dofs), dofs)
    add_friction(bodies["left"])
