"""The scene of squash: time, gravity, solver settings and static bodies."""

import genesis as gs
from engine import mend
from threads import spare_threads

DT = 0.01  # time step [s]
STEPS = 50  # 0.5 s of simulated time
RECORD_EVERY = 2  # steps between recorded frames
MAX_SPEED = 30.0  # the run has diverged if a body is faster [m/s]


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
            substeps=33,  # sound and motion, at 20 m/s, cross no more than half a cell
            gravity=(0.0, 0.0, -9.81),
        ),
        rigid_options=gs.options.RigidOptions(
            constraint_solver=gs.constraint_solver.Newton,  # few enough bodies for the exact solver
            iterations=50,
            tolerance=1e-08,
            friction_cone=gs.friction_cone.pyramidal,  # survives hard impacts; elliptic does not creep on slopes
            constraint_timeconst=0.002,  # the shortest that is derived: two substeps are less, and may be given
            max_collision_pairs=150,  # 16 for each of 4 convex pieces
        ),
        mpm_options=gs.options.MPMOptions(
            grid_density=83.3333,  # cells of 0.012 m: 5 cells through the thinnest part of `block`
            # where its bodies can come to, and 4 cells more: three of them are a wall of the grid
            lower_bound=(-0.408, -0.3, -0.048),
            upper_bound=(0.516, 0.456, 0.48),
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
            material=gs.materials.Rigid(friction=0.8, coup_friction=0.8, coup_softness=0.0015),
            surface=gs.surfaces.Default(color=(0.5961, 0.6314, 0.6627, 1.0), roughness=0.9, metallic=0.0),
            name="floor",
        )
    }


def add_step(scene):
    """Add step."""
    return {
        # case.yaml:8
        "step": scene.add_entity(
            gs.morphs.Box(size=(0.2, 0.4, 0.1), pos=(0.0, 0.0, 0.05), fixed=True),
            material=gs.materials.Rigid(rho=1000.0, friction=0.5, coup_friction=0.5, coup_softness=0.0015),
            surface=gs.surfaces.Default(color=(0.5961, 0.6314, 0.6627, 1.0), roughness=0.9, metallic=0.0),
            name="step",
        )
    }


def add_rod(scene):
    """Add rod."""
    return {
        # case.yaml:9
        "rod": scene.add_entity(
            gs.morphs.Cylinder(radius=0.01, height=0.4, pos=(0.0, 0.0, 0.6), fixed=True),
            material=gs.materials.Rigid(rho=1000.0, friction=0.5, needs_coup=False),
            surface=gs.surfaces.Default(color=(0.5961, 0.6314, 0.6627, 1.0), roughness=0.9, metallic=0.0),
            name="rod",
        )
    }


def add_statics(scene):
    """Add the static bodies; return the entities by name."""
    return {
        **add_floor(scene),
        **add_step(scene),
        **add_rod(scene),
    }
