"""The stage of conveyor_sorter: time, gravity, solver, and what never moves."""

from pathlib import Path

import genesis as gs
from engine import mend

HERE = Path(__file__).resolve().parent
DT = 0.01  # time step [s]
STEPS = 900  # 9.0 s of simulated time
RECORD_EVERY = 1  # steps from one recorded frame to the next
MAX_SPEED = 1000.0  # a body faster than this [m/s] has diverged


def start_engine(backend):
    """Start the engine; once in a process."""
    mend()
    gs.init(backend=backend, precision="32", seed=0, logging_level="warning")


def make_scene(vis_options=None):
    """Return an empty scene."""
    return gs.Scene(
        sim_options=gs.options.SimOptions(
            dt=DT,
            substeps=4,
            gravity=(0.0, 0.0, -9.81),
        ),
        rigid_options=gs.options.RigidOptions(
            constraint_solver=gs.constraint_solver.Newton,  # few enough bodies for the exact solver
            iterations=50,
            tolerance=1e-08,
            friction_cone=gs.friction_cone.pyramidal,  # survives hard impacts; elliptic does not creep on slopes
            constraint_timeconst=0.005,  # two substeps: the stiffest contact that stays stable
            max_collision_pairs=880,  # 16 for each of 55 convex pieces
        ),
        vis_options=vis_options or gs.options.VisOptions(),
        show_viewer=False,
    )


def add_floor(scene):
    """Add floor."""
    return {
        # case.yaml:14
        "floor": scene.add_entity(
            gs.morphs.Plane(plane_size=(14.0, 14.0), pos=(0.0, 0.0, 0.0)),
            material=gs.materials.Rigid(friction=0.5),
            surface=gs.surfaces.Default(color=(0.7647, 0.7804, 0.7922, 1.0), roughness=0.9, metallic=0.0),
            name="floor",
        )
    }


def add_rail(scene):
    """Add 2 copies of rail."""
    copies = [
        # pos
        ((0.6, -0.24, 0.42),),
        ((0.6, 0.24, 0.42),),
    ]
    return {
        # case.yaml:15
        f"rail[{i}]": scene.add_entity(
            gs.morphs.Box(size=(2.1, 0.03, 0.06), pos=pos, fixed=True),
            material=gs.materials.Rigid(rho=1000.0, friction=0.5),
            surface=gs.surfaces.Default(color=(0.2235, 0.2588, 0.2941, 1.0), roughness=0.5, metallic=0.0),
            name=f"rail[{i}]",
        )
        for i, (pos,) in enumerate(copies)
    }


def add_leg(scene):
    """Add 4 copies of leg."""
    copies = [
        # pos
        ((-0.35, -0.24, 0.195),),
        ((-0.35, 0.24, 0.195),),
        ((1.5, -0.24, 0.195),),
        ((1.5, 0.24, 0.195),),
    ]
    return {
        # case.yaml:20
        f"leg[{i}]": scene.add_entity(
            gs.morphs.Box(size=(0.04, 0.03, 0.39), pos=pos, fixed=True),
            material=gs.materials.Rigid(rho=1000.0, friction=0.5),
            surface=gs.surfaces.Default(color=(0.2235, 0.2588, 0.2941, 1.0), roughness=0.5, metallic=0.0),
            name=f"leg[{i}]",
        )
        for i, (pos,) in enumerate(copies)
    }


def add_stand(scene):
    """Add 2 copies of stand."""
    copies = [
        # pos
        ((0.6, 0.34, 0.0),),
        ((1.1, 0.34, 0.0),),
    ]
    return {
        # case.yaml:25
        f"stand[{i}]": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/stand.xml"),
                pos=pos,
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(),
            surface=gs.surfaces.Default(color=(0.2235, 0.2588, 0.2941, 1.0), roughness=0.5, metallic=0.0),
            name=f"stand[{i}]",
        )
        for i, (pos,) in enumerate(copies)
    }


def add_portal(scene):
    """Add portal."""
    return {
        # case.yaml:34
        "portal": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/portal.xml"),
                pos=(1.62, 0.0, 0.0),
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(),
            surface=gs.surfaces.Default(color=(0.2235, 0.2588, 0.2941, 1.0), roughness=0.5, metallic=0.0),
            name="portal",
        )
    }


def add_bin(scene):
    """Add 3 copies of bin."""
    copies = [
        # pos, color
        ((0.6, -0.52, 0.0), (0.8784, 0.4784, 0.4157, 1.0)),
        ((1.1, -0.52, 0.0), (0.3882, 0.7098, 0.5608, 1.0)),
        ((1.9, 0.0, 0.0), (0.4353, 0.6392, 0.8118, 1.0)),
    ]
    return {
        # case.yaml:45
        f"bin[{i}]": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/bin.xml"),
                pos=pos,
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(),
            surface=gs.surfaces.Default(color=color, roughness=0.4, metallic=0.0),
            name=f"bin[{i}]",
        )
        for i, (pos, color) in enumerate(copies)
    }


def add_statics(scene):
    """Add what never moves; return the entities by name."""
    return {
        **add_floor(scene),
        **add_rail(scene),
        **add_leg(scene),
        **add_stand(scene),
        **add_portal(scene),
        **add_bin(scene),
    }
