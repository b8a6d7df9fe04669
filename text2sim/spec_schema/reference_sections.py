"""What the language reference says, and in which order: its text, and the models behind each section."""

from dataclasses import dataclass
from typing import Any

from text2sim.spec_schema import (
    actions,
    bodies,
    controls,
    events,
    expectations,
    materials,
    measures,
    motion,
    placement,
    render,
    scene,
    shapes,
)
from text2sim.spec_schema.base import Pose
from text2sim.spec_schema.case import Case


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


INTRODUCTION = """\
A case is one YAML document. It has a stage (`scene`), actors (`bodies`), a script (`actions`) and a film
(`render`). `text2sim check` says everything that is wrong with it, with the line and the nearest right word;
`text2sim fmt` brings it into its one canonical form. The same language as a JSON Schema, for editors:
`text2sim/spec_schema/case.schema.json`.

## Rules of the whole language

- **Everything has a name.** Bodies, statics, controls, measures, events and cameras are mappings by name,
  never lists. A name is a letter, then letters, digits or `_`, at most 48 in all. A body and a static cannot
  share one.
- **Units are SI**: m, kg, s, N, rad. Angles are in degrees only where a field ends in `deg`.
- **z points up.** Quaternions are (w, x, y, z). Left is -x, in front is -y.
- **`kind` says what something is**, and with it which other fields it has. Unknown fields are errors.
- **Nothing is done in secret.** What a case leaves out has the default given here, or is derived from the
  scene, and `text2sim check --explain` says how.
- **What moves, moves by physics.** There is no field for the path of a `rigid` body: it is driven by a joint
  with an actuator, by a force, an impulse, an attachment or a start velocity. A `driven` body has a
  prescribed motion, is listed in the evidence, and cannot be the subject of an event.

The YAML is that of version 1.2: `no` and `on` are words, `010` is ten, `1e-3` is a number. Keys cannot
repeat. Anchors, aliases, tags, several documents, `.nan` and `.inf` are refused: `params` and `repeat` do
what aliases would.

## Expressions

`${…}` is arithmetic over `params`. A value that is wholly one expression takes its type (a number, text, true
or false, a list); inside longer text it becomes part of the text. `$${` stands for the characters `${`.

```yaml
params: {rows: 8, brick: [0.24, 0.11, 0.07], top: "${rows * brick[2]}"}
```

- Operators: `+ - * / // % **`, comparisons, `and or not`, `a if condition else b`, `list[0]`, `[a, b, c]`.
  A division of whole numbers without remainder is a whole number: `${rows / 2}` can be a count.
- Functions: @FUNCTIONS@.
- Names: the parameters, `pi`, `tau`, `true`, `false`. Parameters may use each other, but not in a circle.
- Operators work on numbers, not on whole lists.
- At most @LENGTH@ characters, @DEPTH@ deep, and no number beyond @NUMBER@.

In `[${speed}, 0, 0]` an expression needs no quotes; `text2sim fmt` adds them, so that any YAML tool can read
the file.

## Copies and selectors

A body or static with `repeat` becomes several copies. Inside it, and in a control on it, these are known and
differ from copy to copy: `i` (0, 1, …), `n` (how many), `u` (`i / (n - 1)`, from 0 to 1), `row`, `column`,
`layer`.

```yaml
bodies:
  hook:
    kind: rigid
    shape: {kind: sphere, radius: 0.012}
    mount: {kind: slider, axis: x, actuator: {stiffness: 400, damping: 40}}
    repeat: {kind: line, count: 12, step: [0.09, 0, 0]}
    look: {color: "${'red' if i % 2 == 0 else 'white'}"}
```

| selector | means |
|---|---|
| `brick`, `brick[*]` | every copy |
| `brick[3]` | one copy, counted from 0 |
| `brick[2:5]` | the copies 2, 3 and 4 |
| `arm.hand` | the link or joint `hand` of the articulated body `arm` |
| `arm[1].hand` | the same, of one copy |

A rigid body on a hinge or slider has one joint, which goes by the body's name. A joint of an articulated body
goes by the name of its link. A joint's position counts from the pose that the case describes.
"""

SECTIONS = (
    Section("The case", "case", 2, (Case,)),
    Section("`scene`: the stage", "scene", 2, (scene.Scene,)),
    Section("Statics", "static", 3, (scene.Static,), "By name in `scene.statics`. Only a static can be a `plane`."),
    Section(
        "Settings of the scene",
        "setting",
        3,
        (scene.Contact, scene.Solver, scene.Record, scene.Domain),
        "In `contact`, `solver`, `record`, `domain`.",
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
    Section("Motions", "motion", 3, motion.Motion, "In `motion` of a driven body.", "motions"),
    Section("Shapes", "shape", 2, shapes.StaticShape, "In `shape`.", "shapes"),
    Section("Parts of a compound", "part", 3, (shapes.Part,), "In `parts`."),
    Section(
        "Poses and places",
        "pose",
        2,
        (Pose, placement.Place),
        "In `pose` or `place`: one of the two.",
        "places",
    ),
    Section("Copies", "pattern", 2, placement.Repeat, "In `repeat`.", "repeats"),
    Section(
        "Regions of space",
        "region",
        3,
        placement.Region,
        "In `region` of a packing, a measure or an event.",
        "regions",
    ),
    Section(
        "Materials, joints and looks",
        "material",
        2,
        (materials.Material, materials.JointDynamics, materials.Actuator, materials.Look, materials.Vary),
        "In `material`, `joint`, `actuator`, `look`, `vary`. Mounts have the fields of a joint as well.",
        "surfaces",
    ),
    Section("`actions`: the script", "script", 2, (actions.Actions,)),
    Section("Controls", "control", 3, controls.Control, "What acts on the bodies.", "controls"),
    Section(
        "Schedules",
        "schedule",
        3,
        motion.Schedule,
        "Wherever a schedule is taken: a number, or one of these.",
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
    Section("`render`: the film", "film", 2, (render.Render,), "Nothing here can touch the physics."),
    Section("Cameras", "camera", 3, render.Camera, "", "cameras"),
    Section("Lights", "light", 3, render.Light, "", "lights"),
)
