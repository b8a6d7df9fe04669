"""The scene of catch_net: time, gravity, solver settings and static bodies."""

import genesis as gs
from engine import mend

DT = 0.01  # time step [s]
STEPS = 600  # 6.0 s of simulated time
RECORD_EVERY = 1  # steps between recorded frames
MAX_SPEED = 1000.0  # the run has diverged if a body is faster [m/s]


def start_engine(backend):
    """Start the engine. Call once per process."""
    mend()
    gs.init(backend=backend, precision="32", seed=0, logging_level="warning")


def make_scene(vis_options=None):
    """Return an empty scene."""
    return gs.Scene(
        sim_options=gs.options.SimOptions(
            dt=DT,
            substeps=4,
            gravity=(0.0, 0.0, -9.81),
        ),
        rigid_options=gs.options.RigidOptions(
            constraint_solver=gs.constraint_solver.CG,  # 244 links and 120 closed loops: cg is faster and survives impacts better
            iterations=50,
            friction_cone=gs.friction_cone.pyramidal,  # survives hard impacts; elliptic does not creep on slopes
            constraint_timeconst=0.005,  # two substeps: the stiffest contact that stays stable
            max_collision_pairs=4368,  # 16 for each of 273 convex pieces
        ),
        vis_options=vis_options or gs.options.VisOptions(),
        show_viewer=False,
    )


def add_floor(scene):
    """Add floor."""
    return {
        # case.yaml:12
        "floor": scene.add_entity(
            gs.morphs.Plane(plane_size=(14.0, 14.0), pos=(0.0, 0.0, 0.0)),
            material=gs.materials.Rigid(friction=0.5),
            surface=gs.surfaces.Default(color=(0.7255, 0.749, 0.7686, 1.0), roughness=0.9, metallic=0.0),
            name="floor",
        )
    }


def add_leg(scene):
    """Add 4 copies of leg."""
    copies = [
        # pos
        ((-0.83, -0.83, 0.7),),
        ((0.83, -0.83, 0.7),),
        ((-0.83, 0.83, 0.7),),
        ((0.83, 0.83, 0.7),),
    ]
    return {
        # case.yaml:13
        f"leg[{i}]": scene.add_entity(
            gs.morphs.Cylinder(radius=0.03, height=1.4, pos=pos, fixed=True),
            material=gs.materials.Rigid(rho=1000.0, friction=0.5),
            surface=gs.surfaces.Default(color=(0.1843, 0.2314, 0.2745, 1.0), roughness=0.5, metallic=0.0),
            name=f"leg[{i}]",
        )
        for i, (pos,) in enumerate(copies)
    }


def add_statics(scene):
    """Add the static bodies; return the entities by name."""
    return {
        **add_floor(scene),
        **add_leg(scene),
    }
