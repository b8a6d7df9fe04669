"""The bodies of conveyor_sorter: everything that moves."""

from pathlib import Path

import genesis as gs

HERE = Path(__file__).resolve().parent


def add_roller(scene):
    """Add 20 copies of roller."""
    copies = [
        # pos
        ((-0.35, 0.0, 0.46),),
        ((-0.25, 0.0, 0.46),),
        ((-0.15, 0.0, 0.46),),
        ((-0.05, 0.0, 0.46),),
        ((0.05, 0.0, 0.46),),
        ((0.15, 0.0, 0.46),),
        ((0.25, 0.0, 0.46),),
        ((0.35, 0.0, 0.46),),
        ((0.45, 0.0, 0.46),),
        ((0.55, 0.0, 0.46),),
        ((0.65, 0.0, 0.46),),
        ((0.75, 0.0, 0.46),),
        ((0.85, 0.0, 0.46),),
        ((0.95, 0.0, 0.46),),
        ((1.05, 0.0, 0.46),),
        ((1.15, 0.0, 0.46),),
        ((1.25, 0.0, 0.46),),
        ((1.35, 0.0, 0.46),),
        ((1.45, 0.0, 0.46),),
        ((1.55, 0.0, 0.46),),
    ]
    return {
        # case.yaml:59
        f"roller[{i}]": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/roller.xml"),
                pos=pos,
                quat=(0.707106781, 0.707106781, 0.0, 0.0),
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(),
            surface=gs.surfaces.Default(color=(0.7686, 0.7922, 0.8157, 1.0), roughness=0.45, metallic=0.8),
            name=f"roller[{i}]",
        )
        for i, (pos,) in enumerate(copies)
    }


def add_parcel(scene):
    """Add 3 copies of parcel."""
    copies = [
        # pos, color
        ((0.42, 0.0, 0.581), (0.1843, 0.4314, 0.6588, 1.0)),
        ((0.17, 0.0, 0.581), (0.1216, 0.5412, 0.3569, 1.0)),
        ((-0.08, 0.0, 0.581), (0.8118, 0.2275, 0.1961, 1.0)),
    ]
    return {
        # case.yaml:67
        f"parcel[{i}]": scene.add_entity(
            gs.morphs.Box(size=(0.16, 0.16, 0.16), pos=pos),
            material=gs.materials.Rigid(rho=250.0, friction=0.6),
            surface=gs.surfaces.Default(color=color, roughness=0.5, metallic=0.0),
            name=f"parcel[{i}]",
        )
        for i, (pos, color) in enumerate(copies)
    }


def add_pusher(scene):
    """Add 2 copies of pusher."""
    copies = [
        # pos
        ((0.6, 0.3, 0.58),),
        ((1.1, 0.3, 0.58),),
    ]
    return {
        # case.yaml:74
        f"pusher[{i}]": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/pusher.xml"),
                pos=pos,
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(),
            surface=gs.surfaces.Default(color=(0.8902, 0.698, 0.2353, 1.0), roughness=0.5, metallic=0.0),
            name=f"pusher[{i}]",
        )
        for i, (pos,) in enumerate(copies)
    }


def add_gate(scene):
    """Add gate."""
    return {
        # case.yaml:82
        "gate": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/gate.xml"),
                pos=(1.62, 0.0, 0.6),
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(),
            surface=gs.surfaces.Default(color=(0.8784, 0.4824, 0.1647, 1.0), roughness=0.5, metallic=0.0),
            name="gate",
        )
    }


def add_bodies(scene):
    """Add everything that moves; return the entities by name."""
    return {
        **add_roller(scene),
        **add_parcel(scene),
        **add_pusher(scene),
        **add_gate(scene),
    }


# Body, joint, stiffness kp, damping kv, largest force [N or N m].
MOTORS = [
    ("roller[0]", "roller", 0.0, 20.0, 20.0),
    ("roller[1]", "roller", 0.0, 20.0, 20.0),
    ("roller[2]", "roller", 0.0, 20.0, 20.0),
    ("roller[3]", "roller", 0.0, 20.0, 20.0),
    ("roller[4]", "roller", 0.0, 20.0, 20.0),
    ("roller[5]", "roller", 0.0, 20.0, 20.0),
    ("roller[6]", "roller", 0.0, 20.0, 20.0),
    ("roller[7]", "roller", 0.0, 20.0, 20.0),
    ("roller[8]", "roller", 0.0, 20.0, 20.0),
    ("roller[9]", "roller", 0.0, 20.0, 20.0),
    ("roller[10]", "roller", 0.0, 20.0, 20.0),
    ("roller[11]", "roller", 0.0, 20.0, 20.0),
    ("roller[12]", "roller", 0.0, 20.0, 20.0),
    ("roller[13]", "roller", 0.0, 20.0, 20.0),
    ("roller[14]", "roller", 0.0, 20.0, 20.0),
    ("roller[15]", "roller", 0.0, 20.0, 20.0),
    ("roller[16]", "roller", 0.0, 20.0, 20.0),
    ("roller[17]", "roller", 0.0, 20.0, 20.0),
    ("roller[18]", "roller", 0.0, 20.0, 20.0),
    ("roller[19]", "roller", 0.0, 20.0, 20.0),
    ("pusher[0]", "pusher", 4000.0, 200.0, 300.0),
    ("pusher[1]", "pusher", 4000.0, 200.0, 300.0),
    ("gate", "gate", 200.0, 10.0, 60.0),
]


def configure(bodies):
    """Set what can be set only after the scene is built."""
    for name, joint, kp, kv, limit in MOTORS:
        dofs = bodies[name].get_joint(joint).dofs_idx_local
        bodies[name].set_dofs_kp([kp] * len(dofs), dofs)
        bodies[name].set_dofs_kv([kv] * len(dofs), dofs)
        if limit is not None:
            bodies[name].set_dofs_force_range([-limit] * len(dofs), [limit] * len(dofs), dofs)
