"""The scene of drape: time, gravity, solver settings and static bodies."""

import genesis as gs
from engine import mend

DT = 0.01  # time step [s]
STEPS = 50  # 0.5 s of simulated time
RECORD_EVERY = 2  # steps between recorded frames
MAX_SPEED = 24.0  # the run has diverged if a body is faster [m/s]


def start_engine(backend):
    """Start the engine. Call once per process."""
    mend()
    gs.init(backend=backend, precision="32", seed=0, logging_level="warning")


def make_scene(vis_options=None):
    """Return an empty scene."""
    return gs.Scene(
        sim_options=gs.options.SimOptions(
            dt=DT,
            substeps=20,  # cloth stretches at longer steps
            gravity=(0.0, 0.0, -9.81),
        ),
        rigid_options=gs.options.RigidOptions(
            constraint_solver=gs.constraint_solver.Newton,  # few enough bodies for the exact solver
            iterations=50,
            tolerance=1e-08,
            friction_cone=gs.friction_cone.pyramidal,  # survives hard impacts; elliptic does not creep on slopes
            constraint_timeconst=0.002,  # the shortest that is derived: two substeps are less, and may be given
            max_collision_pairs=150,  # 16 for each of 2 convex pieces
        ),
        pbd_options=gs.options.PBDOptions(
            particle_size=0.00589,  # 4000 particles make all cloths; finer is slow
            # where its bodies can come to; its sides are walls
            lower_bound=(-0.30039, -0.28272, -0.02356),
            upper_bound=(0.30039, 0.28272, 0.71269),
            hash_grid_res=(
                0.2356,
                0.2356,
                0.2356,
            ),  # it repeats: clearing one of the whole space takes longer than the cloth
            max_stretch_solver_iterations=10,
            max_bending_solver_iterations=1,  # as the engine has it
        ),
        vis_options=vis_options or gs.options.VisOptions(),
        show_viewer=False,
    )


def add_floor(scene):
    """Add floor."""
    return {
        # case.yaml:8
        "floor": scene.add_entity(
            gs.morphs.Plane(plane_size=(40.0, 40.0), pos=(0.0, 0.0, 0.0)),
            material=gs.materials.Rigid(friction=0.5, coup_friction=0.5),
            surface=gs.surfaces.Default(color=(0.5961, 0.6314, 0.6627, 1.0), roughness=0.9, metallic=0.0),
            name="floor",
        )
    }


def add_ball(scene):
    """Add ball."""
    return {
        # case.yaml:9
        "ball": scene.add_entity(
            gs.morphs.Sphere(radius=0.1, pos=(0.0, 0.0, 0.2), fixed=True),
            material=gs.materials.Rigid(rho=1000.0, friction=0.9, coup_friction=0.9),
            surface=gs.surfaces.Default(color=(0.5961, 0.6314, 0.6627, 1.0), roughness=0.9, metallic=0.0),
            name="ball",
        )
    }


def add_statics(scene):
    """Add the static bodies; return the entities by name."""
    return {
        **add_floor(scene),
        **add_ball(scene),
    }
