"""Statics whose surfaces move: what is said of wrong ones, the program of right ones, and what the lint expects."""

import pytest

from text2sim.compiler.build import resolve_case
from text2sim.compiler.emit import emit
from text2sim.lint.facts import Facts
from text2sim.lint.motion.causes import Causes
from text2sim.lint.motion.whereabouts import Whereabouts
from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.load import load_text

CASE = """\
text2sim: 2
name: belt
scene:
  duration: 2
  statics:
    belt: {{shape: {shape}, pose: {{pos: [0, 0, 1], euler_deg: [0, 0, 90]}}, surface_velocity: {velocity}}}
    {floor}
  {settings}
bodies:
  parcel: {{kind: rigid, shape: {{kind: box, size: [0.2, 0.2, 0.2]}}, place: {{on: belt}}}}
  {fan}
actions: {{controls: {controls}}}
"""
BOX = "{kind: box, size: [2, 0.4, 0.1]}"
FAN = "fan: {kind: driven, shape: {kind: box, size: [1, 0.1, 0.1]}, pose: {pos: [0, 0, 3]}, motion: {kind: spin, speed: 3}}"


def case(
    shape: str = BOX, velocity: str = "[0.5, 0, 0]", settings: str = "", controls: str = "{}", fan: str = "",
    floor: str = "floor: {shape: {kind: plane}}",
):  # fmt: skip
    return load_text(CASE.format(**locals()))


@pytest.mark.parametrize(
    ("given", "said", "line"),
    [
        ({"shape": "{kind: plane}"}, "only the surface of a `box` can move, and this is a `plane`", 6),
        (
            {"shape": "{kind: cylinder, radius: 0.1, height: 1}"},
            "a `cylinder`; a roller is a `driven` body with the motion `spin`",
            6,
        ),
        ({"velocity": "[0.5, 0.1, 0.1]"}, "moves along the faces of its box: at least one component is 0", 6),
        ({"settings": "solver: {hibernation: true}"}, "no surface can move here: with `hibernation`", 6),
        ({"settings": "contact: {model: sap}"}, "contact model sap has no moving surfaces", 6),
        (
            {
                "fan": "jelly: {kind: soft, solver: fem, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [3, 0, 1]}}"
            },
            "contact model sap has no moving surfaces",
            6,
        ),
        (
            {"controls": "{glue: {kind: attach, body: parcel, to: belt, at: 0}}"},
            "the surface of `belt` moves, so nothing can be fastened to it; name another static",
            12,
        ),
        (
            {"controls": '{glue: {kind: bond, of: ["parcel", belt], strength: 1.0e5}}'},
            "the surface of `belt` moves",
            12,
        ),
        (
            {"controls": "{glue: {kind: attach, body: parcel, to: world, at: 0}}", "floor": ""},
            "a weld to the world needs a static whose surface does not move",
            12,
        ),
    ],
)
def test_what_cannot_move_is_named_where_it_is(given, said, line):
    with pytest.raises(SpecError) as error:
        resolve_case(case(**given))
    (problem,) = [problem for problem in error.value.problems if said in problem.message]
    assert problem.line == line


def test_a_belt_becomes_a_slider_that_passes_through_what_stands_still():
    resolution = resolve_case(case())
    (joint,) = [joint for _, joint in resolution.lowering.trees["belt"].joints()]
    assert joint.kind == "slider"
    assert joint.axis == pytest.approx((1, 0, 0))  # in the frame of the box, which is turned
    assert resolution.settings.cone == "elliptic"
    files = emit(resolution.plan)
    assert '"belt": (0.5, 0.0, 0.0)' in files["actions.py"].decode()
    assert "driven = BELTS.keys()" in files["actions.py"].decode()
    assert "belts.py" in files


def test_belts_and_driven_bodies_share_a_program():
    source = emit(resolve_case(case(fan=FAN)).plan)["actions.py"].decode()
    assert "driven = {name for name, *_ in MOTIONS} | BELTS.keys()" in source
    assert source.index("Motions(scene") < source.index("Belts(scene")


def test_a_surface_at_rest_is_a_plain_static():
    plan = resolve_case(case(velocity="[0, 0, 0]")).plan
    assert plan.belts == ()
    assert next(entity for entity in plan.entities if entity.name == "belt").morph == "Box"


def test_a_weld_to_the_world_takes_a_static_that_stands_still():
    plan = resolve_case(case(controls="{glue: {kind: attach, body: parcel, to: world, at: 0}}")).plan
    assert plan.welds[0].b == "floor"


def test_the_lint_expects_what_lies_on_it_to_be_carried():
    facts = Facts(resolve_case(case()))
    assert facts.once(Causes).first == "belt"
    low, high = facts.once(Whereabouts).box(facts.copies["parcel"])
    assert high[1] > 1.0  # 0.5 m/s along y, as the box is turned, for 2 s
    assert low[1] > -0.5
