"""The stage of domino_spiral: time, gravity, solver, and what never moves."""

import genesis as gs
from engine import mend

DT = 0.005  # time step [s]
STEPS = 1200  # 6.0 s of simulated time
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
            friction_cone=gs.friction_cone.pyramidal,  # survives hard impacts; elliptic does not creep on slopes
            constraint_timeconst=0.005,  # two substeps: the stiffest contact that stays stable
            max_collision_pairs=1312,  # 16 for each of 82 convex pieces
        ),
        vis_options=vis_options or gs.options.VisOptions(),
        show_viewer=False,
    )


def add_table(scene):
    """Add table."""
    return {
        # case.yaml:14
        "table": scene.add_entity(
            gs.morphs.Plane(plane_size=(12.0, 12.0), pos=(0.0, 0.0, 0.0)),
            material=gs.materials.Rigid(friction=0.5),
            surface=gs.surfaces.Default(color=(0.851, 0.7961, 0.7137, 1.0), roughness=0.9, metallic=0.0),
            name="table",
        )
    }


def add_statics(scene):
    """Add what never moves; return the entities by name."""
    return {
        **add_table(scene),
    }
