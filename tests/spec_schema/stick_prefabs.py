"""Two prefabs that use what prefabs can have, and the head of a case for uses of them."""

STICK = """\
text2sim: 2
prefab: stick
doc: A stick.
params:
  length: {kind: length, default: 0.5, min: 0.1, max: 2, doc: How long.}
  thick: {kind: length, default: "${length / 10}"}
  count: {kind: integer, default: 3}
  at: {kind: vec3, default: [0, 0, 0], min: -5}
  hue: {kind: color, default: red}
  what: {kind: choice, of: [wood, metal], default: wood}
  on: {kind: body, default: floor}
  plain: {kind: bool, default: true}
body:
  kind: rigid
  shape: {kind: box, size: ["${thick}", "${thick}", "${length}"]}
  material: {density: "${700 if what == 'wood' else 7800}"}
  pose: {pos: "${at}"}
  look: {color: "${hue if plain else 'black'}", finish: "${what}"}
"""

GATE = """\
text2sim: 2
prefab: gate
params: {width: {kind: length}, hue: {kind: color, default: white}}
bodies:
  post: {use: stick, with: {length: "${width / 2}", hue: "${hue}"}, mount: {kind: fixed}}
  bar:
    kind: rigid
    shape: {kind: box, size: ["${width}", 0.1, 0.1]}
    place: {on: post, facing: "post[*]"}
"""

HEAD = """\
text2sim: 2
name: uses
params: {speed: 3, d: 0.2, low: -9}
scene: {duration: 1, statics: {floor: {shape: {kind: plane}}}}
"""
