"""The stage of tumbler: time, gravity, solver, and what never moves."""

import genesis as gs
from engine import mend

DT = 0.01  # time step [s]
STEPS = 700  # 7.0 s of simulated time
RECORD_EVERY = 2  # steps from one recorded frame to the next
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
            substeps=4,  # at 5 ms and more the bodies of a dense pile sink into each other
            gravity=(0.0, 0.0, -9.81),
        ),
        rigid_options=gs.options.RigidOptions(
            constraint_solver=gs.constraint_solver.CG,  # 250 loose bodies can touch each other; newton is 20 times slower on such piles
            iterations=60,
            friction_cone=gs.friction_cone.pyramidal,  # survives hard impacts; elliptic does not creep on slopes
            constraint_timeconst=0.005,  # two substeps: the stiffest contact that stays stable
            max_collision_pairs=4448,  # 16 for each of 278 convex pieces
        ),
        vis_options=vis_options or gs.options.VisOptions(),
        show_viewer=False,
    )


def add_floor(scene):
    """Add floor."""
    return {
        # case.yaml:14
        "floor": scene.add_entity(
            gs.morphs.Plane(plane_size=(20.0, 20.0), pos=(0.0, 0.0, -0.75)),
            material=gs.materials.Rigid(friction=0.5),
            surface=gs.surfaces.Default(color=(0.349, 0.3882, 0.4275, 1.0), roughness=0.9, metallic=0.0),
            name="floor",
        )
    }


def add_stand(scene):
    """Add stand."""
    return {
        # case.yaml:15
        "stand": scene.add_entity(
            gs.morphs.Box(size=(0.7, 0.35, 0.26), pos=(0.0, 0.0, -0.62), fixed=True),
            material=gs.materials.Rigid(rho=1000.0, friction=0.5),
            surface=gs.surfaces.Default(color=(0.1843, 0.2314, 0.2745, 1.0), roughness=0.5, metallic=0.0),
            name="stand",
        )
    }


def add_statics(scene):
    """Add what never moves; return the entities by name."""
    return {
        **add_floor(scene),
        **add_stand(scene),
    }
