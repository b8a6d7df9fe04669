"""The stage of laid_table: time, gravity, solver, and what never moves."""

from pathlib import Path

import genesis as gs
from engine import mend

HERE = Path(__file__).resolve().parent
DT = 0.005  # time step [s]
STEPS = 500  # 2.5 s of simulated time
RECORD_EVERY = 2  # steps from one recorded frame to the next
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
            substeps=2,
            gravity=(0.0, 0.0, -9.81),
        ),
        rigid_options=gs.options.RigidOptions(
            constraint_solver=gs.constraint_solver.Newton,  # few enough bodies for the exact solver
            iterations=50,
            tolerance=1e-08,
            friction_cone=gs.friction_cone.elliptic,  # what rests on a slope or leans creeps with the pyramidal one
            constraint_timeconst=0.005,  # two substeps: the stiffest contact that stays stable
            max_collision_pairs=4624,  # 16 for each of 289 convex pieces
        ),
        vis_options=vis_options or gs.options.VisOptions(),
        show_viewer=False,
    )


def add_floor(scene):
    """Add floor."""
    return {
        # case.yaml:14
        "floor": scene.add_entity(
            gs.morphs.Plane(plane_size=(8.0, 8.0), pos=(0.0, 0.0, 0.0)),
            material=gs.materials.Rigid(friction=0.5),
            surface=gs.surfaces.Default(color=(0.702, 0.6706, 0.6275, 1.0), roughness=0.9, metallic=0.0),
            name="floor",
        )
    }


def add_table(scene):
    """Add table."""
    return {
        # case.yaml:15
        "table": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/table.xml"),
                pos=(0.0, 0.0, 0.0),
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(),
            surface=gs.surfaces.Default(color=(0.7255, 0.5412, 0.3412, 1.0), roughness=0.7, metallic=0.0),
            name="table",
        )
    }


def add_statics(scene):
    """Add what never moves; return the entities by name."""
    return {
        **add_floor(scene),
        **add_table(scene),
    }
