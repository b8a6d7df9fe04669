"""Bodies that overlap at the start: the depth, the translation that frees them, and its severity."""

import re
from pathlib import Path

import pytest
from lint_support import findings, report_on

from text2sim.compiler.build import resolve_case
from text2sim.lint.facts import Facts
from text2sim.lint.start.overlap import push_speed
from text2sim.spec_schema.errors import Problem
from text2sim.spec_schema.load import load_text

BOX = "{{kind: rigid, shape: {{kind: box, size: [1, 1, 1]}}, pose: {{pos: {pos}}}{more}}}"
SLAB = "scene: {statics: {slab: {shape: {kind: box, size: [2, 2, 0.2]}, pose: {pos: [0, 0, 0.5]}}}}\n"


def overlaps(folder: Path, *parts: str) -> list[Problem]:
    return findings(folder, "overlap", *parts)


def boxes(**places: str) -> str:
    rows = [f"  {name}: {BOX.format(pos=pos, more='')}\n" for name, pos in places.items()]
    return "bodies:\n" + "".join(rows)


def depth_and_way(problem: Problem) -> tuple[str, str]:
    found = re.search(r"overlap by (.*?) at the start.*; (.*?)(?: \(`|$)", problem.message)
    assert found, problem.message
    return found[1], found[2]


def test_boxes_that_touch_do_not_overlap(tmp_path: Path) -> None:
    assert overlaps(tmp_path, boxes(a="[0, 0, 0.5]", b="[1, 0, 0.5]", c="[0, 0, 1.5]")) == []


@pytest.mark.parametrize("gap", [0.0005, 0.0, -0.0004])
def test_what_the_engine_hardly_feels_is_not_reported(tmp_path: Path, gap: float) -> None:
    assert overlaps(tmp_path, boxes(a="[0, 0, 0.5]", b=f"[{1 + gap}, 0, 0.5]")) == []


def test_depth_and_way_out(tmp_path: Path) -> None:
    (found,) = overlaps(tmp_path, boxes(a="[0, 0, 0.5]", b="[0.9, 0, 0.5]"))
    assert depth_and_way(found) == ("100 mm", "100 mm towards -x frees `a`")
    assert (found.path, found.severity) == ("/bodies/a/pose", "warning")


@pytest.mark.parametrize(
    ("floor", "way"), [("{shape: {kind: plane}}", "430 mm towards +z"), ("null", "70 mm towards -z")]
)
def test_the_way_out_does_not_lead_into_the_ground(tmp_path: Path, floor: str, way: str) -> None:
    slab = "slab: {shape: {kind: box, size: [2, 2, 0.3]}, pose: {pos: [0, 0, 0.3]}}"
    ball = "ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 0.12]}}"
    (found,) = overlaps(tmp_path, f"scene: {{statics: {{floor: {floor}, {slab}}}}}\nbodies: {{{ball}}}")
    assert depth_and_way(found) == ("70 mm", f"{way} frees `ball`")


def test_the_way_along_an_axis_is_preferred(tmp_path: Path) -> None:
    slope = "slope: {kind: rigid, shape: {kind: box, size: [2, 2, 0.2]}, mount: {kind: fixed}, pose: {pos: [0, 0, 1], euler_deg: [0, 20, 0]}}"
    cube = "cube: {kind: rigid, shape: {kind: box, size: [0.2, 0.2, 0.2]}, pose: {pos: [0.0513, 0, 1.141], euler_deg: [0, 20, 0]}}"
    (found,) = overlaps(tmp_path, f"bodies: {{{slope}, {cube}}}")
    depth, way = depth_and_way(found)
    # It stands (0.1 + 0.1) - 0.15 m deep, measured along the slope's normal; straight up is longer by 1 / cos 20 deg.
    assert float(depth.split()[0]) == pytest.approx(50, abs=0.2)
    assert way.endswith("towards +z frees `cube`")
    assert float(way.split()[0]) == pytest.approx(50 / 0.9397, abs=0.4)


def test_many_copies_make_one_finding(tmp_path: Path) -> None:
    text = (
        f"bodies:\n  a: {BOX.format(pos='[0, 0, 0.5]', more=', repeat: {kind: line, count: 4, step: [0.8, 0, 0]}')}\n"
    )
    (found,) = overlaps(tmp_path, text)
    assert found.message.startswith(
        "`a[0]` and `a[1]` overlap by 200 mm at the start (and 2 more pairs of their copies)"
    )
    assert found.message.endswith("200 mm more between them along x frees them")
    assert found.path == "/bodies/a/repeat"


def test_half_the_thickness_is_an_error(tmp_path: Path) -> None:
    (found,) = overlaps(tmp_path, boxes(a="[0, 0, 0.5]", b="[0.45, 0, 0.5]"))
    assert found.severity == "error"
    assert "where one is 1 m thick" in found.message
    assert not report_on(tmp_path, boxes(a="[0, 0, 0.5]", b="[0.45, 0, 0.5]")).ok


def test_what_is_held_is_never_an_error(tmp_path: Path) -> None:
    door = "door: {kind: rigid, shape: {kind: box, size: [0.1, 0.02, 0.2]}, pose: {pos: [0, 0, 0.5]}, mount: {kind: hinge}}"
    (found,) = overlaps(tmp_path, SLAB, f"bodies: {{{door}}}")
    assert found.severity == "warning"
    assert "for the whole run" in found.message


def test_what_the_world_holds_may_stand_in_what_never_moves(tmp_path: Path) -> None:
    fixed = "bodies: {a: {kind: rigid, shape: {kind: box, size: [1, 1, 1]}, pose: {pos: [0, 0, 0.5]}, mount: {kind: fixed}}}"
    assert overlaps(tmp_path, SLAB, fixed) == []


def test_attached_bodies_do_not_touch_in_the_engine(tmp_path: Path) -> None:
    both = boxes(a="[0, 0, 0.5]", b="[0.9, 0, 0.5]")
    hold = "actions: {controls: {hold: {kind: attach, body: a, to: b, at: %s}}}"
    assert overlaps(tmp_path, both, hold % 0) == []
    assert len(overlaps(tmp_path, both, hold % 0.5)) == 1, "until then they push each other"


def test_a_ball_in_a_cup_is_not_in_its_wall(tmp_path: Path) -> None:
    cup = "  cup: {kind: rigid, shape: {kind: cup, radius: 0.5, height: 1.0, thickness: 0.1}, place: {on: floor}}\n"
    ball = "  ball: {kind: rigid, shape: {kind: sphere, radius: 0.3}, %s}\n"
    assert overlaps(tmp_path, "bodies:\n" + cup + ball % "place: {inside: cup}") == []
    (found,) = overlaps(tmp_path, "bodies:\n" + cup + ball % "pose: {pos: [0.13, 0, 0.5]}")
    depth, _ = depth_and_way(found)
    assert float(depth.split()[0]) == pytest.approx(30, abs=1), "0.13 + 0.3 - 0.4 m deep in a stave"


def test_links_of_different_bodies_are_named(tmp_path: Path) -> None:
    doll = "bodies: {doll: {kind: ragdoll, height: 1.7, pose: {pos: [0, 0, 1.4]}}}"
    found = overlaps(tmp_path, SLAB, doll)
    assert re.match(r"`doll\.\w+` and `slab` overlap", found[0].message)


class TestMeshes:
    RING = "ring: {kind: rigid, shape: {kind: mesh, file: ring.obj%s}, pose: {pos: [0, 0, 0.5]}}"
    BALL = "ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [%s, 0, 0.5]}}"

    def bodies(self, more: str, x: float) -> str:
        return f"bodies: {{{self.RING % more}, {self.BALL % x}}}"

    def test_a_hull_has_no_hole(self, assets: Path) -> None:
        (found,) = overlaps(assets, self.bodies("", 0))
        assert found.severity == "error"
        assert found.message.endswith(
            "(`ring.obj` collides by its convex hull; `collision: decompose` or `exact` keeps its hollows)"
        )

    @pytest.mark.parametrize("collision", ["decompose", "exact"])
    def test_what_is_taken_apart_keeps_its_hole(self, assets: Path, collision: str) -> None:
        assert overlaps(assets, self.bodies(f", collision: {collision}", 0)) == []

    def test_rings_go_through_each_other(self, assets: Path) -> None:
        """The centre of each is in the bar of the other, but in the hole of its own ring."""
        ring = "{kind: rigid, shape: {kind: mesh, file: ring.obj, collision: decompose}, pose: {pos: [%s, 0, 0.5], euler_deg: [%s, 0, 0]}}"
        assert overlaps(assets, f"bodies: {{a: {ring % (0, 0)}, b: {ring % (0.2, 90)}}}") == []

    @pytest.mark.parametrize("collision", ["decompose", "exact"])
    def test_its_surface_counts(self, assets: Path, collision: str) -> None:
        (found,) = overlaps(assets, self.bodies(f", collision: {collision}", 0.15))
        assert found.severity == "warning", "only the engine knows the pieces"

    def test_what_is_wholly_inside_counts(self, assets: Path) -> None:
        ball = self.bodies(", collision: decompose", 0.2).replace("radius: 0.1", "radius: 0.03")
        (found,) = overlaps(assets, ball)
        assert depth_and_way(found)[0] == "70 mm", "30 mm and 40 mm, the bar's radius"

    @pytest.mark.parametrize("collision", ["decompose", "exact", "parts"])
    def test_a_sculpted_bowl_keeps_its_hollow(self, tmp_path: Path, collision: str) -> None:
        """Its surface is known without a file; convex pieces of its parts fill it, which is then said."""
        bowl = (
            f"bowl: {{kind: rigid, shape: {{kind: sculpt, collision: {collision}, parts: {{bowl: {{kind: revolve, "
            "profile: [[0, 0], [0.1, 0], [0.2, 0.15], [0.16, 0.15], [0.08, 0.03], [0, 0.03]]}}}, pose: {pos: [0, 0, 0.5]}}"
        )
        ball = "ball: {kind: rigid, shape: {kind: sphere, radius: 0.06}, pose: {pos: [0, 0, %s]}}"
        above, in_it = (overlaps(tmp_path, f"bodies: {{{bowl}, {ball % z}}}") for z in (0.6, 0.5))
        reason = "(the convex pieces of `bowl` fill its hollow: `collision: exact`, or `decompose`, keeps it)"
        assert [found.message.endswith(reason) for found in above] == ([True] if collision == "parts" else [])
        (found,) = in_it
        assert "`bowl` and `ball` overlap" in found.message
        assert reason not in found.message, "the middle of the ball is in the bottom of the bowl"


def test_speed_grows_with_depth_over_the_timeconst() -> None:
    def speed(timeconst: float) -> float:
        text = (
            f"text2sim: 1\nname: a\nscene: {{duration: 1, substeps: 10, contact: {{timeconst: {timeconst}}}}}\n"
            "bodies: {b: {kind: rigid, shape: {kind: sphere, radius: 1}}}\n"
        )
        return push_speed(Facts(resolve_case(load_text(text))), 0.01)

    # Measured in the engine: 10 mm deep, at 10 ms and at 5 ms.
    assert speed(0.01) == pytest.approx(0.519, rel=0.05)
    assert speed(0.005) == pytest.approx(1.039, rel=0.05)


def test_a_heap_of_overlaps_is_looked_at_in_bounds(tmp_path: Path) -> None:
    heap = "kind: rigid, shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {euler_deg: [10, 20, 30]}"
    grid = "repeat: {kind: grid, counts: [10, 20, 10], spacing: [0.05, 0.05, 0.05]}"
    (found,) = overlaps(tmp_path, "scene: {statics: {floor: null}}", f"bodies: {{b: {{{heap}, {grid}}}}}")
    assert "pairs of their copies at least" in found.message
