"""The scene of crank_slider: time, gravity, solver settings and static bodies."""

import genesis as gs
from engine import mend

DT = 0.005  # time step [s]
STEPS = 1200  # 6.0 s of simulated time
RECORD_EVERY = 2  # steps between recorded frames
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
            substeps=2,
            gravity=(0.0, 0.0, -9.81),
        ),
        rigid_options=gs.options.RigidOptions(
            constraint_solver=gs.constraint_solver.Newton,  # few enough bodies for the exact solver
            iterations=50,
            tolerance=1e-08,
            friction_cone=gs.friction_cone.pyramidal,  # survives hard impacts; elliptic does not creep on slopes
            constraint_timeconst=0.005,  # two substeps: the stiffest contact that stays stable
            max_collision_pairs=224,  # 16 for each of 14 convex pieces
        ),
        vis_options=vis_options or gs.options.VisOptions(),
        show_viewer=False,
    )


def add_floor(scene):
    """Add floor."""
    return {
        # case.yaml:12
        "floor": scene.add_entity(
            gs.morphs.Plane(plane_size=(10.0, 10.0), pos=(0.0, 0.0, -0.16)),
            material=gs.materials.Rigid(friction=0.5),
            surface=gs.surfaces.Default(color=(0.4902, 0.5255, 0.5569, 1.0), roughness=0.9, metallic=0.0),
            name="floor",
        )
    }


def add_rail(scene):
    """Add 2 copies of rail."""
    copies = [
        # pos
        ((0.34, -0.067, -0.03),),
        ((0.34, 0.023, -0.03),),
    ]
    return {
        # case.yaml:14
        f"rail[{i}]": scene.add_entity(
            gs.morphs.Box(size=(0.3, 0.02, 0.03), pos=pos, fixed=True),
            material=gs.materials.Rigid(rho=1000.0, friction=0.5),
            surface=gs.surfaces.Default(color=(0.2235, 0.2588, 0.2941, 1.0), roughness=0.5, metallic=0.0),
            name=f"rail[{i}]",
        )
        for i, (pos,) in enumerate(copies)
    }


def add_post(scene):
    """Add 4 copies of post."""
    copies = [
        # pos
        ((0.22, -0.067, -0.0975),),
        ((0.22, 0.023, -0.0975),),
        ((0.46, -0.067, -0.0975),),
        ((0.46, 0.023, -0.0975),),
    ]
    return {
        # case.yaml:19
        f"post[{i}]": scene.add_entity(
            gs.morphs.Box(size=(0.02, 0.02, 0.105), pos=pos, fixed=True),
            material=gs.materials.Rigid(rho=1000.0, friction=0.5),
            surface=gs.surfaces.Default(color=(0.2235, 0.2588, 0.2941, 1.0), roughness=0.5, metallic=0.0),
            name=f"post[{i}]",
        )
        for i, (pos,) in enumerate(copies)
    }


def add_pillar(scene):
    """Add pillar."""
    return {
        # case.yaml:24
        "pillar": scene.add_entity(
            gs.morphs.Box(size=(0.08, 0.03, 0.19), pos=(0.0, 0.05, -0.055), fixed=True),
            material=gs.materials.Rigid(rho=1000.0, friction=0.5),
            surface=gs.surfaces.Default(color=(0.2235, 0.2588, 0.2941, 1.0), roughness=0.5, metallic=0.0),
            name="pillar",
        )
    }


def add_plate(scene):
    """Add plate."""
    return {
        # case.yaml:28
        "plate": scene.add_entity(
            gs.morphs.Box(size=(0.66, 0.22, 0.01), pos=(0.22, -0.01, -0.155), fixed=True),
            material=gs.materials.Rigid(rho=1000.0, friction=0.5),
            surface=gs.surfaces.Default(color=(0.5412, 0.4157, 0.2667, 1.0), roughness=0.7, metallic=0.0),
            name="plate",
        )
    }


def add_statics(scene):
    """Add the static bodies; return the entities by name."""
    return {
        **add_floor(scene),
        **add_rail(scene),
        **add_post(scene),
        **add_pillar(scene),
        **add_plate(scene),
    }
