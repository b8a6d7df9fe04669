"""Prose of the language reference: its introduction, and those of its sections."""

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
  scene, and `text2sim check --settings` says how.
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
| `net.x5_*`, `arm.*` | all links or joints whose names fit; in measures and contact events |

A rigid body on a hinge or slider has one joint, which goes by the body's name. A joint of an articulated body
goes by the name of its link. A joint's position counts from the pose that the case describes.

Parts of a compound, links, measures, events and expectations can stand for several, too, with a number as their
`repeat`: `spoke` with `repeat: 12` becomes `spoke_0` to `spoke_11`, and `k` in its `${…}` is the number of each.
"""

PLACES = """\
In `pose` or `place`: one of the two. All places come from the true shapes, not from boxes around them.

| `place` | where it goes | what it leaves open |
|---|---|---|
| `on: table` | let down until it touches; on its middle | x, y |
| `above: table` | its lowest point over the other's highest | x, y |
| `below: table` | its highest point under the other's lowest | x, y |
| `inside: cup` | let down in the hollow until it touches; walls must be round it | x, y |
| `left_of`, `right_of` | its side against the other's side, along x | y, z |
| `in_front_of`, `behind` | the same along y | x, z |
| `beside: wall`, `direction: [1, 1, 0]` | the same along any level direction | z, and across |
| `around: pole` | a ring on its pole: on its axis, half way up, turned with it | along the axis |
| `around: table`, with a ring of copies | the copies all round it, on its ground level | z |
| `touching: egg`, `direction: [1, 1, 1]` | moved from that side until the surfaces meet | across |

What is left open is the middle of both (in height: the same ground level), unless said otherwise:

| word | says |
|---|---|
| `at: [0.3, 0]` | x and y in the world at which its own origin (the middle of a pattern) goes |
| `at: {corner: [left, front]}`, `inset: 0.05` | in this corner of the other (in its own frame), 5 cm from its sides |
| `at: {edge: left}`, `at: {face: top}` | at the middle of this edge; in the middle |
| `align: top`, `align: {x: min, z: center}` | which ends line up |
| `offset: [0, 0, 0.1]` | moved by this in the end |
| `clearance: 0.002` | the gap that is left |
| `facing: table` | turned about the vertical until +x points there |

Places follow each other: a plate on a cloth on a table. Copies that have a `repeat` are placed together, as one
pattern; with brackets, `on: "plate[*]"`, one on each: as many as there are plates, and of the pattern only the turns
count. A place that differs from copy to copy (`on: "post[${i}]"`) puts each by itself.
"""

BODY_REGIONS = """\
In `place.at`, in `point` of an impulse or force, and in `look_at` of a camera. They are found on the true surface, in
the body's own frame; where one point is needed, its middle.

| region | of a box | of a sheet (flat) |
|---|---|---|
| `{face: top}` | its upper side | all of it |
| `{edge: [left, top]}` | one of twelve edges | |
| `{edge: left}` | the side, as `face` | one of four edges |
| `{corner: [left, front, top]}` | one of eight corners | |
| `{corner: [left, front]}` | an upright edge | one of four corners |
| `{box: {min: …, max: …}}`, `{sphere: {center: …, radius: …}}` | what lies in it | what lies in it |
| `{nearest: [0.1, 0, 0]}` | the nearest point of the surface | the nearest point |
"""

PREFABS = """\
A prefab is a body with parameters. `use` brings it in, `with` gives its parameters, and whatever else stands beside
them is laid over its body: a place, copies, another colour. A static can use a prefab whose body is rigid.

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
  prefabs` lists those); it is looked up in this order. The environment variable `TEXT2SIM_PREFABS` may name one more
  folder, which comes before those that are built in. A file has the keys of an entry and two more: `text2sim: 2` and
  `prefab: NAME`.
- A parameter without `default` is required. A default may be an expression over the other parameters. Arguments are
  checked like everything else, where they stand.
- Arguments go into the expressions of the prefab: they may be expressions over the parameters of the case, and may
  differ from copy to copy (`with: {side: "${0.2 + 0.1 * i}"}`).
- A prefab with several `bodies` becomes bodies called `NAME_PART` (`left_rod`, `left_hook`); inside it they call each
  other by the name of the part. What is laid over them goes by the part:
  `left: {use: curtain_rod, hook: {look: {color: gold}}}`.
- A prefab may use prefabs, @NESTED@ deep, and a case may come to @USES@ uses.
- After that the case is an ordinary one: a run folder holds it as `expanded.yaml`. What is wrong inside a prefab is
  reported where it is used, and says in which line of which prefab.
"""

FILM = """\
Nothing here can touch the physics: a change of `render`, or of the colour and finish of a body, films the recorded run
again. The preview has no shadows, no reflections and nothing that is out of focus or blurred by motion."""

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
In `parts` of a sculpt. All are joined in their order, then all cuts are made, then it is painted. A fin or an ear is a
flat ellipsoid or a loft, a limb, neck, tail or handle a `limb`, a trunk or a hull a `loft`, what a lathe makes a
`revolve`.

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
```"""

LIGHTS = """\
By name in `render.lights`, in place of those of `lighting`. Light says which way it goes. Its strength is an irradiance
in units in which 3.14 makes a white sheet white. How bright the film is follows from the lights; `exposure` changes
it."""

VARIANTS = """\
A variant is a named change to the case: what it says is laid over what the case says, key by key; `null` takes a key
away; a list is replaced. Where it gives a `kind` (or a `use`) that is another one, the mapping is replaced as a whole.
It may change `prompt`, `params`, `prefabs`, `scene`, `bodies`, `actions`, `render` and `waive`. A key that leads
nowhere is an error, whether the variant is asked for or not.

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

- `--variant NAME` chooses one, several in their order; `--set PATH=VALUE` sets one value (`--set
  bodies.ball.pose.pos[2]=1.5`). `check`, `run`, `test` and `compile` take both; `check --variants` checks every
  variant. Single values come last, and are checked like those in the file.
- `text2sim run CASE --sweep NAME` runs a sweep, `--grid PATH=[a,b,c]` one that is made up on the spot; at most @RUNS@
  runs. Each is a run like any other, so that a sweep that was interrupted goes on where it stopped.
- Nothing of this changes the file. The folder of a run is called after what was laid over the case.
"""
