"""The bodies of laid_table: everything that moves."""

from pathlib import Path

import genesis as gs

HERE = Path(__file__).resolve().parent


def add_plate(scene):
    """Add plate."""
    return {
        # case.yaml:18
        "plate": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/plate.xml"),
                pos=(-0.05, -0.2, 0.74),
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(),
            surface=gs.surfaces.Default(color=(0.9569, 0.9451, 0.9176, 1.0), roughness=0.15, metallic=0.0),
            name="plate",
        )
    }


def add_fork(scene):
    """Add fork."""
    return {
        # case.yaml:21
        "fork": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/fork.xml"),
                pos=(-0.25, -0.2, 0.74),
                quat=(0.707106781, 0.0, 0.0, 0.707106781),
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(),
            surface=gs.surfaces.Default(color=(0.7647, 0.7843, 0.8039, 1.0), roughness=0.3, metallic=0.8),
            name="fork",
        )
    }


def add_knife(scene):
    """Add knife."""
    return {
        # case.yaml:24
        "knife": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/knife.xml"),
                pos=(0.14, -0.2, 0.74),
                quat=(0.707106781, 0.0, 0.0, 0.707106781),
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(),
            surface=gs.surfaces.Default(color=(0.7647, 0.7843, 0.8039, 1.0), roughness=0.3, metallic=0.8),
            name="knife",
        )
    }


def add_cup(scene):
    """Add cup."""
    return {
        # case.yaml:27
        "cup": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/cup.xml"),
                pos=(-0.35, 0.02, 0.74),
                quat=(0.939692621, 0.0, 0.0, -0.342020143),
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(),
            surface=gs.surfaces.Default(color=(0.7098, 0.2824, 0.1843, 1.0), roughness=0.15, metallic=0.0),
            name="cup",
        )
    }


def add_bottle(scene):
    """Add bottle."""
    return {
        # case.yaml:31
        "bottle": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/bottle.xml"),
                pos=(0.1, 0.17, 0.74),
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(),
            name="bottle",
        )
    }


def add_glass(scene):
    """Add glass."""
    return {
        # case.yaml:35
        "glass": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/glass.xml"),
                pos=(0.3, 0.19, 0.74),
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(),
            surface=gs.surfaces.Default(color=(0.8745, 0.9333, 0.949, 0.4), roughness=0.05, metallic=0.0),
            name="glass",
        )
    }


def add_ball(scene):
    """Add ball."""
    return {
        # case.yaml:39
        "ball": scene.add_entity(
            gs.morphs.Sphere(radius=0.0535, pos=(-0.6, 0.185, 0.7945)),
            material=gs.materials.Rigid(rho=1430.0, friction=0.3),
            surface=gs.surfaces.Default(color=(0.1843, 0.4275, 0.7098, 1.0), roughness=0.4, metallic=0.0),
            name="ball",
        )
    }


def add_bodies(scene):
    """Add everything that moves; return the entities by name."""
    return {
        **add_plate(scene),
        **add_fork(scene),
        **add_knife(scene),
        **add_cup(scene),
        **add_bottle(scene),
        **add_glass(scene),
        **add_ball(scene),
    }


def configure(bodies):
    """Set what can be set only after the scene is built."""
