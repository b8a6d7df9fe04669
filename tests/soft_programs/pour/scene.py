"""The scene of pour: time, gravity, solver settings and static bodies."""

from pathlib import Path

import genesis as gs
from engine import mend
from threads import spare_threads

HERE = Path(__file__).resolve().parent
DT = 0.01  # time step [s]
STEPS = 50  # 0.5 s of simulated time
RECORD_EVERY = 2  # steps between recorded frames
MAX_SPEED = 20.0  # the run has diverged if a body is faster [m/s]


def start_engine(backend):
    """Start the engine. Call once per process."""
    mend()
    with spare_threads():
        gs.init(backend=backend, precision="32", seed=0, logging_level="warning")


def make_scene(vis_options=None):
    """Return an empty scene."""
    return gs.Scene(
        sim_options=gs.options.SimOptions(
            dt=DT,
            substeps=142,  # sound runs at 70.9 m/s in the stiffest mpm body: half a cell in a step
            gravity=(0.0, 0.0, -9.81),
        ),
        rigid_options=gs.options.RigidOptions(
            constraint_solver=gs.constraint_solver.Newton,  # few enough bodies for the exact solver
            iterations=50,
            tolerance=1e-08,
            friction_cone=gs.friction_cone.pyramidal,  # survives hard impacts; elliptic does not creep on slopes
            constraint_timeconst=0.002,  # the shortest that is derived: two substeps are less, and may be given
            max_collision_pairs=1216,  # 16 for each of 76 convex pieces
        ),
        mpm_options=gs.options.MPMOptions(
            grid_density=100.0,  # cells of 0.01 m: 8 cells through the thinnest part of `snow`
            # where its bodies can come to, and 4 cells more: three of them are a wall of the grid
            lower_bound=(-0.71, -0.41, -0.04),
            upper_bound=(0.71, 0.41, 0.33),
        ),
        vis_options=vis_options or gs.options.VisOptions(),
        show_viewer=False,
    )


def add_floor(scene):
    """Add floor."""
    return {
        # case.yaml:7
        "floor": scene.add_entity(
            gs.morphs.Plane(plane_size=(40.0, 40.0), pos=(0.0, 0.0, 0.0)),
            material=gs.materials.Rigid(friction=0.5, coup_friction=0.5, coup_softness=0.0025),
            surface=gs.surfaces.Default(color=(0.5961, 0.6314, 0.6627, 1.0), roughness=0.9, metallic=0.0),
            name="floor",
        )
    }


def add_bowl(scene):
    """Add 3 copies of bowl."""
    copies = [
        # pos
        ((-0.3, 0.0, 0.05),),
        ((0.0, 0.0, 0.05),),
        ((0.3, 0.0, 0.05),),
    ]
    return {
        # case.yaml:8
        f"bowl[{i}]": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/bowl.xml"),
                pos=pos,
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(coup_friction=0.5, coup_softness=0.0025),
            surface=gs.surfaces.Default(color=(0.5961, 0.6314, 0.6627, 1.0), roughness=0.9, metallic=0.0),
            name=f"bowl[{i}]",
        )
        for i, (pos,) in enumerate(copies)
    }


def add_statics(scene):
    """Add the static bodies; return the entities by name."""
    return {
        **add_floor(scene),
        **add_bowl(scene),
    }
