"""The bodies of drape: everything that moves."""

from pathlib import Path

import genesis as gs
from cloth_friction import add_friction

HERE = Path(__file__).resolve().parent

# Deformable bodies: kind, solver, distance of points at rest [m], pose of the frame at the start.
DEFORMABLES = {
    "cloth[0]": {
        "kind": "cloth",
        "solver": "pbd",
        "spacing": 0.00589,
        "pos": (0.0, 0.0, 0.35),
        "quat": (0.996194698, 0.0, 0.0871557427, 0.0),
    },
    "cloth[1]": {
        "kind": "cloth",
        "solver": "pbd",
        "spacing": 0.00589,
        "pos": (0.0, 0.0, 0.4),
        "quat": (0.962250187, -0.0225575661, 0.0841859828, 0.25783416),
    },
}


def add_cloth(scene):
    """Add 2 copies of cloth."""
    copies = [
        # pos, quat
        ((0.0, 0.0, 0.35), (0.996194698, 0.0, 0.0871557427, 0.0)),
        ((0.0, 0.0, 0.4), (0.962250187, -0.0225575661, 0.0841859828, 0.25783416)),
    ]
    return {
        # case.yaml:11
        f"cloth[{i}]": scene.add_entity(
            gs.morphs.Mesh(
                file=str(HERE / "models/cloth.obj"),
                pos=pos,
                quat=quat,
            ),
            material=gs.materials.PBD.Cloth(
                rho=0.2,
                static_friction=0.3,
                kinetic_friction=0.3,
                stretch_compliance=1e-07,
                bending_compliance=0.001,
                air_resistance=8.7e-06,
            ),
            surface=gs.surfaces.Default(color=(0.9412, 0.8941, 0.2588, 1.0), roughness=0.9, metallic=0.0),
            name=f"cloth[{i}]",
        )
        for i, (pos, quat) in enumerate(copies)
    }


def add_bodies(scene):
    """Add all bodies that move; return the entities by name."""
    return {
        **add_cloth(scene),
    }


def configure(bodies):
    """Apply the settings that need a built scene."""
    add_friction(bodies["cloth[0]"])
