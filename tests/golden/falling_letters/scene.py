"""The stage of falling_letters: time, gravity, solver, and what never moves."""

import genesis as gs
from engine import mend

DT = 0.004  # time step [s]
STEPS = 750  # 3.0 s of simulated time
RECORD_EVERY = 5  # steps from one recorded frame to the next
MAX_SPEED = 39.0  # a body faster than this [m/s] has diverged


def start_engine(backend):
    """Start the engine; once in a process."""
    mend()
    gs.init(backend=backend, precision="32", seed=0, logging_level="warning")


def make_scene(vis_options=None):
    """Return an empty scene."""
    return gs.Scene(
        sim_options=gs.options.SimOptions(
            dt=DT,
            substeps=15,  # sound runs at 40.2 m/s in the stiffest mpm body: half a cell in a step
            gravity=(0.0, 0.0, -9.81),
        ),
        rigid_options=gs.options.RigidOptions(
            constraint_solver=gs.constraint_solver.Newton,  # few enough bodies for the exact solver
            iterations=50,
            tolerance=1e-08,
            friction_cone=gs.friction_cone.pyramidal,  # survives hard impacts; elliptic does not creep on slopes
            constraint_timeconst=0.002,  # two substeps: the stiffest contact that stays stable
            max_collision_pairs=150,  # 16 for each of 2 convex pieces
        ),
        mpm_options=gs.options.MPMOptions(
            grid_density=45.4545,  # cells of 0.022 m: the smallest cell of its bodies
            lower_bound=(-1.2, -0.75, -0.09),
            upper_bound=(1.2, 0.75, 1.86),
        ),
        vis_options=vis_options or gs.options.VisOptions(),
        show_viewer=False,
    )


def add_floor(scene):
    """Add floor."""
    return {
        # case.yaml:12
        "floor": scene.add_entity(
            gs.morphs.Plane(plane_size=(8.0, 8.0), pos=(0.0, 0.0, 0.0)),
            material=gs.materials.Rigid(friction=0.5, coup_friction=0.5),
            surface=gs.surfaces.Default(color=(0.9255, 0.9373, 0.949, 1.0), roughness=0.9, metallic=0.0),
            name="floor",
        )
    }


def add_ridge(scene):
    """Add ridge."""
    return {
        # case.yaml:13
        "ridge": scene.add_entity(
            gs.morphs.Box(
                size=(1.5, 0.2, 0.2), pos=(0.0, 0.02, 0.1), quat=(0.923879533, 0.382683432, 0.0, 0.0), fixed=True
            ),
            material=gs.materials.Rigid(rho=1000.0, friction=0.5, coup_friction=0.5),
            surface=gs.surfaces.Default(color=(0.4353, 0.4784, 0.5216, 1.0), roughness=0.5, metallic=0.0),
            name="ridge",
        )
    }


def add_statics(scene):
    """Add what never moves; return the entities by name."""
    return {
        **add_floor(scene),
        **add_ridge(scene),
    }
