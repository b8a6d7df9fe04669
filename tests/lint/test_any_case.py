"""The lint returns a report on any valid case, without an error of its own."""

import json
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from text2sim.compiler.build import resolve_case
from text2sim.lint import lint_case
from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.models.shapes import SolidShape
from text2sim.spec_schema.published.language_reference import load_examples, section_kinds

ROOT = Path(__file__).resolve().parents[2]
size = st.sampled_from([1e-4, 0.004, 0.03, 0.1, 0.4, 2.0, 300.0])
place = st.sampled_from([-3.0, -0.4, -0.05, 0.0, 0.0, 0.02, 0.3, 1.0, 40.0])
vec = st.tuples(place, place, place).map(list)
angle = st.sampled_from([0, 0, 30, 90, 123.4])
turn = st.tuples(angle, angle, angle).map(list)
speed = st.sampled_from([0, 0, 0.5, -3, 20, 500])
velocity = st.tuples(speed, speed, speed).map(list)

EXAMPLES = [yaml.safe_load(load_examples()["shapes"][kind])["shape"] for kind in section_kinds(SolidShape)]
shape = st.one_of(
    st.builds(lambda a, b, c: {"kind": "box", "size": [a, b, c]}, size, size, size),
    st.builds(lambda r: {"kind": "sphere", "radius": r}, size),
    st.builds(lambda r, h: {"kind": "cylinder", "radius": r, "height": h}, size, size),
    st.builds(lambda r, h: {"kind": "capsule", "radius": r, "length": h}, size, size),
    st.builds(lambda r, h: {"kind": "cone", "radius": r, "height": h}, size, size),
    st.builds(lambda r, h, top: {"kind": "cone", "radius": r, "height": h, "top_radius": top}, size, size, size),
    st.builds(lambda a, b, c: {"kind": "ellipsoid", "radii": [a, b, c]}, size, size, size),
    st.builds(lambda r: {"kind": "torus", "radius": r, "bar_radius": r / 4, "segments": 8}, size),
    st.builds(lambda r, h: {"kind": "cup", "radius": r, "height": r + h, "thickness": r / 8}, size, size),
    st.sampled_from([one for one in EXAMPLES if "file" not in one]),
)
mount = st.sampled_from(
    [None, None, None, {"kind": "fixed"}, {"kind": "hinge", "axis": "y"}, {"kind": "slider"}, {"kind": "ball"}]
)
motion = st.sampled_from(
    [
        {"kind": "spin", "speed": 30},
        {"kind": "oscillate", "amplitude": 0.5, "frequency": 3},
        {"kind": "waypoints", "times": [0, 0.2], "positions": [[0, 0, 0], [1, 0, 0]]},
    ]
)
repeat = st.sampled_from([None, None, {"kind": "line", "count": 3, "step": [0.1, 0, 0]}])


@st.composite
def body(draw: st.DrawFn) -> dict[str, Any]:
    pose = {"pos": draw(vec), "euler_deg": draw(turn)}
    kind = draw(st.sampled_from(["rigid", "rigid", "rigid", "driven", "ragdoll", "chain", "beam"]))
    found: dict[str, Any] = {"kind": kind, "pose": pose}
    if kind == "rigid":
        found |= {"shape": draw(shape), "mount": draw(mount), "repeat": draw(repeat)}
        found["material"] = draw(st.sampled_from([{}, {"density": 1e9}, {"mass": 1e-8}, {"restitution": 0.8}]))
    elif kind == "driven":
        found |= {"shape": draw(shape), "motion": draw(motion)}
    elif kind == "ragdoll":
        found["height"] = draw(size) + 0.1
    elif kind == "beam":
        found |= {"size": [draw(size) + 0.1, 0.05, 0.02], "youngs_modulus": draw(st.sampled_from([1e-3, 1e7, 1e12]))}
        found |= {
            "anchored": draw(st.booleans()),
            "damping_ratio": draw(st.sampled_from([0, 0.02, 1])),
            "repeat": draw(repeat),
        }
    else:
        found |= {"links": 4, "link_length": 0.1, "radius": 0.01}
    return {key: value for key, value in found.items() if value is not None}


camera = st.one_of(
    st.builds(lambda a: {"kind": "still", "from": a, "look_at": "b0"}, vec),
    st.builds(lambda a, b: {"kind": "dolly", "from": a, "to": b, "look_at": "b0"}, vec, vec),
    st.builds(lambda r, h: {"kind": "orbit", "look_at": "b0", "radius": r, "height": h}, size, place),
    st.just({"kind": "follow", "body": "b0", "offset": [0, -2, 1]}),
    st.builds(lambda a: {"kind": "mounted", "on": "b0", "euler_deg": a}, vec),
)


@st.composite
def case(draw: st.DrawFn) -> dict[str, Any]:
    bodies = {f"b{k}": one for k, one in enumerate(draw(st.lists(body(), min_size=1, max_size=4)))}
    statics = draw(
        st.sampled_from(
            [
                {},
                {"floor": {"shape": {"kind": "plane"}}},
                {"floor": {"shape": {"kind": "plane", "size": 0.5}, "pose": {"euler_deg": [0, 30, 0]}}},
                {"slab": {"shape": {"kind": "box", "size": [2, 2, 0.01]}}},
            ]
        )
    )
    scene = {
        "duration": draw(st.sampled_from([0.1, 2.0, 20.0])),
        "gravity": draw(st.sampled_from([[0, 0, -9.81], [0, 0, 0], [3, 0, 0], [0, 1, 9]])),
        "statics": statics,
        "domain": {"min": [-1, -1, -1], "max": [1, 1, 1]},
    }
    measures = {"m": {"kind": "position", "of": "b0", "axis": "z", "stat": "max"}}
    actions: dict[str, Any] = {"measures": measures, "expect": {"e": {"measure": "m", "at": "end", "above": 0}}}
    thrown = [
        name
        for name, one in bodies.items()
        if one["kind"] == "ragdoll" or (one["kind"] == "rigid" and "mount" not in one)
    ]
    if thrown:
        actions["controls"] = {"go": {"kind": "initial_velocity", "body": thrown[0], "linear": draw(velocity)}}
    return {
        "text2sim": 1,
        "name": "any",
        "scene": scene,
        "bodies": bodies,
        "actions": actions,
        "render": {"cameras": {"main": draw(camera)}},
    }


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(case())
def test_any_case(data: dict[str, Any]) -> None:
    try:
        resolution = resolve_case(load_text(json.dumps(data)))
    except SpecError:
        return
    for problem in lint_case(resolution).problems:
        assert problem.message == problem.message.strip()
        assert "nan" not in problem.message
        assert problem.severity in ("error", "warning")


STAGE = """\
text2sim: 2
name: a
scene: {duration: 1, statics: {floor: {shape: {kind: plane}}}}
bodies:
  drum: {kind: rigid, shape: {kind: cylinder, radius: 0.3, height: 0.4}, mount: {kind: hinge}, pose: {pos: [0, 3, 1]}}
"""


@pytest.mark.parametrize("kind", sorted(load_examples()["bodies"]))
def test_every_kind_of_body(kind: str) -> None:
    example = load_examples()["bodies"][kind]
    text = STAGE + "".join(f"  {line}\n" for line in example.splitlines())
    lint_case(resolve_case(load_text(text)))
