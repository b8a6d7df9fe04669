"""The stage of squeeze_through: time, gravity, solver, and what never moves."""

from pathlib import Path

import genesis as gs
from engine import mend

HERE = Path(__file__).resolve().parent
DT = 0.002  # time step [s]
STEPS = 650  # 1.3 s of simulated time
RECORD_EVERY = 10  # steps from one recorded frame to the next
MAX_SPEED = 15.0  # a body faster than this [m/s] has diverged


def start_engine(backend):
    """Start the engine; once in a process."""
    mend()
    gs.init(backend=backend, precision="32", seed=0, logging_level="warning")


def make_scene(vis_options=None):
    """Return an empty scene."""
    return gs.Scene(
        sim_options=gs.options.SimOptions(
            dt=DT,
            substeps=8,  # as the engine suggests for a grid of 0.0139 m cells
            gravity=(0.0, 0.0, 0.0),
        ),
        rigid_options=gs.options.RigidOptions(
            constraint_solver=gs.constraint_solver.Newton,  # few enough bodies for the exact solver
            iterations=50,
            tolerance=1e-08,
            friction_cone=gs.friction_cone.pyramidal,  # survives hard impacts; elliptic does not creep on slopes
            constraint_timeconst=0.002,  # two substeps: the stiffest contact that stays stable
            max_collision_pairs=320,  # 16 for each of 20 convex pieces
        ),
        mpm_options=gs.options.MPMOptions(
            grid_density=71.9424,  # cells of 0.0139 m: the smallest cell of its bodies
            lower_bound=(-0.42, -0.26, -0.26),
            upper_bound=(1.25, 0.26, 0.26),
        ),
        vis_options=vis_options or gs.options.VisOptions(),
        show_viewer=False,
    )


def add_funnel(scene):
    """Add funnel."""
    return {
        # case.yaml:15
        "funnel": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/funnel.xml"),
                pos=(0.0, 0.0, 0.0),
                quat=(0.707106781, 0.0, -0.707106781, 0.0),
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(coup_friction=0.05, coup_softness=0.014),
            surface=gs.surfaces.Default(color=(0.8118, 0.9098, 1.0, 0.25), roughness=0.05, metallic=0.0),
            name="funnel",
        )
    }


def add_tube(scene):
    """Add tube."""
    return {
        # case.yaml:26
        "tube": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/tube.xml"),
                pos=(0.16, 0.0, 0.0),
                quat=(0.707106781, 0.0, 0.707106781, 0.0),
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(coup_friction=0.05, coup_softness=0.014),
            surface=gs.surfaces.Default(color=(0.8118, 0.9098, 1.0, 0.25), roughness=0.05, metallic=0.0),
            name="tube",
        )
    }


def add_statics(scene):
    """Add what never moves; return the entities by name."""
    return {
        **add_funnel(scene),
        **add_tube(scene),
    }
