"""The scene of soft_press: time, gravity, solver settings and static bodies."""

from pathlib import Path

import genesis as gs
from engine import mend
from threads import spare_threads

HERE = Path(__file__).resolve().parent
DT = 0.003  # time step [s]
STEPS = 1000  # 3.0 s of simulated time
RECORD_EVERY = 7  # steps between recorded frames
MAX_SPEED = 130.0  # the run has diverged if a body is faster [m/s]


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
            substeps=5,  # sound and motion, at 12 m/s, cross no more than half a cell
            gravity=(0.0, 0.0, -9.81),
        ),
        rigid_options=gs.options.RigidOptions(
            constraint_solver=gs.constraint_solver.Newton,  # few enough bodies for the exact solver
            iterations=50,
            tolerance=1e-08,
            friction_cone=gs.friction_cone.pyramidal,  # survives hard impacts; elliptic does not creep on slopes
            constraint_timeconst=0.002,  # the shortest that is derived: two substeps are less, and may be given
            max_collision_pairs=272,  # 16 for each of 17 convex pieces
        ),
        mpm_options=gs.options.MPMOptions(
            grid_density=64.1026,  # cells of 0.0156 m: the smallest cell of its bodies
            # where its bodies can come to, and 4 cells more: three of them are a wall of the grid
            lower_bound=(-0.312, -0.312, -0.1248),
            upper_bound=(0.312, 0.312, 0.4368),
        ),
        vis_options=vis_options or gs.options.VisOptions(),
        show_viewer=False,
    )


def add_floor(scene):
    """Add floor."""
    return {
        # case.yaml:13
        "floor": scene.add_entity(
            gs.morphs.Plane(plane_size=(8.0, 8.0), pos=(0.0, 0.0, -0.05)),
            material=gs.materials.Rigid(friction=0.5, coup_friction=0.5, coup_softness=0.00195),
            surface=gs.surfaces.Default(color=(0.6039, 0.6392, 0.6706, 1.0), roughness=0.9, metallic=0.0),
            name="floor",
        )
    }


def add_cup(scene):
    """Add cup."""
    return {
        # case.yaml:14
        "cup": scene.add_entity(
            gs.morphs.MJCF(
                file=str(HERE / "models/cup.xml"),
                pos=(0.0, 0.0, 0.15),
                default_armature=None,  # the engine would add 0.1 to every hinge and slider
            ),
            material=gs.materials.Rigid(coup_friction=0.3, coup_softness=0.00195),
            surface=gs.surfaces.Default(color=(0.8118, 0.9098, 1.0, 0.2), roughness=0.05, metallic=0.0),
            name="cup",
        )
    }


def add_base(scene):
    """Add base."""
    return {
        # case.yaml:24
        "base": scene.add_entity(
            gs.morphs.Cylinder(radius=0.18, height=0.05, pos=(0.0, 0.0, -0.025), fixed=True),
            material=gs.materials.Rigid(rho=1000.0, friction=1.0, coup_friction=1.0, coup_softness=0.00195),
            surface=gs.surfaces.Default(color=(0.2235, 0.2588, 0.298, 1.0), roughness=0.5, metallic=0.0),
            name="base",
        )
    }


def add_statics(scene):
    """Add the static bodies; return the entities by name."""
    return {
        **add_floor(scene),
        **add_cup(scene),
        **add_base(scene),
    }
