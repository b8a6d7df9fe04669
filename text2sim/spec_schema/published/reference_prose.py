"""Introductions of the language reference and of its sections."""

INTRODUCTION = """\
A case is one YAML document. It has a stage (`scene`), actors (`bodies`), a script (`actions`) and a film
(`render`). `text2sim check` reports all errors in it, with the line and the nearest valid word; `text2sim fmt` formats
it canonically. `text2sim/spec_schema/case.schema.json` is a JSON Schema of the same language, for editors.

## Rules of the whole language

- **Everything has a name.** Bodies, statics, controls, measures, events and cameras are mappings by name, never lists.
  A name is a letter followed by letters, digits or `_`, at most 48 characters. A body and a static cannot have the same
  name.
- **Units are SI**: m, kg, s, N, rad. Angles are in degrees only where a field ends in `deg`.
- **z points up.** Quaternions are (w, x, y, z). Left is -x, in front is -y.
- **`kind` determines the type** of an entry, and thus its other fields. Unknown fields are errors.
- **Nothing is hidden.** Values that a case leaves out have the default given here, or are derived from the scene;
  `text2sim check --settings` says how.
- **Bodies move by physics.** There is no field for the path of a `rigid` body: it is moved by a joint with an actuator,
  a force, an impulse, an attachment or a start velocity. A `driven` body has a prescribed motion, is listed in the
  evidence, and cannot be the subject of an event.

YAML is read by the rules of version 1.2: `no` and `on` are words, `010` is ten, `1e-3` is a number. Keys must be
unique. Anchors, aliases, tags, several documents, `.nan` and `.inf` are rejected; `params` and `repeat` replace
aliases.

## Expressions

`${…}` is arithmetic over `params`. A value that consists of one expression has its type (a number, text, true or false,
a list); inside longer text it becomes part of the text. `$${` denotes the characters `${`.

```yaml
params: {rows: 8, brick: [0.24, 0.11, 0.07], top: "${rows * brick[2]}"}
```

- Operators: `+ - * / // % **`, comparisons, `and or not`, `a if condition else b`, `list[0]`, `[a, b, c]`.
  A division of whole numbers without remainder yields a whole number: `${rows / 2}` can be a count.
- Functions: @FUNCTIONS@.
- Names: the parameters, `pi`, `tau`, `true`, `false`. Parameters may use each other, but not in a cycle.
- Operators work on numbers, not on whole lists.
- At most @LENGTH@ characters, @DEPTH@ deep, and no number beyond @NUMBER@.

In `[${speed}, 0, 0]` an expression needs no quotes; `text2sim fmt` adds them, so that any YAML parser can read the
file.

## Copies and selectors

A body or static with `repeat` becomes several copies. Inside it, and in a control on it, expressions can use these
variables of each copy: `i` (0, 1, …), `n` (number of copies), `u` (`i / (n - 1)`, from 0 to 1), `row`, `column`,
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

| selector | meaning |
|---|---|
| `brick`, `brick[*]` | every copy |
| `brick[3]` | one copy, counted from 0 |
| `brick[2:5]` | the copies 2, 3 and 4 |
| `arm.hand` | the link or joint `hand` of the articulated body `arm` |
| `arm[1].hand` | the same, of one copy |
| `net.x5_*`, `arm.*` | all links or joints with matching names; in measures and contact events |
| `chair.leg`, `chair.leg_*` | parts of a rigid compound; only in `threaded`, and in contact of rigid bodies |
| `[brick[3], ball]` | all that the list selects, each once; in `of` of measures and events, `by` and `to` of measures |

A rigid body on a hinge or slider has one joint, with the name of the body. A joint of an articulated body has the name
of its link. The position of a joint is relative to the pose in the case.

Parts of a compound, links, measures, events and expectations can also be multiplied, with a number as their `repeat`:
`spoke` with `repeat: 12` becomes `spoke_0` to `spoke_11`, and `k` in its `${…}` is the number of each.
"""

PLACES = """\
In `pose` or `place`, one of the two. Placement uses the true shapes, not their bounding boxes.

| `place` | position | open directions |
|---|---|---|
| `on: table` | lowered until it touches, on the centre of the table | x, y |
| `above: table` | its lowest point above the other's highest | x, y |
| `below: table` | its highest point below the other's lowest | x, y |
| `inside: cup` | lowered into the cavity until it touches; walls must surround it | x, y |
| `left_of`, `right_of` | its side against the other's side, along x | y, z |
| `in_front_of`, `behind` | the same along y | x, z |
| `beside: wall`, `direction: [1, 1, 0]` | the same along any horizontal direction | z, and across |
| `around: pole` | a ring on a pole: on its axis, at half its height, aligned with it | along the axis |
| `around: table`, with a ring of copies | the copies around it, on its ground level | z |
| `touching: egg`, `direction: [1, 1, 1]` | moved from that side until the surfaces touch | across |
| `relative_to: board`, `pos: [0, 0.1, 0.02]` | in the frame of the other, which its orientation and pattern follow | |

Open directions are centred (in height: on the same ground level), unless one of these determines them:

| field | meaning |
|---|---|
| `at: [0.3, 0]` | x and y in the world of its origin (for a pattern, of its centre) |
| `at: {corner: [left, front]}`, `inset: 0.05` | in this corner of the other (in its own frame), 5 cm from its sides |
| `at: {edge: left}`, `at: {face: top}` | at the middle of this edge; in the centre of this face |
| `align: top`, `align: {x: min, z: center}` | alignment of ends or centres |
| `offset: [0, 0, 0.1]` | final displacement |
| `clearance: 0.002` | gap between the surfaces |
| `facing: table` | rotated about the vertical until +x points there |

Placements can be chained: a plate on a cloth on a table. Copies from a `repeat` are placed together, as one pattern;
copies of different heights in a level pattern each stand `on` what is below. With brackets, as in `on: "plate[*]"`,
there is one on each: there must be as many copies as plates, and only the rotations of the pattern are used. A
placement that differs from copy to copy (`on: "post[${i}]"`) places each separately.
"""

MOTIONS = """\
In `motion` of a driven body, which either slides or turns. A body that does both, such as a rolling pin, is a link of
an articulated body, with a slider and a hinge one after the other. Here `turn` is the way divided by the radius, so
that the pin rolls without sliding; without a motor on its hinge, friction turns it. Another slider between the two
lowers it.

```yaml
bodies:
  pin:
    kind: articulated
    pose: {pos: [0, 0, 0.2]}
    links:
      rail: {shape: {kind: box, size: [0.8, 0.02, 0.02]}}
      carriage:
        parent: rail
        shape: {kind: box, size: [0.06, 0.32, 0.02]}
        pose: {pos: [-0.2, 0, -0.02]}
        joint: {kind: slider, axis: x, actuator: {stiffness: 20000, damping: 400}}
      roller:
        parent: carriage
        shape: {kind: cylinder, radius: 0.03, height: 0.3}
        pose: {pos: [0, 0, -0.1], euler_deg: [90, 0, 0]}
        joint: {kind: hinge, axis: z, actuator: {stiffness: 20, damping: 0.4}}
actions:
  controls:
    slide: {kind: drive, joint: pin.carriage, position: {kind: ramp, to: 0.4, end: 2}}
    turn: {kind: drive, joint: pin.roller, position: {kind: ramp, to: "${-0.4 / 0.03}", end: 2}}
```
"""

BODY_REGIONS = """\
In `place.at`, in `point` of an impulse or force, and in `look_at` of a camera. Regions are parts of the true surface,
in the body's own frame; where one point is needed, it is the centre.

| region | of a box | of a sheet (flat) |
|---|---|---|
| `{face: top}` | its top face | all of it |
| `{edge: [left, top]}` | one of twelve edges | |
| `{edge: left}` | the side, as `face` | one of four edges |
| `{corner: [left, front, top]}` | one of eight corners | |
| `{corner: [left, front]}` | a vertical edge | one of four corners |
| `{box: {min: …, max: …}}`, `{sphere: {center: …, radius: …}}` | the part inside | the part inside |
| `{nearest: [0.1, 0, 0]}` | the nearest point of the surface | the nearest point |
"""

PREFABS = """\
A prefab is a body with parameters. `use` names it, `with` sets its parameters, and all other keys override those of its
body: a place, copies, another colour. A static can use a prefab whose body is rigid.

```yaml
prefabs:
  crate:
    doc: A crate that stands on its underside.
    params:
      side: {kind: length, default: 0.4, min: 0.05, max: 2, doc: Of the cube.}
      plank: {kind: color, default: oak}
    body:
      kind: rigid
      shape: {kind: box, size: ["${side}", "${side}", "${side}"]}
      material: {density: "${120 / side}", friction: 0.5}
      look: {color: "${plank}", finish: wood}
bodies:
  small: {use: crate, with: {side: 0.25}, place: {on: floor, at: [1, 0]}}
  tower: {use: crate, place: {on: floor}, repeat: {kind: stack, count: 4}, look: {color: pine}}
```

- A prefab is an entry of `prefabs` in the case, a file `prefabs/NAME.yaml` in its folder, or built in (`text2sim
  prefabs` lists those), searched in this order. The environment variable `TEXT2SIM_PREFABS` may name another folder,
  which precedes the built-in prefabs. A file has the keys of an entry and two more: `text2sim: 2` and `prefab: NAME`.
- A parameter without `default` is required. A default may be an expression of the other parameters. Errors in arguments
  are reported at their position.
- Arguments are substituted into the expressions of the prefab: they may be expressions of the case's parameters, and
  may differ from copy to copy (`with: {side: "${0.2 + 0.1 * i}"}`).
- A prefab with several `bodies` becomes bodies with the names `NAME_PART` (`left_rod`, `left_hook`); inside it they
  refer to each other by the name of the part. Overrides are given by part:
  `left: {use: curtain_rod, hook: {look: {color: gold}}}`.
- Prefabs may use prefabs, up to @NESTED@ deep, and a case may have up to @USES@ uses.
- The result is an ordinary case, which a run folder contains as `expanded.yaml`. Errors inside a prefab are reported
  where it is used, with the line in the prefab.
"""

FILM = """\
This section has no influence on the physics: after a change of `render`, or of the colour and finish of a body, the
recorded run is filmed again. The preview has no shadows, reflections, depth of field or motion blur."""

SHOTS = """\
In `shots` and `overlay` of the film, and `within` of a camera.

```yaml
render:
  lighting: studio
  cameras:
    wide: {kind: still, frame: [ball, wall], lens_mm: 35}
    close: {kind: orbit, frame: ["brick[*]"], turn_deg: 40}
  shots:
    all_of_it: {camera: wide}
    again_slowly: {camera: close, from: 0.6, to: 0.8, speed: 0.1, hold: 1}
  overlay: {title: "A ball through a wall", time: true}
```
"""

SCULPT = """\
In `parts` of a sculpt. All are joined in their order, then all cuts are made, then paint is applied. Use a flat
ellipsoid or a `loft` for a fin or an ear, a `limb` for a limb, neck, tail or handle, a `loft` for a trunk or a hull,
and a `revolve` for turned parts.

```yaml
shape:
  kind: sculpt
  blend: 0.01
  parts:
    pot: {kind: revolve, smooth: true, profile: [[0.05, 0], [0.08, 0.04], [0.07, 0.1], [0.03, 0.12]]}
    spout: {kind: limb, points: [[0.06, 0, 0.04], [0.11, 0, 0.07], [0.13, 0, 0.12]], radii: [0.02, 0.014, 0.01]}
    handle: {kind: limb, points: [[-0.06, 0, 0.1], [-0.13, 0, 0.09], [-0.12, 0, 0.05], [-0.07, 0, 0.03]], radii: 0.009}
    knob: {kind: ellipsoid, radii: [0.014, 0.014, 0.014], pose: {pos: [0, 0, 0.13]}, look: {color: gold}}
    mouth: {kind: limb, op: cut, blend: 0.002, points: [[0.11, 0, 0.09], [0.14, 0, 0.15]], radii: 0.006}
```

A wire along a helix (a coil spring, the thread of a screw) is one straight piece, repeated along a turn. This one has 5
turns of 20 pieces, a radius of 30 mm, a pitch of 16 mm and a wire of 6 mm. It is rigid:

```yaml
shape:
  kind: sculpt
  parts:
    wire:
      kind: limb
      repeat: 100
      points: [[0.03, 0, 0], ["${0.03 * cos(2 * pi / 20)}", "${0.03 * sin(2 * pi / 20)}", "${0.016 / 20}"]]
      radii: 0.003
      pose: {pos: [0, 0, "${k * 0.016 / 20}"], euler_deg: [0, 0, "${k * 360 / 20}"]}
```"""

LIGHTS = """\
By name in `render.lights`, instead of those of `lighting`. The direction of a light is the one in which it travels. In
the units of its strength, an irradiance of 3.14 makes a white sheet white. The brightness of the film is derived from
the lights, for a sheet that faces the strongest, and up to 0.8 stops more where light only grazes what the first camera
sees; `exposure` changes it."""

VARIANTS = """\
A variant is a named change to the case, which is merged into it key by key; `null` removes a key; a list is replaced. A
mapping with another `kind` (or `use`) is replaced as a whole. A variant may change `prompt`, `params`, `prefabs`,
`scene`, `bodies`, `actions`, `render` and `waive`. An unknown key is an error, even if the variant is not used.

```yaml
variants:
  soft: {bodies: {ball: {material: {density: 500}}}}
  fast:
    params: {speed: 20}
    actions: {expect: {stays_whole: null}}
sweeps:
  weights: {grid: {bodies.ball.material.density: [500, 2000, 7800], params.speed: [6, 12]}}
  both: {variants: [soft, fast]}
  marked: {points: {light: {params: {speed: 6}}, heavy: {params: {speed: 12}}}}
```

- `--variant NAME` applies a variant, or several in their order; `--set PATH=VALUE` sets one value (`--set
  bodies.ball.pose.pos[2]=1.5`). `check`, `run`, `test` and `compile` accept both; `check --variants` checks every
  variant. Single values are applied last, and are checked like those in the file.
- `text2sim run CASE --sweep NAME` runs a sweep, `--grid PATH=[a,b,c]` an ad hoc one, of at most @RUNS@ runs. Each is an
  ordinary run, so that an interrupted sweep continues where it stopped.
- None of this changes the file. The name of a run's folder includes the changes.
"""
