"""The scene of sand_hourglass: time, gravity, solver settings and static bodies."""

from pathlib import Path

import genesis as gs
from engine import mend
from threads import spare_threads

HERE = Path(__file__).resolve().parent
DT = 0.003  # time step [s]
STEPS = 1167  # 3.501 s of simulated time
RECORD_EVERY = 7  # steps between recorded frames
MAX_SPEED = 27.0  # the run has diverged if a body is faster [m/s]


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
            substeps=9,  # sound and motion, at 22 m/s, cross no more than half a cell
            gravity=(0.0, 0.0, -9.81),
        ),
        rigid_options=gs.options.RigidOptions(
            constraint_solver=gs.constraint_solver.Newton,  # few enough bodies for the exact solver
            iterations=50,
            tolerance=1e-08,
            friction_cone=gs.friction_cone.pyramidal,  # survives hard impacts; elliptic does not creep on slopes
            constraint_timeconst=0.002,  # the shortest that is derived: two substeps are less, and may be given
            max_collision_pairs=352,  # 16 for each of 22 convex pieces
        ),
        mpm_options=gs.options.MPMOptions(
            grid_density=64.1026,  # cells of 0.0156 m: the smallest cell of its bodies
            lower_bound=(-0.28, -0.28, -0.12),
            upper_bound=(0.28, 0.28, 0.62),
        ),
        vis_options=vis_options or gs.options.VisOptions(),
        show_viewer=False,
    )


def add_floor(scene):
    """Add floor."""
    return {
        # case.yaml:12
        "floor": scene.add_entity(
            gs.morphs.Plane(plane_size=(8.0, 8.0), pos=(0.0, 0.0, -0.06)),
            material=gs.materials.Rigid(friction=0.5, coup_friction=0.5, coup_softness=0.00195),
            surface=gs.surfaces.Default(color=(0.4157, 0.3843, 0.349, 1.0), roughness=0.9, metallic=0.0),
            name="floor",
        )
    }


def add_upper(scene):
    """Add upper."""
    return {
        # case.yaml:13
        "upper": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/upper.xml"),
                pos=(0.0, 0.0, 0.39),
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(coup_friction=0.5, coup_softness=0.00195),
            surface=gs.surfaces.Default(color=(0.8118, 0.9098, 1.0, 0.2), roughness=0.05, metallic=0.0),
            name="upper",
        )
    }


def add_lower(scene):
    """Add lower."""
    return {
        # case.yaml:23
        "lower": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/lower.xml"),
                pos=(0.0, 0.0, 0.13),
                quat=(0.0, 1.0, 0.0, 0.0),
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(coup_friction=0.5, coup_softness=0.00195),
            surface=gs.surfaces.Default(color=(0.8118, 0.9098, 1.0, 0.2), roughness=0.05, metallic=0.0),
            name="lower",
        )
    }


def add_base(scene):
    """Add base."""
    return {
        # case.yaml:33
        "base": scene.add_entity(
            gs.morphs.Cylinder(radius=0.21, height=0.06, pos=(0.0, 0.0, -0.03), fixed=True),
            material=gs.materials.Rigid(rho=1000.0, friction=0.5, coup_friction=0.5, coup_softness=0.00195),
            surface=gs.surfaces.Default(color=(0.4196, 0.2902, 0.1843, 1.0), roughness=0.7, metallic=0.0),
            name="base",
        )
    }


def add_statics(scene):
    """Add the static bodies; return the entities by name."""
    return {
        **add_floor(scene),
        **add_upper(scene),
        **add_lower(scene),
        **add_base(scene),
    }
