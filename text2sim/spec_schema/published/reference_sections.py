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
    sheets,
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
    MOTIONS,
    PLACES,
    PREFABS,
    SCULPT,
    SHOTS,
    VARIANTS,
)


@dataclass(frozen=True)
class ReferenceSection:
    """A part of the reference."""

    title: str
    level: int
    models: Any
    """A union on `kind`, or a tuple of models."""
    intro: str = ""
    examples: str = ""
    """Key in `examples.yaml`."""
    noun: str = ""
    """Noun for one kind of a union."""


SECTIONS = (
    ReferenceSection("The case", 2, (Case,)),
    ReferenceSection("`scene`: the stage", 2, (scene.Scene,)),
    ReferenceSection(
        "Statics", 3, (scene.Static,), "By name in `scene.statics`. Only a static can be a `plane`.", "statics"
    ),
    ReferenceSection(
        "Settings of the scene",
        3,
        (scene.Contact, scene.PairFriction, scene.Solver, scene.Record, scene.Domain),
        "In `contact`, `solver`, `record`, `domain`.",
    ),
    ReferenceSection(
        "Solvers of deformable bodies",
        3,
        (solvers.Mpm, solvers.Pbd, solvers.Fem, solvers.Ipc, solvers.SolverBounds),
        "In `mpm`, `pbd`, `fem`, `ipc` and `bounds`.",
    ),
    ReferenceSection("`bodies`: the actors", 2, bodies.Body, "By name in `bodies`.", "bodies", noun="body"),
    ReferenceSection(
        "Mounts",
        3,
        bodies.Mount,
        "In `mount` of a rigid body; joints of an articulated body have the same fields.",
        "mounts",
        noun="mount",
    ),
    ReferenceSection(
        "Parts of articulated bodies and chains",
        3,
        (bodies.Link, bodies.Loop, bodies.JointOverride, bodies.Payload),
        "In `links`, `loops`, `joints`, `payload`. All links but the root have a `joint`, much like a mount.",
    ),
    ReferenceSection("Pulleys of a rope", 3, (soft_bodies.Round,), "Among the points of `along` of a rope."),
    ReferenceSection("Motions", 3, motion.Motion, MOTIONS, "motions", noun="motion"),
    ReferenceSection("Shapes", 2, shapes.AnyShape, "In `shape`.", "shapes", noun="shape"),
    ReferenceSection(
        "Shapes of cloth", 3, sheets.ClothShape, "In `shape` of a cloth.", "cloth_shapes", noun="shape of cloth"
    ),
    ReferenceSection("Parts of a compound", 3, (shapes.Part,), "In `parts`."),
    ReferenceSection("Parts of a sculpt", 3, sculpts.AnySculptPart, SCULPT, "sculpt_parts", noun="part"),
    ReferenceSection("Cross-sections", 3, (sculpts.Section,), "In `sections` of a loft."),
    ReferenceSection("Poses and places", 2, (Pose, placement.Place, placement.Align), PLACES, "places"),
    ReferenceSection(
        "Regions on bodies",
        3,
        (regions.BodyRegion, regions.Block, regions.Ball, regions.BodyPoint),
        BODY_REGIONS,
        "body_regions",
    ),
    ReferenceSection("Copies", 2, repeat.Repeat, "In `repeat`.", "repeats", noun="pattern"),
    ReferenceSection(
        "Regions of space",
        3,
        space.Region,
        "In `region` of a packing, a measure or an event.",
        "regions",
        noun="region of space",
    ),
    ReferenceSection(
        "Materials, joints and looks",
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
    ReferenceSection(
        "Materials of deformable bodies",
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
    ReferenceSection("`actions`: the script", 2, (actions.Actions,)),
    ReferenceSection("Controls", 3, controls.Control, "Actions on the bodies.", "controls", noun="control"),
    ReferenceSection(
        "Schedules",
        3,
        motion.Schedule,
        "Wherever a schedule is accepted: a number, or one of these. Times are relative to the start of the run, also "
        "for a control with `during`, but to the event for a drive with `on`.",
        "schedules",
        noun="schedule",
    ),
    ReferenceSection(
        "Measures",
        3,
        measures.Measure,
        "Numbers over time. `stat` combines several copies; kinds without it take all together.",
        "measures",
        noun="measure",
    ),
    ReferenceSection(
        "Events",
        3,
        events.Event,
        "Moments that physics determines: driven bodies cannot be their subjects.",
        "events",
        noun="event",
    ),
    ReferenceSection("Expectations", 3, (expectations.Expect,), "", "expectations"),
    ReferenceSection("`render`: the film", 2, (render.Render,), FILM),
    ReferenceSection("Shots and overlays", 3, (render.Shot, render.Overlay, Bounds), SHOTS),
    ReferenceSection("Cameras", 3, cameras.Camera, "By name in `render.cameras`.", "cameras", noun="camera"),
    ReferenceSection("Lights", 3, lights.Light, LIGHTS, "lights", noun="light"),
    ReferenceSection("Reuse: prefabs", 2, (Prefab, PrefabParam, Use), PREFABS),
    ReferenceSection("Variants and sweeps", 2, (Sweep,), VARIANTS),
)
