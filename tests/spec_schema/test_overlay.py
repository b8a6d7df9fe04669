"""Variants and single values: what is laid over what, and what is wrong with them, word by word."""

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_case import problems_of

from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.spec_schema.reuse.expanded import expanded_text
from text2sim.spec_schema.reuse.overlay import CaseOverlay
from text2sim.spec_schema.reuse.trees import LocatedValue, merge
from text2sim.spec_schema.text.document import Node, parse_document
from text2sim.spec_schema.text.source import Source

CASE = """\
text2sim: 2
name: layers
params: {speed: 3, side: 0.1}
scene: {duration: 1, statics: {floor: {shape: {kind: plane}}}}
bodies:
  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, material: {density: 7800}, place: {on: floor}}
  box:
    kind: rigid
    shape: {kind: box, size: ["${side}", 1, 1]}
    pose: {pos: [0, 0, 2]}
actions:
  controls:
    push: {kind: force, body: ball, force: [1, 0, 0]}
  measures: {v: {kind: speed, of: ball}}
  expect: {moves: {measure: v, at: end, above: 1}}
variants:
  soft:
    bodies: {ball: {material: {density: 500}}}
    params: {speed: 5}
  cube: {bodies: {ball: {shape: {kind: box, size: [0.2, 0.2, 0.2]}}}}
  more:
    bodies: {third: {kind: ragdoll, height: 1}, ball: {place: {on: null, above: floor}}}
    actions: {expect: {moves: null}, measures: {w: {kind: speed, of: third}}}
  later: {bodies: {third: {height: 1.5}}}
  own: {params: {half: 0.5}, bodies: {ball: {shape: {radius: "${half}"}}}}
"""


def load(*variants: str, sets: tuple[str, ...] = (), text: str = CASE) -> LoadedCase:
    return load_text(text, overlay=CaseOverlay(variants, sets))


def problems(*variants: str, sets: tuple[str, ...] = (), text: str = CASE) -> list[Problem]:
    return problems_of(text, overlay=CaseOverlay(variants, sets))


# --- variants ---------------------------------------------------------------------------------------------------


def test_a_case_with_variants_is_the_case_without_them():
    loaded = load()
    assert loaded.case.bodies["ball"].material.density == 7800
    assert "variants" in loaded.written.data
    assert "variants" not in loaded.raw


def test_a_variant_changes_what_it_says_and_nothing_else():
    loaded = load("soft")
    assert loaded.case.bodies["ball"].material.density == 500
    assert loaded.data["params"] == {"speed": 5, "side": 0.1}
    assert loaded.raw["bodies"]["ball"]["shape"] == {"kind": "sphere", "radius": 0.1}
    assert loaded.overlay == CaseOverlay(("soft",))


def test_another_kind_replaces_the_mapping():
    assert load("cube").raw["bodies"]["ball"]["shape"] == {"kind": "box", "size": [0.2, 0.2, 0.2]}


def test_null_takes_away():
    loaded = load("more")
    assert loaded.raw["bodies"]["ball"]["place"] == {"above": "floor"}
    assert loaded.raw["actions"]["expect"] == {}


def test_variants_are_laid_over_each_other_in_their_order():
    assert load("more", "later").case.bodies["third"].height == 1.5
    assert load("soft", "cube").case.bodies["ball"].material.density == 500
    assert [p.rule for p in problems("later")] == ["missing-kind"]


def test_values_of_a_variant_stand_where_they_are_written():
    loaded = load("soft")
    assert loaded.line("/bodies/ball/material/density") == 18
    assert loaded.line("/bodies/ball/material") == 6
    text = CASE.replace("density: 500", "density: -500")
    (problem,) = problems("soft", text=text)
    assert (problem.line, problem.column) == (18, 41)
    assert load(text=text).case.bodies["ball"].material.density == 7800


def test_an_expanded_case_is_an_ordinary_one():
    loaded = load("soft", "more", sets=("bodies.box.pose.pos[2]=3",))
    again = load_text(expanded_text(loaded))
    assert again.data == loaded.data
    assert again.case == loaded.case
    assert not again.overlay


@pytest.mark.parametrize(
    ("variant", "path", "hint"),
    [
        ("{bodis: {}}", "/bodis", "bodies"),
        ("{name: other}", "/name", None),
        ("{variants: {}}", "/variants", None),
        ("{scene: {duratoin: 3}}", "/scene/duratoin", "duration"),
        ("{scene: {statics: {flor: {look: {color: red}}}}}", "/scene/statics/flor", "floor"),
        ("{bodies: {bal: {look: {color: red}}}}", "/bodies/bal", "ball"),
        ("{bodies: {bal: null}}", "/bodies/bal", "ball"),
        ("{bodies: {ball: {shape: {raduis: 3}}}}", "/bodies/ball/shape/raduis", "radius"),
        ("{bodies: {ball: {shape: {kind: box, siz: 3}}}}", "/bodies/ball/shape/siz", "size"),
        ("{bodies: {ball: {mount: {axs: x}}}}", "/bodies/ball/mount/axs", "axis"),
        ("{params: {sped: 3}}", "/params/sped", "speed"),
        ("{actions: {expect: {move: {above: 3}}}}", "/actions/expect/move", "moves"),
        ("{actions: {controls: {push: {forse: 3}}}}", "/actions/controls/push/forse", "force"),
        ("{render: {cameras: {main: {fov_deg: 30}}}}", "/render/cameras/main", None),
    ],
)
def test_a_key_that_leads_nowhere_is_reported_whether_it_is_asked_for_or_not(variant, path, hint):
    (problem,) = problems(text=CASE + f"  bad: {variant}\n")
    assert (problem.path, problem.hint) == (f"/variants/bad{path}", hint)
    assert problem.line == len(CASE.splitlines()) + 1


def test_a_name_is_no_more_there_because_another_variant_has_the_same_slip():
    slip = "{params: {sped: 1}, bodies: {bal: {look: {color: red}}, tooth: null}}"
    found = problems(text=CASE + f"  bad: {slip}\n  worse: {slip}\n")
    paths = ["/params/sped", "/bodies/bal", "/bodies/tooth"]
    assert sorted(p.path for p in found) == sorted(
        f"/variants/{name}{path}" for name in ("bad", "worse") for path in paths
    )
    assert {p.hint for p in found} == {"speed", "ball", None}


@pytest.mark.parametrize(
    "variant",
    [
        "{prefabs: {pin: {body: {kind: rigid, shape: {kind: sphere, radius: 0.1}}}}, bodies: {p: {use: pin}}}",
        "{prefabs: {pin: {bodies: {a: {kind: ragdoll, height: 1}}}}, bodies: {p: {use: pin}}}",
        "{bodies: {arm: {kind: articulated, file: arm.urdf, initial: {elbow: 0.5}}}}",
        "{bodies: {arm: {use: robot_arm, pose: {pos: [0, 9, 0]}, initial: {panda_joint1: 0.5}}}}",
    ],
)
def test_what_brings_its_own_names_leads_somewhere(variant):
    assert load(text=CASE + f"  new: {variant}\n").case.name == load().case.name


@pytest.mark.parametrize("variant", ["3", "[1]", "x", "", "null"])
def test_a_variant_is_a_mapping(variant):
    (problem,) = problems(text=CASE + f"  bad: {variant}\n")
    assert (problem.path, problem.rule) == ("/variants/bad", "type")


@pytest.mark.parametrize("section", ["3", "[a]", "", "{9a: {}}", "{'a b': {}}"])
def test_variants_are_a_mapping_by_name(section):
    (problem,) = problems(text=CASE.split("variants:")[0] + f"variants: {section}\n")
    assert problem.path.startswith("/variants")


def test_a_variant_that_is_not_there():
    (problem,) = problems("sofd")
    assert (problem.file, problem.hint) == ("--variant", "soft")
    assert "there are soft, cube, more, later, own" in problem.message


# --- single values ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "path", "value"),
    [
        ("bodies.ball.material.density=500", ("bodies", "ball", "material", "density"), 500),
        ("bodies.ball.material.friction=0.9", ("bodies", "ball", "material", "friction"), 0.9),
        ("bodies.box.pose.pos[2]=3", ("bodies", "box", "pose", "pos"), [0, 0, 3]),
        ("bodies.box.shape.size[0]=3", ("bodies", "box", "shape", "size"), [3, 1, 1]),
        ("bodies.box.shape.size[1]=${2 * side}", ("bodies", "box", "shape", "size"), ["${side}", "${2 * side}", 1]),
        ("bodies.ball.look.color=#ff0000", ("bodies", "ball", "look", "color"), "#ff0000"),
        ("bodies.new={kind: ragdoll, height: 1}", ("bodies", "new"), {"kind": "ragdoll", "height": 1}),
        ("params.speed=[1, 2]", ("params", "speed"), [1, 2]),
        ("prompt=no", ("prompt",), "no"),
        ("bodies.ball.material.density=null", ("bodies", "ball", "material"), {}),
        ("scene.gravity=[0, 0, -1.62]", ("scene", "gravity"), [0, 0, -1.62]),
        ("bodies.ball.mount={kind: hinge, axis: y}", ("bodies", "ball", "mount"), {"kind": "hinge", "axis": "y"}),
    ],
)
def test_a_value_is_set(words, path, value):
    found = load(sets=(words,)).raw
    for step in path:
        found = found[step]
    assert found == value


def test_single_values_come_last_in_their_order():
    sets = ("bodies.ball.material.density=1", "bodies.ball.material.density=2")
    assert load("soft", sets=sets).case.bodies["ball"].material.density == 2
    sets = ("bodies.third={kind: ragdoll, height: 1}", "bodies.third.height=2")
    assert load(sets=sets).case.bodies["third"].height == 2


@pytest.mark.parametrize(
    ("words", "column", "says", "hint"),
    [
        ("bodies.ball.material.densty=3", 22, "`bodies.ball.material` takes density, mass", "density"),
        ("bodies.bal.material.density=3", 8, "there is no `bal` in `bodies`; there are ball, box", "ball"),
        ("bodies.new.height=3", 8, "there is no `new` in `bodies`", None),
        ("bodies.new=3", 8, "there is no `new` in `bodies`", None),
        ("body.ball=3", 1, "`body` cannot be changed, only prompt, params", "bodies"),
        ("mass_of_it=3", 1, "waive; a parameter is `params.mass_of_it`", None),
        ("name=x", 1, "`name` cannot be changed", None),
        ("params.sped=2", 8, "there is no `sped` in `params`; there are speed, side", "speed"),
        ("bodies.box.shape.size[3]=2", 23, "has 3 items, the last is bodies.box.shape.size[2]", None),
        ("bodies.box.shape.size.x=2", 23, "is a list; its items are bodies.box.shape.size[0]", None),
        ("bodies.box.shape.size[0].x=2", 26, "is the expression `${side}`: set the whole value", None),
        ("bodies.ball.pose.pos[0]=2", 22, "`bodies.ball.pose.pos` is not set in the case: set the whole value", None),
        ("bodies.ball.shape.radius.x=1", 26, "`bodies.ball.shape.radius` is 0.1, which has no keys", None),
        ("bodies.ball.shape.radius[0]=1", 26, "is 0.1, not a list", None),
        ("bodies.ball.look.color=", 24, "there is no value after `=`", None),
        ("bodies.ball.shape.radius=[1,", 26, "not valid YAML", None),
        ("bodies.ball.shape.radius=&a 1", 26, "anchors", None),
        ("bodies.ball.shape.radius=!!python/none 1", 26, "tags", None),
        ("bodies.ball.shape.radius=1e99", 26, "too large", None),
        ("bodies.box.pose.pos[0]=null", 24, "an item of a list cannot be removed", None),
        ("bodies.ball", 1, "sets nothing: write PATH=VALUE", None),
        ("=3", 1, "there is no path before `=`", None),
        ("a..b=3", 1, "a path has the form", None),
        ("", 1, "sets nothing", None),
    ],
)
def test_what_is_wrong_with_the_words_is_said_of_the_words(words, column, says, hint):
    (problem,) = problems(sets=("prompt=fine", words))
    assert (problem.file, problem.line, problem.column, problem.hint) == ("--set", 2, column, hint)
    assert says in problem.message


@pytest.mark.parametrize(
    ("words", "place", "says"),
    [
        ("bodies.ball.material.density=-3", (6, 79), "must be greater than 0 (got -3)"),
        ("bodies.ball.material.friction=9", (6, 69), "must be from 0.01 to 5 (got 9)"),
        ("bodies.ball.shape.kind=bx", (6, 37), "unknown kind `bx`"),
        ("bodies.box.pose.pos[2]=x", (10, 24), "needs a number"),
        ("bodies.box.shape.size[1]=${d * 2}", (9, 42), "unknown name `d`"),
    ],
)
def test_what_is_wrong_with_the_value_is_said_where_it_goes(words, place, says):
    (problem,) = problems(sets=(words,))
    assert (problem.line, problem.column) == place
    assert says in problem.message
    assert problem.message.endswith(f"(from `--set {words}`)")


def test_a_label_is_fit_for_the_name_of_a_file():
    overlay = CaseOverlay(
        ("soft",), ("bodies.ball.pose.pos[2]=[1, 2]", "prompt=../../etc/passwd", f"params.a={'x' * 500}")
    )
    assert overlay.label.startswith("soft-pos_2_1_2-prompt_.._.._etc")
    assert len(overlay.label) <= 48
    assert "/" not in overlay.label
    assert CaseOverlay().label == ""


# --- merging ----------------------------------------------------------------------------------------------------


def rfc_7396(base, over):
    if not isinstance(over, dict):
        return over
    result = dict(base) if isinstance(base, dict) else {}
    for key, value in over.items():
        if value is None:
            result.pop(key, None)
        else:
            result[key] = rfc_7396(result.get(key), value)
    return result


keys = st.sampled_from(["a", "b", "c", "d"])
trees = st.recursive(
    st.none() | st.integers(0, 9) | st.lists(st.integers(0, 3), max_size=3),
    lambda inner: st.dictionaries(keys, inner, max_size=3),
    max_leaves=12,
)


@given(st.dictionaries(keys, trees, max_size=4), st.dictionaries(keys, trees, max_size=4))
@settings(max_examples=150, deadline=None)
def test_merging_is_that_of_rfc_7396_and_knows_its_places(base, over):
    first, second = (tree_of(data) for data in (base, over))
    merged = merge(first, second)
    assert merged.data == rfc_7396(base, over)
    assert shape_of(merged.node) == shape_of(tree_of(merged.data).node)
    assert (first.data, second.data) == (base, over)


def tree_of(data) -> LocatedValue:
    document = parse_document(Source(json.dumps(data)))
    return LocatedValue(document.data, document.root)


def shape_of(node: Node):
    if isinstance(node.children, dict):
        assert node.children.keys() == node.keys.keys()
        return {key: shape_of(child) for key, child in node.children.items()}
    return None if node.children is None else [shape_of(child) for child in node.children]
