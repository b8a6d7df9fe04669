"""The bodies of catch_net: everything that moves."""

from pathlib import Path

import genesis as gs

HERE = Path(__file__).resolve().parent


def add_net(scene):
    """Add net."""
    return {
        # case.yaml:20
        "net": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/net.xml"),
                pos=(0.0, 0.0, 1.4),
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(),
            surface=gs.surfaces.Default(color=(0.851, 0.4667, 0.1686, 1.0), roughness=0.9, metallic=0.0),
            name="net",
        )
    }


def add_doll(scene):
    """Add 4 copies of doll."""
    copies = [
        # pos, quat, color
        ((0.0, 0.1, 1.8), (0.707106781, 0.707106781, 0.0, 0.0), (0.7843, 0.2588, 0.2314, 1.0)),
        (
            (0.0675463181, -0.0737393716, 2.24),
            (0.560985527, 0.560985527, 0.430459335, 0.430459335),
            (0.1647, 0.6157, 0.5608, 1.0),
        ),
        (
            (-0.0996164609, 0.00874989834, 2.68),
            (0.183012702, 0.183012702, 0.683012702, 0.683012702),
            (0.9137, 0.7686, 0.4157, 1.0),
        ),
        (
            (0.0793667864, 0.0608351315, 3.12),
            (-0.27059805, -0.27059805, 0.653281482, 0.653281482),
            (0.2078, 0.3765, 0.498, 1.0),
        ),
    ]
    return {
        # case.yaml:29
        f"doll[{i}]": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/doll.xml"),
                pos=pos,
                quat=quat,
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(),
            surface=gs.surfaces.Default(color=color, roughness=0.5, metallic=0.0),
            name=f"doll[{i}]",
        )
        for i, (pos, quat, color) in enumerate(copies)
    }


def add_bodies(scene):
    """Add all bodies that move; return the entities by name."""
    return {
        **add_net(scene),
        **add_doll(scene),
    }


def configure(bodies):
    """Apply the settings that need a built scene."""
