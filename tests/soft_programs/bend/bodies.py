"""The bodies of bend: everything that moves."""

from pathlib import Path

import genesis as gs

HERE = Path(__file__).resolve().parent

# Deformable bodies: kind, solver, distance of points at rest [m], pose of the frame at the start.
DEFORMABLES = {
    "bar": {
        "kind": "soft",
        "solver": "fem",
        "spacing": 0.015,
        "pos": (0.1, 0.0, 0.2),
        "quat": (0.951251243, -0.0449434555, 0.167731259, 0.254887002),
    },
}


def add_bar(scene):
    """Add bar."""
    return {
        # case.yaml:10
        "bar": scene.add_entity(
            gs.morphs.Mesh(
                file=str(HERE / "models/bar.obj"),
                pos=(0.1, 0.0, 0.2),
                maxvolume=3.977e-07,  # largest volume of a tetrahedron [m3]
            ),
            material=gs.materials.FEM.Elastic(
                E=200000.0, nu=0.4, rho=1000.0, model="linear_corotated", friction_mu=0.5
            ),
            surface=gs.surfaces.Default(color=(0.902, 0.6235, 0.0, 1.0), roughness=0.9, metallic=0.0),
            name="bar",
        )
    }


def add_block(scene):
    """Add block."""
    return {
        # case.yaml:16
        "block": scene.add_entity(
            gs.morphs.Box(size=(0.1, 0.2, 0.1), pos=(0.0, 0.0, 0.05)),
            material=gs.materials.Rigid(rho=1000.0, friction=0.5, coup_friction=0.5),
            surface=gs.surfaces.Default(color=(0.8353, 0.3686, 0.0, 1.0), roughness=0.9, metallic=0.0),
            name="block",
        )
    }


def add_bodies(scene):
    """Add all bodies that move; return the entities by name."""
    return {
        **add_bar(scene),
        **add_block(scene),
    }


def configure(bodies):
    """Apply the settings that need a built scene."""
