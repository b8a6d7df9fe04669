"""Restitution and friction against rolling reach the engine from bodies, links and payloads."""

import pytest

from text2sim.compiler.build import resolve_case
from text2sim.compiler.emit import emit
from text2sim.lint import lint_case
from text2sim.spec_schema.load import load_text

HEAD = "text2sim: 2\nname: touch\nscene: {duration: 1, %sstatics: {floor: {shape: {kind: plane}}}}\nbodies:\n"
BALL = "  ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [3, 0, 1]}%s}\n"
PAIR = """\
  pair:
    kind: articulated
    base: free
    links:
      a: {shape: {kind: sphere, radius: 0.05}, material: {%s}}
      b: {parent: a, pose: {pos: [0.2, 0, 0]}, shape: {kind: sphere, radius: 0.05}, joint: {kind: hinge, axis: y}}
    pose: {pos: [0, 0, 1]}
"""
WRECKER = """\
  wrecker:
    kind: chain
    links: 3
    link_length: 0.1
    radius: 0.01
    payload: {shape: {kind: sphere, radius: 0.1}, material: {%s}}
    pose: {pos: [0, 0, 2]}
"""


def resolved(bodies, scene=""):
    return resolve_case(load_text(HEAD % scene + bodies))


@pytest.mark.parametrize(("body", "link"), [(PAIR, "pair.a"), (WRECKER, "wrecker.payload")])
def test_a_link_bounces_by_itself(body, link):
    contact = resolved(BALL % "" + body % "restitution: 0.9").plan.contact
    bouncing = {name for name, (_, ratio) in contact.items() if ratio < 1}
    assert bouncing == {"floor", link}, "the floor says nothing: it takes the largest"


def test_deformable_bodies_have_no_contacts_to_set():
    jelly = "  jelly: {kind: soft, solver: mpm, shape: {kind: sphere, radius: 0.2}, pose: {pos: [3, 0, 1]}}\n"
    contact = resolved(BALL % ", material: {restitution: 0.7}" + jelly).plan.contact
    assert "ball" in contact
    assert "jelly" not in contact, "its program would not start"


def test_the_program_sets_the_links_after_the_bodies():
    program = emit(resolved(PAIR % "restitution: 0.9").plan)["bodies.py"].decode()
    assert '("pair", "a"): (0.0' in program
    assert program.index("in CONTACT_DAMPING.items") < program.index("in LINK_CONTACT_DAMPING.items")


def test_the_lint_points_at_the_link():
    hasty = "substeps: 1, contact: {timeconst: 0.02}, "
    (problem,) = [
        one for one in lint_case(resolved(PAIR % "restitution: 0.9", hasty)).problems if one.rule == "restitution-step"
    ]
    assert problem.path == "/bodies/pair/links/a/material/restitution"


def test_without_such_friction_nothing_is_written_of_it():
    plan = resolved(BALL % "" + PAIR % "friction: 0.4").plan
    assert not plan.settings.rolls
    assert all(not entity.material_options for group in plan.bodies for entity in group.entities)
    assert b'friction="0.4"' in plan.files["models/pair.xml"]


def test_one_body_that_resists_makes_all_others_say_that_they_do_not():
    plan = resolved(
        BALL % ", material: {rolling_friction: 0.01}" + PAIR % "torsional_friction: 0.02" + WRECKER % ""
    ).plan
    (ball,) = plan.bodies[0].entities
    (floor,) = plan.statics[0].entities
    assert ball.material_options == {"friction_torsional": 0.0, "friction_rolling": 0.01}
    assert floor.material_options == {"friction_torsional": 0.0, "friction_rolling": 0.0}
    assert plan.settings.rolls and plan.settings.cone == "pyramidal", "links that are hit hard"
    xml = plan.files["models/pair.xml"].decode()
    assert xml.count('friction="0.5 0.02 0" condim="6"') == 1 and xml.count('friction="0.5"') == 1
    chain = resolved(WRECKER.replace("radius: 0.01", "radius: 0.01\n    material: {rolling_friction: 0.01}") % "")
    assert chain.plan.files["models/wrecker.xml"].count(b'friction="0.5 0 0.01"') == 4
    rolls = BALL % ", material: {rolling_friction: 0.01}"
    assert resolved(rolls).plan.settings.cone == "elliptic"
    rag = "  rag: {kind: cloth, shape: {kind: sheet, size: [0.3, 0.3]}, pose: {pos: [2, 0, 1]}}\n"
    assert resolved(rolls + rag).plan.settings.cone == "elliptic", "a football slows down beside a tent, too"
