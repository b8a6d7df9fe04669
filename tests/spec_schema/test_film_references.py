"""What a film names exists, at times that there are; words that contradict each other are refused."""

import pytest
from small_case import problems_of, small
from staged import staged

from text2sim.compiler.build import resolve_case
from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.load import load_text


def found(render):
    """Path, rule and hint of each problem of a render section."""
    text = small(top=f"render: {render}")
    problems = problems_of(text)
    if not problems:
        try:
            problems = list(resolve_case(load_text(text)).plan.warnings)
        except SpecError as error:
            problems = error.problems
    return [(p.path.removeprefix("/render/"), p.rule, p.hint) for p in problems]


@pytest.mark.parametrize(
    ("render", "path", "rule", "hint"),
    [
        ("{cameras: {a: {kind: still, frame: [bal]}}}", "cameras/a/frame/0", "unknown-body", "ball"),
        ("{cameras: {a: {kind: orbit, frame: [ball, 'ball[3]']}}}", "cameras/a/frame/1", "no-copies", "ball"),
        ("{cameras: {a: {kind: still, from: [0, -3, 1], look_at: ball, f_stop: 2, focus: bll}}}", "cameras/a/focus", "unknown-body", "ball"),
        ("{cameras: {a: {kind: keyframed, times: [0, 1], positions: [[0, 0, 1], [1, 0, 1]], look_at: bll}}}", "cameras/a/look_at", "unknown-body", "ball"),
        ("{cameras: {a: {kind: mounted, on: bll, look_at: [1, 0, 0]}}}", "cameras/a/on", "unknown-body", "ball"),
        ("{cameras: {a: {kind: mounted, on: ball.hand, look_at: [1, 0, 0]}}}", "cameras/a/on", "unknown-link", "ball"),
        ("{lights: {a: {kind: softbox, direction: [0, 0, -1], at: bll}}}", "lights/a/at", "unknown-body", "ball"),
        ("{lights: {a: {kind: spot, pos: [0, 0, 3], look_at: bll}}}", "lights/a/look_at", "unknown-body", "ball"),
        ("{shots: {a: {camera: mian}}}", "shots/a/camera", "unknown-camera", "main"),
        ("{shots: {a: {camera: main, from: 500}}}", "shots/a/from", "after-end", None),
        ("{shots: {a: {camera: main, to: 500}}}", "shots/a/to", "after-end", None),
        ("{during: [0, 0.1], shots: {a: {camera: main, from: 0.2}}}", "shots/a/from", "empty-shot", None),
        ("{overlay: {values: [height]}}", "overlay/values/0", "unknown-measure", None),
    ],
)  # fmt: skip
def test_names_and_times(render, path, rule, hint):
    assert found(render) == [(path, rule, hint)]


FRAMED = """
text2sim: 2
name: framed
scene: {duration: 1}
bodies:
  chain: {kind: chain, links: 4, link_length: 0.1, radius: 0.01, pose: {pos: [0, 0, 2]}}
  cart:
    kind: rigid
    shape:
      kind: compound
      parts:
        bed: {shape: {kind: box, size: [0.4, 0.2, 0.1]}}
        flag: {shape: {kind: box, size: [0.1, 0.01, 0.1]}, pose: {pos: [0, 0, 0.3]}, decor: true}
    repeat: {kind: grid, counts: [2, 1, 1], spacing: [1, 1, 1]}
render: {cameras: {a: {kind: still, frame: [NAME]}}}
"""


@pytest.mark.parametrize("name", ["chain.link_*", "cart.bed", "cart[0].b*", "cart[*]", "chain.link_2"])
def test_a_frame_takes_what_measures_take(name):
    render = resolve_case(load_text(FRAMED.replace("NAME", f"'{name}'"))).plan.render
    assert render["cameras"]["a"]["frame"]["bodies"] == [name.replace("[*]", "")]


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("chain.knot_*", "`chain` has no link `knot_*`"),
        ("cart.bad", "`cart` has no part `bad`"),
        ("cart.flag", "part `flag` of `cart` is only drawn (decor: true)"),
        ("cart[7].bed", "`cart` has 2 copies"),
    ],
)
def test_a_frame_that_names_nothing(name, said):
    with pytest.raises(SpecError) as error:
        resolve_case(load_text(FRAMED.replace("NAME", f"'{name}'")))
    (problem,) = error.value.problems
    assert problem.path == "/render/cameras/a/frame/0"
    assert said in problem.message


@pytest.mark.parametrize(
    ("render", "path", "said"),
    [
        ("{cameras: {a: {kind: still, look_at: ball}}}", "cameras/a", "give from and look_at, or frame"),
        ("{cameras: {a: {kind: still, frame: [ball], look_at: ball}}}", "cameras/a", "either look_at or frame"),
        ("{cameras: {a: {kind: still, frame: [ball], from: [0, 0, 1], lens_mm: 50}}}", "cameras/a", "the lens is derived"),
        ("{cameras: {a: {kind: still, from: [0, 0, 1], look_at: ball, margin: 0.1}}}", "cameras/a", "need frame"),
        ("{cameras: {a: {kind: still, frame: [ball], fov_deg: 30, lens_mm: 50}}}", "cameras/a", "either fov_deg or lens_mm"),
        ("{cameras: {a: {kind: still, frame: [ball], focus: ball}}}", "cameras/a", "focus needs an f_stop"),
        ("{cameras: {a: {kind: mounted, on: ball}}}", "cameras/a", "either look_at or euler_deg"),
        ("{cameras: {a: {kind: mounted, on: ball, look_at: [1, 0, 0], euler_deg: [0, 90, 0]}}}", "cameras/a", "either look_at or euler_deg"),
        ("{cameras: {a: {kind: mounted, on: ball, euler_deg: [0, 90, 0], up: [0, 1, 0]}}}", "cameras/a", "up needs look_at"),
        ("{cameras: {a: {kind: mounted, on: ball, look_at: [0, 0, 0]}}}", "cameras/a", "pos and look_at are the same point"),
        ("{cameras: {a: {kind: mounted, on: ball, look_at: ball}}}", "cameras/a/look_at", "3 numbers"),
        ("{cameras: {a: {kind: orbit, look_at: ball}}}", "cameras/a", "give radius and height"),
        ("{cameras: {a: {kind: orbit, frame: [ball], radius: 2}}}", "cameras/a", "both radius and height"),
        ("{cameras: {a: {kind: keyframed, times: [0, 1], positions: [[0, 0, 1]], look_at: ball}}}", "cameras/a/positions", "2"),
        ("{cameras: {a: {kind: keyframed, times: [1, 1], positions: [[0, 0, 1], [1, 0, 1]], look_at: ball}}}", "cameras/a", "times must be ascending"),
        ("{shots: {a: {camera: main, from: 1, to: 0.5}}}", "shots/a", "to must come after from"),
        ("{shots: {a: {camera: main, speed: 0}}}", "shots/a/speed", "0.01 to 100"),
        ("{shots: {a: {camera: main, hold: 1.0e+9}}}", "shots/a/hold", "0 to 60"),
        ("{lights: {a: {kind: sun, strength: 1.0e+9}}}", "lights/a/strength", "from 0 to 1000000"),
        ("{motion_blur: 1.5}", "motion_blur", "from 0 to 1"),
        ("{overlay: {title: ''}}", "overlay/title", ""),
    ],
)  # fmt: skip
def test_words_that_do_not_fit(render, path, said):
    (problem,) = problems_of(small(top=f"render: {render}"))
    assert problem.path == f"/render/{path}"
    assert said in problem.message


@pytest.mark.parametrize(
    ("on", "said", "hint"),
    [
        ("brick", "`brick` selects 12 copies: a camera is mounted on one body", "brick[0]"),
        ("brick[2:4]", "`brick[2:4]` selects 2 copies", "brick[0]"),
        ("curtain", "`curtain` deforms", None),
        ("arm.hnd", "`arm` has no link `hnd`; there are base, elbow, hand", "hand"),
        ("arm.*", "only one link is allowed here", None),
    ],
)
def test_a_camera_is_mounted_on_one_rigid_body(on, said, hint):
    camera = {"kind": "mounted", "on": on, "look_at": [0, 0, 1]}
    with pytest.raises(SpecError) as caught:
        resolve_case(staged({"/render/cameras/main": camera}))
    (problem,) = caught.value.problems
    assert (problem.path, problem.hint) == ("/render/cameras/main/on", hint)
    assert said in problem.message


def test_a_film_of_many_shots_may_be_too_long():
    shots = ", ".join(f"s{k}: {{camera: main, hold: 60}}" for k in range(100))
    text = small(top=f"render: {{fps: 60, shots: {{{shots}}}}}")
    with pytest.raises(SpecError, match="frames of film"):
        resolve_case(load_text(text))
