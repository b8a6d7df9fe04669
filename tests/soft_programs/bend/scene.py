"""The scene of bend: time, gravity, solver settings and static bodies."""

import genesis as gs
from engine import mend

DT = 0.01  # time step [s]
STEPS = 30  # 0.3 s of simulated time
RECORD_EVERY = 2  # steps between recorded frames
MAX_SPEED = 22.0  # the run has diverged if a body is faster [m/s]


def start_engine(backend):
    """Start the engine. Call once per process."""
    mend(sap=True)
    gs.init(backend=backend, precision="64", seed=0, logging_level="warning")


def make_scene(vis_options=None):
    """Return an empty scene."""
    return gs.Scene(
        sim_options=gs.options.SimOptions(
            dt=DT,
            substeps=1,  # the implicit solver damps motion at longer steps
            gravity=(0.0, 0.0, -9.81),
        ),
        rigid_options=gs.options.RigidOptions(
            constraint_solver=gs.constraint_solver.Newton,  # few enough bodies for the exact solver
            iterations=50,
            tolerance=1e-08,
            friction_cone=gs.friction_cone.pyramidal,  # survives hard impacts; elliptic does not creep on slopes
            constraint_timeconst=0.02,  # two substeps: the stiffest contact that stays stable
            max_collision_pairs=150,  # 16 for each of 2 convex pieces
        ),
        fem_options=gs.options.FEMOptions(
            use_implicit_solver=True,
            n_newton_iterations=2,  # one leaves turning elements unsolved
            damping_alpha=2.0,
            damping_beta=0.0005,  # as the engine has it
            floor_height=0.0,
            enable_vertex_constraints=True,
        ),
        coupler_options=gs.options.SAPCouplerOptions(
            rigid_floor_contact_type="vert",  # "tet" overestimates the depth of side faces by metres
        ),
        vis_options=vis_options or gs.options.VisOptions(),
        show_viewer=False,
    )


def add_floor(scene):
    """Add floor."""
    return {
        # case.yaml:8
        "floor": scene.add_entity(
            gs.morphs.Plane(plane_size=(40.0, 40.0), pos=(0.0, 0.0, 0.0), collision=False),
            material=gs.materials.Rigid(friction=0.5, coup_friction=0.5),
            surface=gs.surfaces.Default(color=(0.5961, 0.6314, 0.6627, 1.0), roughness=0.9, metallic=0.0),
            name="floor",
        )
    }


def add_statics(scene):
    """Add the static bodies; return the entities by name."""
    return {
        **add_floor(scene),
    }
