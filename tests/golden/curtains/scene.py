"""The scene of curtains: time, gravity, solver settings and static bodies."""

import genesis as gs
from engine import mend

DT = 0.004  # time step [s]
STEPS = 2250  # 9.0 s of simulated time
RECORD_EVERY = 5  # steps between recorded frames
MAX_SPEED = 140.0  # the run has diverged if a body is faster [m/s]


def start_engine(backend):
    """Start the engine. Call once per process."""
    mend()
    gs.init(backend=backend, precision="32", seed=0, logging_level="warning")


def make_scene(vis_options=None):
    """Return an empty scene."""
    return gs.Scene(
        sim_options=gs.options.SimOptions(
            dt=DT,
            substeps=8,
            gravity=(0.0, 0.0, -9.81),
        ),
        rigid_options=gs.options.RigidOptions(
            constraint_solver=gs.constraint_solver.Newton,  # few enough bodies for the exact solver
            iterations=50,
            tolerance=1e-08,
            friction_cone=gs.friction_cone.pyramidal,  # survives hard impacts; elliptic does not creep on slopes
            constraint_timeconst=0.002,  # the shortest that is derived: two substeps are less, and may be given
            max_collision_pairs=288,  # 16 for each of 18 convex pieces
        ),
        pbd_options=gs.options.PBDOptions(
            particle_size=0.025,  # the smallest cell of its bodies
            # where its bodies can come to; its sides are walls
            lower_bound=(-2.7, -0.95, -0.1),
            upper_bound=(2.7, 0.95, 2.925),
            hash_grid_res=(1.0, 1.0, 1.0),  # it repeats: clearing one of the whole space takes longer than the cloth
            max_stretch_solver_iterations=4,  # its own weight then stretches a cloth that hangs by 0.4%
            max_bending_solver_iterations=1,  # as the engine has it
        ),
        vis_options=vis_options or gs.options.VisOptions(),
        show_viewer=False,
    )


def add_floor(scene):
    """Add floor."""
    return {
        # case.yaml:14
        "floor": scene.add_entity(
            gs.morphs.Plane(plane_size=(10.0, 10.0), pos=(0.0, 0.0, 0.0)),
            material=gs.materials.Rigid(friction=0.5, coup_friction=0.5),
            surface=gs.surfaces.Default(color=(0.8275, 0.7922, 0.7412, 1.0), roughness=0.9, metallic=0.0),
            name="floor",
        )
    }


def add_rod(scene):
    """Add rod."""
    return {
        # case.yaml:15
        "rod": scene.add_entity(
            gs.morphs.Cylinder(
                radius=0.014, height=2.4, pos=(0.0, 0.0, 2.03), quat=(0.707106781, 0.0, 0.707106781, 0.0), fixed=True
            ),
            material=gs.materials.Rigid(rho=1000.0, friction=0.5, needs_coup=False),
            surface=gs.surfaces.Default(color=(0.7098, 0.651, 0.2588, 1.0), roughness=0.1, metallic=0.9),
            name="rod",
        )
    }


def add_statics(scene):
    """Add the static bodies; return the entities by name."""
    return {
        **add_floor(scene),
        **add_rod(scene),
    }
