"""The stage of wrecking_ball: time, gravity, solver, and what never moves."""

import genesis as gs
from engine import mend

DT = 0.01  # time step [s]
STEPS = 1000  # 10.0 s of simulated time
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
            constraint_timeconst=0.005,
            max_collision_pairs=1184,  # 16 for each of 74 convex pieces
        ),
        vis_options=vis_options or gs.options.VisOptions(),
        show_viewer=False,
    )


def add_floor(scene):
    """Add floor."""
    return {
        # case.yaml:13
        "floor": scene.add_entity(
            gs.morphs.Plane(plane_size=(30.0, 30.0), pos=(0.0, 0.0, 0.0)),
            material=gs.materials.Rigid(friction=0.6),
            surface=gs.surfaces.Default(color=(0.6392, 0.6392, 0.6157, 1.0), roughness=1.0, metallic=0.0),
            name="floor",
        )
    }


def add_beam(scene):
    """Add beam."""
    return {
        # case.yaml:17
        "beam": scene.add_entity(
            gs.morphs.Box(size=(0.16, 1.0, 0.12), pos=(0.0, 0.35, 2.81), fixed=True),
            material=gs.materials.Rigid(rho=1000.0, friction=0.5),
            surface=gs.surfaces.Default(color=(0.949, 0.6902, 0.1176, 1.0), roughness=0.9, metallic=0.0),
            name="beam",
        )
    }


def add_mast(scene):
    """Add mast."""
    return {
        # case.yaml:21
        "mast": scene.add_entity(
            gs.morphs.Box(size=(0.16, 0.12, 2.87), pos=(0.0, 0.79, 1.435), fixed=True),
            material=gs.materials.Rigid(rho=1000.0, friction=0.5),
            surface=gs.surfaces.Default(color=(0.949, 0.6902, 0.1176, 1.0), roughness=0.9, metallic=0.0),
            name="mast",
        )
    }


def add_statics(scene):
    """Add what never moves; return the entities by name."""
    return {
        **add_floor(scene),
        **add_beam(scene),
        **add_mast(scene),
    }
