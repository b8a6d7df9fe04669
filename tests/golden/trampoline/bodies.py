"""The bodies of trampoline: everything that moves."""

from pathlib import Path

import genesis as gs

HERE = Path(__file__).resolve().parent

# What deforms: kind of body, solver, distance of its points at rest [m], where its frame is placed.
DEFORMABLES = {
    "sheet": {"kind": "cloth", "solver": "pbd", "spacing": 0.02, "pos": (0.0, 0.0, 0.9), "quat": (1.0, 0.0, 0.0, 0.0)},
}


def add_sheet(scene):
    """Add sheet."""
    return {
        # case.yaml:33
        "sheet": scene.add_entity(
            gs.morphs.Mesh(
                file=str(HERE / "models/sheet.obj"),
                pos=(0.0, 0.0, 0.9),
            ),
            material=gs.materials.PBD.Cloth(
                rho=0.4,
                static_friction=0.3,
                kinetic_friction=0.3,
                stretch_compliance=1e-07,
                bending_compliance=0.0001,
                air_resistance=0.001,
            ),
            surface=gs.surfaces.Default(
                diffuse_texture=gs.textures.ImageTexture(image_path=str(HERE / "models/sheet_541ad394.png")),
                roughness=1.0,
                metallic=0.0,
                double_sided=True,
            ),
            name="sheet",
        )
    }


def add_ball(scene):
    """Add 3 copies of ball."""
    copies = [
        # pos, color
        ((-0.16, -0.1, 1.5), (0.8196, 0.2863, 0.3569, 1.0)),
        ((0.0, 0.0, 1.78), (0.9294, 0.6824, 0.2863, 1.0)),
        ((0.16, 0.1, 2.06), (0.1647, 0.6157, 0.5608, 1.0)),
    ]
    return {
        # case.yaml:41
        f"ball[{i}]": scene.add_entity(
            gs.morphs.Sphere(radius=0.07, pos=pos),
            material=gs.materials.Rigid(rho=300.0, friction=0.5, coup_friction=0.5),
            surface=gs.surfaces.Default(color=color, roughness=0.9, metallic=0.0),
            name=f"ball[{i}]",
        )
        for i, (pos, color) in enumerate(copies)
    }


def add_bodies(scene):
    """Add everything that moves; return the entities by name."""
    return {
        **add_sheet(scene),
        **add_ball(scene),
    }


def configure(bodies):
    """Set what can be set only after the scene is built."""
