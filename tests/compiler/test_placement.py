import math
import re
import subprocess
import sys
import time

import pytest

from text2sim.compiler.placing.placement import place_all
from text2sim.compiler.shapes.geometry import pieces
from text2sim.compiler.shapes.gjk import distance
from text2sim.compiler.shapes.rotation import quat_rotate
from text2sim.compiler.shapes.solid import solids
from text2sim.spec_schema.load import load_text

HEAD = """\
text2sim: 1
name: test
scene:
  duration: 1
  statics:
    floor: {shape: {kind: plane}}
    table: {shape: {kind: box, size: [2, 1, 0.1]}, pose: {pos: [5, 0, 0.7]}}
    ramp: {shape: {kind: box, size: [2, 2, 0.2]}, pose: {pos: [0, 8, 1], euler_deg: [0, 30, 0]}}
    slope: {shape: {kind: plane}, pose: {pos: [0, 0, 1], euler_deg: [0, 30, 0]}}
    cup: {shape: {kind: cup, radius: 0.3, height: 0.4, thickness: 0.03}, pose: {pos: [-3, 0, 0.2]}}
    drum:
      shape: {kind: tube, outer_radius: 0.5, inner_radius: 0.4, height: 1}
      pose: {pos: [0, -5, 1], euler_deg: [90, 0, 0]}
bodies:
"""
BALL = "kind: rigid, shape: {kind: sphere, radius: 0.1}"
BRICK = "kind: rigid, shape: {kind: box, size: [0.24, 0.11, 0.07]}"
TILE = BRICK.replace("0.24, 0.11", "0.5, 0.5")
FIRST_LINE = HEAD.count("\n") + 1
# A drum's lowest stave is inclined by half its width: the ball touches beside its lowest point.
LEAN = 1 / math.cos(math.pi / 24) - 1


def line(name, base, repeat, **fields):
    """A repeated body, in one line of YAML."""
    return f"{name}: {{{base}, repeat: {{{repeat}}}" + "".join(f", {k}: {{{v}}}" for k, v in fields.items()) + "}"


def place(bodies, tree_extents=None, problems=0):
    copies, found = place_all(load_text(HEAD + "\n".join(f"  {body}" for body in bodies)), tree_extents)
    assert len(found) == problems, found
    return (copies, found) if problems else copies


def pos_of(copies, name):
    (copy,) = copies[name]
    return copy.pos


def gap(copies, one, other):
    a, b = (copies[name][0] for name in (one, other))
    return min(
        distance(p, q)
        for p in solids(pieces(a.shape, None), a.pos, a.quat)
        for q in solids(pieces(b.shape, None), b.pos, b.quat)
    )


class TestRelations:
    @pytest.mark.parametrize(
        ("relation", "expected"),
        [
            ("on: floor, at: [1, 2]", (1, 2, 0.1)),
            ("on: floor, at: [1, 2], clearance: 0.05", (1, 2, 0.15)),
            ("on: table", (5, 0, 0.85)),
            ("on: table, at: [5.2, 0.3]", (5.2, 0.3, 0.85)),
            # Half over the table's edge: the ball touches the edge, deeper than its top.
            ("on: table, at: [6.06, 0]", (6.06, 0, 0.75 + 0.08)),
            ("on: slope, at: [0, 0]", (0, 0, 1 + 0.1 / math.cos(math.pi / 6))),
            ("on: ramp, at: [0, 8]", (0, 8, 1 + 0.2 / math.cos(math.pi / 6))),
            ("above: table, clearance: 0.3", (5, 0, 1.15)),
            ("below: table, clearance: 0.1", (5, 0, 0.45)),
            ("left_of: table, clearance: 0.2", (3.7, 0, 0.75)),
            ("right_of: table", (6.1, 0, 0.75)),
            ("in_front_of: table", (5, -0.6, 0.75)),
            ("behind: table", (5, 0.6, 0.75)),
            ("inside: cup", (-3, 0, 0.13)),
            ("inside: cup, clearance: 0.02", (-3, 0, 0.15)),
            # More room than the cup has beside the ball.
            ("inside: cup, clearance: 0.2", (-3, 0, 0.33)),
            # A drum on its side: the ball lies on the lowest stave, whose middle is not straight below.
            ("inside: drum, at: [0, -5]", (0, -5, 0.7 - 0.4 * LEAN + 0.1 * LEAN)),
            ("touching: table, direction: x", (6.1, 0, 0.7)),
            ("touching: slope, direction: z", (0, 0, 1 + 0.1 / math.cos(math.pi / 6))),
        ],
    )  # fmt: skip
    def test_a_ball_goes_where_the_word_says(self, relation, expected):
        copies = place([f"ball: {{{BALL}, place: {{{relation}}}}}"])
        assert pos_of(copies, "ball") == pytest.approx(expected, abs=1e-6)

    def test_flat_on_flat_is_exact(self):
        copies = place([
            f"brick: {{{BRICK}, place: {{on: table}}}}",
            f"other: {{{BRICK}, place: {{on: brick, at: [5.2, 0]}}}}",
        ])  # fmt: skip
        assert pos_of(copies, "brick")[2] == pytest.approx(0.785, abs=1e-15)
        assert pos_of(copies, "other")[2] == pytest.approx(0.855, abs=1e-15)

    def test_a_tower_of_round_things_stands_in_contact(self):
        log = "kind: rigid, shape: {kind: cylinder, radius: 0.1, height: 1}"
        egg = "kind: rigid, shape: {kind: ellipsoid, radii: [0.05, 0.06, 0.07]}"
        copies = place([
            f"log: {{{log}, place: {{on: floor, euler_deg: [0, 90, 0]}}}}",
            f"plank: {{{BRICK}, place: {{on: log, euler_deg: [20, 0, 0]}}}}",
            f"egg: {{{egg}, place: {{on: plank, euler_deg: [30, 40, 0]}}}}",
            f"marble: {{{BALL}, place: {{touching: egg, direction: [1, 1, 1], clearance: 0.01}}}}",
        ])  # fmt: skip
        assert pos_of(copies, "log")[2] == pytest.approx(0.1)
        assert 0 <= gap(copies, "log", "plank") < 1e-6
        assert 0 <= gap(copies, "plank", "egg") < 1e-6
        assert gap(copies, "egg", "marble") == pytest.approx(0.01, abs=1e-6)

    def test_on_a_cup_means_its_rim_for_what_is_wider(self):
        copies = place([f"lid: {{{BRICK.replace('0.24, 0.11', '0.7, 0.7')}, place: {{on: cup}}}}"])
        assert pos_of(copies, "lid") == pytest.approx((-3, 0, 0.435))

    def test_copies_are_targets_one_by_one_and_together(self):
        copies = place([
            f"post: {{{BRICK}, repeat: {{kind: line, count: 3, step: [1, 0, 0.1]}}}}",
            f"one: {{{BALL}, place: {{on: 'post[1]'}}}}",
            f"all: {{{BALL}, place: {{above: post}}}}",
            f"some: {{{BALL}, place: {{right_of: 'post[0:2]'}}}}",
        ])  # fmt: skip
        assert pos_of(copies, "one") == pytest.approx((1, 0, 0.1 + 0.035 + 0.1))
        assert pos_of(copies, "all") == pytest.approx((1, 0, 0.2 + 0.035 + 0.1))
        assert pos_of(copies, "some") == pytest.approx((1.12 + 0.1, 0, -0.035 + 0.1))

    def test_trees_of_links_are_measured_by_the_caller(self):
        bodies = [
            "doll: {kind: ragdoll, height: 1.7, place: {on: floor}}",
            f"hat: {{{BALL}, place: {{on: doll}}}}",
        ]
        copies = place(bodies, lambda body, quat, folder: ((-0.2, -0.3, -0.9), (0.2, 0.3, 0.8)))
        assert pos_of(copies, "doll") == pytest.approx((0, 0, 0.9))
        assert pos_of(copies, "hat") == pytest.approx((0, 0, 1.8))
        # Of the hat nothing is said: what it is on has no place.
        _, (problem,) = place(bodies, problems=1)
        assert "not known" in problem.message


class TestRepeats:
    def test_a_wall_stands_on_the_floor_about_its_place(self):
        copies = place(
            [
                line(
                    "brick",
                    BRICK,
                    "kind: running_bond, rows: 3, columns: 3, gap: 0.01",
                    place="on: floor, at: [1, 2]",
                )
            ]
        )
        wall = copies["brick"]
        assert wall[0].name == "brick[0]"
        assert wall[0].pos == pytest.approx((0.75, 2, 0.035))
        assert wall[3].shape.size == pytest.approx((0.115, 0.11, 0.07))
        assert wall[3].pos == pytest.approx((1 - 0.3125, 2, 0.105))
        assert wall[9].variables == {"i": 9, "n": 10, "u": 1.0, "row": 2, "column": 2, "layer": 0}
        assert wall[9].line == FIRST_LINE

    def test_a_turned_wall_runs_along_its_own_x(self):
        copies = place([line("brick", BRICK, "kind: running_bond, rows: 1, columns: 2", pose="euler_deg: [0, 0, 90]")])
        assert [c.pos for c in copies["brick"]] == [pytest.approx((0, -0.12, 0)), pytest.approx((0, 0.12, 0))]

    def test_a_line_is_placed_by_its_middle_and_started_by_its_first(self):
        placed = place([line("ball", BALL, "kind: line, count: 3, step: [1, 0, 0]", place="on: floor, at: [0, 4]")])
        assert [c.pos for c in placed["ball"]] == [pytest.approx((x, 4, 0.1)) for x in (-1, 0, 1)]
        started = place([f"ball: {{{BALL}, repeat: {{kind: line, count: 2, step: [1, 0, 0], start: [7, 8, 9]}}}}"])
        assert [c.pos for c in started["ball"]] == [(7, 8, 9), (8, 8, 9)]

    def test_a_stack_follows_the_true_height_of_leaning_copies(self):
        copies = place([
            "disc: {kind: rigid, shape: {kind: cylinder, radius: '${0.3 - 0.1 * i}', height: 0.1},"
            " repeat: {kind: stack, count: 3, gap: 0.02},"
            " place: {on: floor, at: [1, 1], euler_deg: [90, 0, 0]}}"
        ])  # fmt: skip
        assert [c.pos[2] for c in copies["disc"]] == pytest.approx([0.3, 0.6 + 0.02 + 0.2, 1.0 + 0.04 + 0.1])

    def test_ring_copies_turn_with_the_circle(self):
        copies = place([f"brick: {{{BRICK}, repeat: {{kind: ring, count: 4, radius: 1}}, pose: {{pos: [0, 0, 2]}}}}"])[
            "brick"
        ]
        assert copies[1].pos == pytest.approx((0, 1, 2))
        assert quat_rotate(copies[1].quat, (1, 0, 0)) == pytest.approx((0, 1, 0))

    def test_a_pose_that_varies_is_each_copys_own(self):
        copies = place([line("ball", BALL, "kind: line, count: 3, step: [1, 0, 0]", pose="pos: [0, 0, '${i * i}']")])
        assert [c.pos for c in copies["ball"]] == [(0, 0, 0), (1, 0, 1), (2, 0, 4)]

    def test_a_place_that_varies_puts_each_copy_by_itself(self):
        copies = place([
            f"post: {{{BRICK}, repeat: {{kind: line, count: 3, step: [1, 0, 0.1]}}}}",
            line("ball", BALL, "kind: line, count: 3, step: [0, 0, 0]", place="on: 'post[${i}]'"),
        ])  # fmt: skip
        assert [c.pos for c in copies["ball"]] == [pytest.approx((k, 0, 0.1 * k + 0.135)) for k in range(3)]

    def test_an_orientation_that_varies_leaves_the_place_to_the_pattern(self):
        copies = place([
            f"brick: {{{BRICK}, repeat: {{kind: line, count: 2, step: [1, 0, 0]}},"
            " place: {on: floor, at: [0, 0], euler_deg: [0, '${90 * i}', 0]}}"
        ])  # fmt: skip
        # The pattern is level, so each stands on the floor: one lies, the other is upright.
        assert [c.pos for c in copies["brick"]] == [
            pytest.approx((-0.5, 0, 0.035)),
            pytest.approx((0.5, 0, 0.12)),
        ]

    def test_copies_of_different_heights_each_stand_on_what_is_below(self):
        copies = place([
            "bench: {kind: rigid, shape: {kind: box, size: [0.2, 1, 0.1]}, place: {on: floor, at: [0.5, 0]}}",
            "post: {kind: rigid, shape: {kind: box, size: [0.02, 0.02, '${0.1 + 0.1 * i}']},"
            " repeat: {kind: line, count: 3, step: [0.5, 0, 0]}, place: {on: floor, at: [0.5, 0], offset: [0, 0, 0.01]}}",
            "peg: {kind: rigid, shape: {kind: box, size: [0.02, 0.02, '${0.1 + 0.1 * i}']},"
            " repeat: {kind: line, count: 2, step: [0, 0.1, 0.05]}, place: {on: bench}}",
        ])  # fmt: skip
        assert [c.pos[2] for c in copies["post"]] == [pytest.approx(0.06 + 0.05 * k) for k in range(3)]
        assert [c.pos[2] for c in copies["peg"]] == pytest.approx([0.15, 0.2]), "a pattern that rises stays as it is"

    def test_a_packing_lies_in_its_region(self):
        text = "repeat: {kind: packing, count: 20, region: {kind: box, min: [0, 0, 0], max: [1, 1, 1]}}"
        copies = place([f"ball: {{{BALL}, {text}}}"])["ball"]
        assert all(0.1 <= x <= 0.9 for c in copies for x in c.pos)
        _, problems = place([f"ball: {{{BALL}, {text.replace('20', '999')}}}"], problems=1)
        assert problems[0].path == "/bodies/ball/repeat"
        assert "cannot fit" in problems[0].message


class TestProblems:
    @pytest.mark.parametrize(
        ("fields", "path", "said"),
        [
            (f"{BALL}, place: {{on: flor}}", "/place/on", "no body or static `flor`"),
            (f"{BALL}, place: {{on: 'table[3]'}}", "/place/on", "none of the 1 copies"),
            (f"{BALL}, place: {{on: table, at: [9, 9]}}", "/place/at", "nowhere under it"),
            (f"{BALL}, place: {{inside: table}}", "/place/inside", "one solid piece"),
            (f"{TILE}, place: {{inside: cup}}", "/place/inside", r"takes 0.5 × 0.5 × [0-9.]+ m along x, y and z, `cup` 0.6 × 0.6 × 0.4 m"),
            (f"{BALL}, place: {{inside: cup, at: [-2, 0]}}", "/place/at", "does not fit"),
            (f"{BALL}, place: {{left_of: floor}}", "/place/left_of", "no sides"),
            (f"{BALL}, place: {{left_of: table, at: [0, 0]}}", "/place/at", "no effect"),
            (f"{BALL}, place: {{touching: floor, direction: [0, 0, -1]}}", "/place/direction", "this side"),
            (
                f"{BALL}, pose: {{pos: [1, 0, 0]}}, repeat: {{kind: line, count: 2, step: [1, 0, 0], start: [0, 0, 1]}}",
                "/pose/pos",
                "leave out `start` or `pos`",
            ),
            (f"{BALL}, repeat: {{kind: grid, counts: [999, 999], spacing: 1}}", "/repeat", "998001 copies"),
            (f"{BALL}, repeat: {{kind: running_bond, rows: 2, columns: 2}}", "/shape", "made of boxes"),
            ("kind: rigid, shape: {kind: mesh, file: a.obj}, place: {on: floor}", "/shape/file", "does not exist"),
        ],
    )  # fmt: skip
    def test_are_located(self, fields, path, said):
        copies, (problem,) = place([f"ball: {{{fields}}}"], problems=1)
        assert problem.path == f"/bodies/ball{path}"
        assert problem.line == FIRST_LINE
        assert re.search(said, problem.message)
        assert copies["ball"][0].pos is not None

    def test_a_near_name_is_offered(self):
        _, (problem,) = place([f"ball: {{{BALL}, place: {{on: flor}}}}"], problems=1)
        assert problem.hint == "floor"

    def test_a_circle_is_reported_once(self):
        _, (problem,) = place([
            *(f"{name}: {{{BALL}, place: {{on: {other}}}}}" for name, other in ("ac", "ba", "cb")),
        ], problems=1)  # fmt: skip
        assert problem.rule == "circular-place"
        assert problem.path == "/bodies/a/place"

    def test_order_of_writing_does_not_matter(self):
        copies = place([f"top: {{{BALL}, place: {{on: base}}}}", f"base: {{{BRICK}, place: {{on: table}}}}"])
        assert pos_of(copies, "top")[2] == pytest.approx(0.75 + 0.07 + 0.1)


class TestSpeed:
    def test_thousands_are_placed_in_a_moment(self):
        many = [f"b{i}: {{{BRICK}, pose: {{pos: [0, 0, {i}]}}}}" for i in range(2000)]
        loaded = load_text(HEAD + "\n".join(f"  {line}" for line in many))
        start = time.perf_counter()
        copies, problems = place_all(loaded)
        assert time.perf_counter() - start < 20.0  # 0.02 s on an idle core
        assert (len(copies["b1999"]), problems) == (1, [])

    def test_heavy_libraries_stay_out(self):
        case = HEAD + f"  ball: {{{BALL}, place: {{on: ramp}}}}"
        code = f"""if True:
            import sys
            from text2sim.compiler.placing.placement import place_all
            from text2sim.spec_schema.load import load_text
            assert not place_all(load_text({case!r}))[1]
            print(sorted({{"trimesh", "scipy", "fcl", "mujoco", "genesis", "torch"}} & set(sys.modules)))"""
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        assert done.stdout.strip() == "[]"
