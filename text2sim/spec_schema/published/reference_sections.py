"""Sections of the language reference: their order, their text, and the models behind each."""

from dataclasses import dataclass
from typing import Any

from text2sim.spec_schema.models import (
    actions,
    bodies,
    cameras,
    controls,
    events,
    expectations,
    lights,
    materials,
    measures,
    motion,
    placement,
    regions,
    render,
    repeat,
    scene,
    sculpts,
    shapes,
    soft_bodies,
    soft_materials,
    solvers,
    space,
)
from text2sim.spec_schema.models.base import Bounds, Pose
from text2sim.spec_schema.models.case import Case
from text2sim.spec_schema.models.prefab_models import Prefab, PrefabParam, Use
from text2sim.spec_schema.models.sweep_models import Sweep
from text2sim.spec_schema.published.reference_prose import (
    BODY_REGIONS,
    FILM,
    LIGHTS,
    PLACES,
    PREFABS,
    SCULPT,
    SHOTS,
    VARIANTS,
)


@dataclass(frozen=True)
class Section:
    """A part of the reference."""

    title: str
    noun: str
    """What one of its kinds is called."""
    level: int
    models: Any
    """A union on `kind`, or a tuple of models."""
    intro: str = ""
    examples: str = ""
    """Key in `examples.yaml`."""


SECTIONS = (
    Section("The case", "case", 2, (Case,)),
    Section("`scene`: the stage", "scene", 2, (scene.Scene,)),
    Section("Statics", "static", 3, (scene.Static,), "By name in `scene.statics`. Only a static can be a `plane`."),
    Section(
        "Settings of the scene",
        "setting",
        3,
        (scene.Contact, scene.PairFriction, scene.Solver, scene.Record, scene.Domain),
        "In `contact`, `solver`, `record`, `domain`.",
    ),
    Section(
        "Solvers of deformable bodies",
        "solver",
        3,
        (solvers.Mpm, solvers.Pbd, solvers.Fem, solvers.Ipc, solvers.SolverBounds),
        "In `mpm`, `pbd`, `fem`, `ipc` and `bounds`.",
    ),
    Section("`bodies`: the actors", "body", 2, bodies.Body, "By name in `bodies`.", "bodies"),
    Section(
        "Mounts",
        "mount",
        3,
        bodies.Mount,
        "In `mount` of a rigid body; joints of an articulated body have the same fields.",
        "mounts",
    ),
    Section(
        "Parts of articulated bodies and chains",
        "part",
        3,
        (bodies.Link, bodies.Loop, bodies.JointOverride, bodies.Payload),
        "In `links`, `loops`, `joints`, `payload`. All links but the root have a `joint`, much like a mount.",
    ),
    Section("What a rope goes round", "pulley", 3, (soft_bodies.Round,), "Among the points of `along` of a rope."),
    Section("Motions", "motion", 3, motion.Motion, "In `motion` of a driven body.", "motions"),
    Section("Shapes", "shape", 2, shapes.StaticShape, "In `shape`.", "shapes"),
    Section("Shapes of cloth", "shape of cloth", 3, shapes.ClothShape, "In `shape` of a cloth.", "cloth_shapes"),
    Section("Parts of a compound", "part", 3, (shapes.Part,), "In `parts`."),
    Section("Parts of a sculpt", "part", 3, sculpts.AnySculptPart, SCULPT, "sculpt_parts"),
    Section("Cross-sections", "section", 3, (sculpts.Section,), "In `sections` of a loft."),
    Section(
        "Poses and places",
        "pose",
        2,
        (Pose, placement.Place, placement.Align),
        PLACES,
        "places",
    ),
    Section(
        "Regions on bodies",
        "region",
        3,
        (regions.BodyRegion, regions.Block, regions.Ball, regions.BodyPoint),
        BODY_REGIONS,
        "body_regions",
    ),
    Section("Copies", "pattern", 2, repeat.Repeat, "In `repeat`.", "repeats"),
    Section(
        "Regions of space",
        "region of space",
        3,
        space.Region,
        "In `region` of a packing, a measure or an event.",
        "regions",
    ),
    Section(
        "Materials, joints and looks",
        "material",
        2,
        (
            materials.Material,
            materials.JointDynamics,
            materials.Actuator,
            materials.Look,
            materials.Pattern,
            materials.Label,
            materials.Palette,
            materials.Vary,
        ),
        "In `material`, `joint`, `actuator`, `look`, `vary`. Mounts have the fields of a joint as well.",
        "surfaces",
    ),
    Section(
        "Materials of deformable bodies",
        "material",
        3,
        (
            soft_materials.SoftMaterial,
            soft_materials.ClothMaterial,
            soft_materials.GranularMaterial,
            soft_materials.LiquidMaterial,
            soft_materials.SnowMaterial,
        ),
        "In `material` of a soft body, a cloth, grains, a liquid, snow.",
    ),
    Section("`actions`: the script", "script", 2, (actions.Actions,)),
    Section("Controls", "control", 3, controls.Control, "What acts on the bodies.", "controls"),
    Section(
        "Schedules",
        "schedule",
        3,
        motion.Schedule,
        "Wherever a schedule is taken: a number, or one of these. Times count from the start of the run, also of a "
        "force with `during`; of a drive with `on`, from its event.",
        "schedules",
    ),
    Section(
        "Measures",
        "measure",
        3,
        measures.Measure,
        "Numbers over time. Where `of` means several copies, `stat` says how they become one number.",
        "measures",
    ),
    Section(
        "Events",
        "event",
        3,
        events.Event,
        "Moments. Physics has to decide about them: what is driven cannot be their subject.",
        "events",
    ),
    Section("Expectations", "expectation", 3, (expectations.Expect,), "", "expectations"),
    Section("`render`: the film", "film", 2, (render.Render,), FILM),
    Section("Shots and overlays", "shot", 3, (render.Shot, render.Overlay, Bounds), SHOTS),
    Section("Cameras", "camera", 3, cameras.Camera, "By name in `render.cameras`.", "cameras"),
    Section("Lights", "light", 3, lights.Light, LIGHTS, "lights"),
    Section("Reuse: prefabs", "prefab", 2, (Prefab, PrefabParam, Use), PREFABS),
    Section("Variants and sweeps", "sweep", 2, (Sweep,), VARIANTS),
)
