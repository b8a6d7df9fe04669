"""The scene of brick_wall: time, gravity, solver settings and static bodies."""

import genesis as gs
from engine import mend

DT = 0.01  # time step [s]
STEPS = 400  # 4.0 s of simulated time
RECORD_EVERY = 1  # steps between recorded frames
MAX_SPEED = 1000.0  # the run has diverged if a body is faster [m/s]


def start_engine(backend):
    """Start the engine. Call once per process."""
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
            constraint_solver=gs.constraint_solver.CG,  # 115 loose bodies can touch each other; newton is 20 times slower on such piles
            iterations=60,
            friction_cone=gs.friction_cone.pyramidal,  # survives hard impacts; elliptic does not creep on slopes
            constraint_timeconst=0.005,  # two substeps: the stiffest contact that stays stable
            max_collision_pairs=1856,  # 16 for each of 116 convex pieces
        ),
        vis_options=vis_options or gs.options.VisOptions(),
        show_viewer=False,
    )


def add_floor(scene):
    """Add floor."""
    return {
        # case.yaml:12
        "floor": scene.add_entity(
            gs.morphs.Plane(plane_size=(30.0, 30.0), pos=(0.0, 0.0, 0.0)),
            material=gs.materials.Rigid(friction=0.8),
            surface=gs.surfaces.Default(color=(0.6627, 0.6431, 0.6078, 1.0), roughness=1.0, metallic=0.0),
            name="floor",
        )
    }


def add_statics(scene):
    """Add the static bodies; return the entities by name."""
    return {
        **add_floor(scene),
    }
