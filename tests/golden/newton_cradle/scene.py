"""The stage of newton_cradle: time, gravity, solver, and what never moves."""

import genesis as gs
from engine import mend

DT = 0.0002  # time step [s]
STEPS = 30000  # 6.0 s of simulated time
RECORD_EVERY = 50  # steps from one recorded frame to the next
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
            substeps=1,
            gravity=(0.0, 0.0, -9.81),
        ),
        rigid_options=gs.options.RigidOptions(
            constraint_solver=gs.constraint_solver.Newton,  # few enough bodies for the exact solver
            iterations=50,
            tolerance=1e-08,
            friction_cone=gs.friction_cone.pyramidal,  # survives hard impacts; elliptic does not creep on slopes
            constraint_timeconst=0.2,
            max_collision_pairs=224,  # 16 for each of 14 convex pieces
        ),
        vis_options=vis_options or gs.options.VisOptions(),
        show_viewer=False,
    )


def add_beam(scene):
    """Add beam."""
    return {
        # case.yaml:13
        "beam": scene.add_entity(
            gs.morphs.Box(size=(1.27, 0.03, 0.03), pos=(0.0, 0.0, 0.818), fixed=True),
            material=gs.materials.Rigid(rho=1000.0, friction=0.5),
            surface=gs.surfaces.Default(color=(0.3608, 0.251, 0.2, 1.0), roughness=0.7, metallic=0.0),
            name="beam",
        )
    }


def add_post(scene):
    """Add 2 copies of post."""
    copies = [
        # pos
        ((-0.62, 0.0, 0.425),),
        ((0.62, 0.0, 0.425),),
    ]
    return {
        # case.yaml:17
        f"post[{i}]": scene.add_entity(
            gs.morphs.Box(size=(0.03, 0.03, 0.85), pos=pos, fixed=True),
            material=gs.materials.Rigid(rho=1000.0, friction=0.5),
            surface=gs.surfaces.Default(color=(0.3608, 0.251, 0.2, 1.0), roughness=0.7, metallic=0.0),
            name=f"post[{i}]",
        )
        for i, (pos,) in enumerate(copies)
    }


def add_table(scene):
    """Add table."""
    return {
        # case.yaml:22
        "table": scene.add_entity(
            gs.morphs.Plane(plane_size=(8.0, 8.0), pos=(0.0, 0.0, 0.0)),
            material=gs.materials.Rigid(friction=0.5),
            surface=gs.surfaces.Default(color=(0.5608, 0.5333, 0.4863, 1.0), roughness=0.9, metallic=0.0),
            name="table",
        )
    }


def add_statics(scene):
    """Add what never moves; return the entities by name."""
    return {
        **add_beam(scene),
        **add_post(scene),
        **add_table(scene),
    }
