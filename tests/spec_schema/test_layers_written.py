"""Prefabs, variants and sweeps as they are written: their canonical form, their schema, their documentation."""

import copy
import re
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.published.json_schema import build_schema
from text2sim.spec_schema.published.reference_prose import PREFABS, VARIANTS
from text2sim.spec_schema.text.canonical import format_text
from text2sim.spec_schema.text.document import parse_document
from text2sim.spec_schema.text.source import Source

UGLY = """\
text2sim: 2
waive: {body-rests: "it hangs in the air, as in the picture"}
sweeps: {w: {grid: {bodies.c.look.opacity: [0.5, 1]}}, p: {points: {light: {params: {a: 1}}, dark: {params: {a: 2}}}}}
variants:
  # The soft one.
  soft: {params: {a: 5}, bodies: {ball: {look: {color: red}, material: {density: 500}}}}  # by hand
  long: {render: {cameras: {main: {kind: still, look_at: ball, from: [1,2,3]}}}, bodies: {ball: {pose: {pos: [1,2,3]},
    look: {finish: metal, color: terracotta}, material: {friction: 0.3, density: 500}}}}
name: a
params: {a: 1}
prefabs:
  cup: {body: {look: {color: "${color}"}, shape: {size: [1, 1, 1], kind: box}, kind: rigid}, params: {color: {default: red, kind: color}}, doc: A cup.}
bodies:
  c: {place: {on: floor}, look: {color: red}, with: {color: blue}, use: cup}  # a cup
  r: {hook: {look: {color: gold}}, use: curtain_rod}
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}}
scene: {duration: 1, statics: {t: {place: {on: floor}, use: table}, floor: {shape: {kind: plane}}}}
"""

NEAT = """\
text2sim: 2
name: a
params: {a: 1}

prefabs:
  cup:
    doc: A cup.
    params:
      color: {kind: color, default: red}
    body:
      kind: rigid
      shape: {kind: box, size: [1, 1, 1]}
      look: {color: "${color}"}

scene:
  duration: 1
  statics:
    t: {use: table, place: {on: floor}}
    floor: {shape: {kind: plane}}

bodies:
  c:
    use: cup
    with: {color: blue}
    place: {on: floor}
    look: {color: red}  # a cup
  r:
    use: curtain_rod
    hook: {look: {color: gold}}
  ball:
    kind: rigid
    shape: {kind: sphere, radius: 0.1}

variants:
  # The soft one.
  soft: {params: {a: 5}, bodies: {ball: {material: {density: 500}, look: {color: red}}}}  # by hand
  long:
    bodies:
      ball:
        material: {density: 500, friction: 0.3}
        pose: {pos: [1, 2, 3]}
        look: {color: terracotta, finish: metal}
    render: {cameras: {main: {kind: still, from: [1, 2, 3], look_at: ball}}}

sweeps:
  w: {grid: {bodies.c.look.opacity: [0.5, 1]}}
  p: {points: {light: {params: {a: 1}}, dark: {params: {a: 2}}}}

waive:
  body-rests: it hangs in the air, as in the picture
"""

PREFAB = """\
body: {use: cup, with: {color: "${hue}"}, look: {finish: metal}}
params:
  hue: {default: red, kind: color}   # its colour
doc: "A cup: one of metal, of which so much can be said that its words do not fit on one line, and yet are not put into quotes."
prefab: goblet
text2sim: 2
"""


@pytest.fixture(scope="module")
def validator() -> jsonschema.Draft7Validator:
    schema = build_schema()
    jsonschema.Draft7Validator.check_schema(schema)
    return jsonschema.Draft7Validator(schema)


def test_the_sections_have_their_form():
    neat = format_text(UGLY)
    assert neat.replace("  # a cup", "") == NEAT.replace("  # a cup", "")
    assert neat.count("# a cup") == 1
    assert format_text(neat) == neat
    assert load_text(neat).raw == load_text(UGLY).raw


def test_a_prefab_in_a_file_of_its_own_has_one_too():
    neat = format_text(PREFAB, "goblet.yaml")
    assert [line.partition(":")[0] for line in neat.splitlines() if line[0] != " "] == [
        "text2sim", "prefab", "doc", "params", "body",
    ]  # fmt: skip
    assert "\n  hue: {kind: color, default: red}  # its colour\n" in neat
    assert '\n  use: cup\n  with: {color: "${hue}"}\n  look: {finish: metal}\n' in neat
    assert "doc: >-\n  A cup: one of metal" in neat
    assert format_text(neat) == neat


def test_the_schema_takes_them(validator):
    validator.validate(parse_document(Source(UGLY)).data)
    validator.validate(load_text(UGLY).raw)


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("bodies/c/with", 3),
        ("bodies/c/use", None),
        ("bodies/c/look", {"color": "red", "colour": 1}),
        ("bodies/c/repeat", {"kind": "line", "cuont": 3}),
        ("variants/soft/bodis", {}),
        ("variants/soft/name", "b"),
        ("variants/soft/bodies/ball/material/densty", 3),
        ("variants/soft/bodies/ball/material/density", -3),
        ("prefabs/cup/params/color/kind", "colour"),
        ("prefabs/cup/body/shape/siz", 3),
        ("sweeps/w/grid", {}),
        ("sweeps/p/points/light/parms", {}),
        ("waive/body-rests", "short"),
    ],
)
def test_the_schema_refuses_what_is_wrong(validator, path, value):
    data: Any = copy.deepcopy(parse_document(Source(UGLY)).data)
    *way, last = path.split("/")
    target = data
    for step in way:
        target = target[step]
    target[last] = value
    assert not validator.is_valid(data)


@pytest.mark.parametrize(
    "variant",
    [
        {"bodies": {"ball": {"material": {"density": None, "mass": 3}}}},
        {"bodies": {"ball": None, "c": {"with": {"color": "red"}}, "r": {"hook": {"look": {"color": "red"}}}}},
        {"scene": {"duration": 3, "statics": {"t": {"place": None}}}},
        {"render": {"cameras": {"main": {"fov_deg": 30}}}, "prompt": "x", "waive": {"a": None}},
        {"prefabs": {"cup": {"params": {"color": {"default": "blue"}}}}},
    ],
)
def test_a_variant_need_not_say_everything(validator, variant):
    validator.validate(parse_document(Source(UGLY)).data | {"variants": {"x": variant}})


def test_what_the_reference_shows_is_a_case(tmp_path: Path):
    head = "text2sim: 2\nname: shown\nscene: {duration: 1, statics: {floor: {shape: {kind: plane}}}}\n"
    (shown,) = re.findall(r"```yaml\n(.*?)```", PREFABS, re.DOTALL)
    loaded = load_text(head + shown, tmp_path / "case.yaml")
    assert loaded.case.bodies["small"].shape.size == (0.25, 0.25, 0.25)
    (shown,) = re.findall(r"```yaml\n(.*?)```", VARIANTS, re.DOTALL)
    base = (
        "params: {speed: 3}\nbodies: {ball: {kind: rigid, shape: {kind: sphere, radius: 1}}}\n"
        "actions: {measures: {v: {kind: speed, of: ball}}, expect: {stays_whole: {measure: v, at: end, above: 1}}}\n"
    )
    assert load_text(head + base + shown).case.bodies["ball"].shape.radius == 1
