"""The stage of snow_plough: time, gravity, solver, and what never moves."""

import genesis as gs
from engine import mend

DT = 0.003  # time step [s]
STEPS = 800  # 2.4 s of simulated time
RECORD_EVERY = 7  # steps from one recorded frame to the next
MAX_SPEED = 230.0  # a body faster than this [m/s] has diverged


def start_engine(backend):
    """Start the engine; once in a process."""
    mend()
    gs.init(backend=backend, precision="32", seed=0, logging_level="warning")


def make_scene(vis_options=None):
    """Return an empty scene."""
    return gs.Scene(
        sim_options=gs.options.SimOptions(
            dt=DT,
            substeps=22,  # sound runs at 70.9 m/s in the stiffest mpm body: half a cell in a step
            gravity=(0.0, 0.0, -9.81),
        ),
        rigid_options=gs.options.RigidOptions(
            constraint_solver=gs.constraint_solver.Newton,  # few enough bodies for the exact solver
            iterations=50,
            tolerance=1e-08,
            friction_cone=gs.friction_cone.pyramidal,  # survives hard impacts; elliptic does not creep on slopes
            constraint_timeconst=0.002,  # two substeps: the stiffest contact that stays stable
            max_collision_pairs=150,  # 16 for each of 4 convex pieces
        ),
        mpm_options=gs.options.MPMOptions(
            grid_density=50.0,  # cells of 0.02 m: the smallest cell of its bodies
            lower_bound=(-0.6, -0.52, -0.12),
            upper_bound=(0.85, 0.52, 0.32),
        ),
        vis_options=vis_options or gs.options.VisOptions(),
        show_viewer=False,
    )


def add_road(scene):
    """Add road."""
    return {
        # case.yaml:12
        "road": scene.add_entity(
            gs.morphs.Box(size=(1.8, 1.0, 0.1), pos=(0.0, 0.0, -0.05), fixed=True),
            material=gs.materials.Rigid(rho=1000.0, friction=0.6, coup_friction=0.6),
            surface=gs.surfaces.Default(color=(0.2314, 0.2392, 0.251, 1.0), roughness=1.0, metallic=0.0),
            name="road",
        )
    }


def add_statics(scene):
    """Add what never moves; return the entities by name."""
    return {
        **add_road(scene),
    }
