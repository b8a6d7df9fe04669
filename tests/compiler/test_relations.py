"""The words of `place` beyond the plain relations: what lines up, corners, rings, partners, facing."""

import math
import time

import pytest
from place_words import BALL, CUBE, FIRST_LINE, HEAD, RING, apart, placed, pos_of, start

from text2sim.compiler.placing.placement import place_all
from text2sim.compiler.shapes.rotation import quat_rotate
from text2sim.spec_schema.load import load_text


class TestWhere:
    @pytest.mark.parametrize(
        ("place", "expected"),
        [
            ("beside: table", (6.1, 0, 0.75)),
            ("beside: table, direction: [-1, 0, 0], clearance: 0.3", (3.6, 0, 0.75)),
            ("beside: table, direction: [0, -1, 0], align: top", (5, -0.6, 0.65)),
            ("beside: table, direction: y, align: {x: max, z: center}", (5.9, 0.6, 0.7)),
            # The table reaches (1 + 0.5) / sqrt(2) along the diagonal.
            ("beside: table, direction: [1, 1, 0]", (5 + 0.75 + 0.1 / math.sqrt(2), 0.75 + 0.1 / math.sqrt(2), 0.75)),
            ("right_of: table, align: center", (6.1, 0, 0.7)),
            ("behind: table, align: {x: min}", (4.1, 0.6, 0.75)),
            ("on: table, align: {x: min, y: max}", (4.1, 0.4, 0.85)),
            ("above: table, align: {x: center}, clearance: 0.2", (5, 0, 1.05)),
            ("touching: table, direction: [0, -1, 0], align: {x: max, z: max}", (5.9, -0.6, 0.65)),
            ("on: table, offset: [0.3, 0.1, 0.5]", (5.3, 0.1, 1.35)),
            ("right_of: table, offset: [0, 0, 1]", (6.1, 0, 1.75)),
            ("on: table, at: {corner: [left, front]}", (4.1, -0.4, 0.85)),
            ("on: table, at: {corner: [right, back, top]}, inset: 0.05", (5.85, 0.35, 0.85)),
            ("on: table, at: {edge: left}, inset: 0.1", (4.2, 0, 0.85)),
            ("on: table, at: {face: top}", (5, 0, 0.85)),
            ("below: table, at: {corner: [left, front]}", (4.1, -0.4, 0.55)),
            # The tray is turned: its left is the world's front.
            ("on: tray, at: {edge: left}", (0, 4.1, 0.85)),
            ("on: tray, at: {corner: [right, back]}", (-0.4, 5.9, 0.85)),
            # Over a point of it: the ball's own point goes there.
            ("on: tray, at: {nearest: [0.3, 0.2, 9]}", (-0.2, 5.3, 0.85)),
            ("on: cup, at: {nearest: [9, 0, 0.2]}", (-2.7, 0, None)),
            ("touching: table, at: {face: right}, direction: x", (6.1, 0, 0.7)),
            ("touching: table, at: {corner: [right, back, top]}, direction: z", (6, 0.5, 0.85)),
            # Slid against walls from the inside.
            ("inside: open_box, at: {corner: [left, front]}", (-6.38, -0.38, 1.11)),
            ("inside: open_box, at: {edge: right}, inset: 0.05", (-5.67, 0, 1.11)),
            ("inside: open_box, align: {y: max}", (-6, 0.38, 1.11)),
            ("inside: open_box, at: [-6.2, 0.1]", (-6.2, 0.1, 1.11)),
        ],
    )  # fmt: skip
    def test_a_ball_goes_where_the_words_say(self, place, expected):
        found = pos_of(f"ball: {{{BALL}, place: {{{place}}}}}")
        for value, wanted in zip(found, expected, strict=True):
            assert wanted is None or value == pytest.approx(wanted, abs=2e-6)

    def test_an_offset_on_a_round_thing_lets_it_down_there(self):
        egg = "egg: {kind: rigid, shape: {kind: sphere, radius: 0.5}, place: {on: floor, at: [20, 0]}}"
        x, _, z = pos_of(egg, f"ball: {{{BALL}, place: {{on: egg, offset: [0.3, 0, 0]}}}}")
        assert x == pytest.approx(20.3)
        assert math.hypot(0.3, z - 0.5) == pytest.approx(0.6, abs=1e-6)

    def test_a_lying_tube_rests_on_its_flat_staves(self):
        tube = "kind: rigid, shape: {kind: tube, outer_radius: 0.3, inner_radius: 0.25, height: 0.4, segments: 6}"
        z = pos_of(f"tube: {{{tube}, place: {{on: floor, euler_deg: [90, 0, 0]}}}}")[2]
        assert z == pytest.approx(0.275)  # half way through the wall: it is thickened where it would be too thin

    def test_trees_are_more_than_their_bounds(self):
        """A ball on a net rests on the sagging strands in its middle, not at the height of its edge."""
        net = "net: {kind: net, cells: [6, 6], size: [1.8, 1.8], sag: 0.3, radius: 0.01, pose: {pos: [0, 20, 1.2]}}"
        z = pos_of(net, f"ball: {{{BALL}, place: {{on: net}}}}")[2]
        assert z == pytest.approx(0.9 + 0.01 + 0.1, abs=1e-3)


class TestChains:
    def test_plate_on_cloth_on_table(self):
        copies = placed(
            "cloth: {kind: rigid, shape: {kind: box, size: [1, 0.8, 0.002]}, place: {on: table}}",
            "plate: {kind: rigid, shape: {kind: cylinder, radius: 0.13, height: 0.02},"
            " place: {on: cloth, at: {edge: front}, inset: 0.03}}",
            "mug: {kind: rigid, shape: {kind: cup, radius: 0.04, height: 0.1, thickness: 0.004}, place: {on: plate}}",
            f"ball: {{{BALL.replace('0.1', '0.03')}, place: {{inside: mug}}}}",
        )
        assert copies["plate"][0].pos == pytest.approx((5, -0.4 + 0.16, 0.75 + 0.002 + 0.01))
        assert copies["mug"][0].pos == pytest.approx((5, -0.24, 0.772 + 0.05))
        assert copies["ball"][0].pos[2] == pytest.approx(0.772 + 0.004 + 0.03, abs=1e-6)

    def test_brackets_put_one_on_each(self):
        plates = f"plate: {{{CUBE}, repeat: {{kind: ring, count: 4, radius: 0.3}}, place: {{on: table}}}}"
        copies = placed(
            plates, f"ball: {{{BALL}, repeat: {{kind: ring, count: 4, radius: 9}}, place: {{on: 'plate[*]'}}}}"
        )
        for plate, ball in zip(copies["plate"], copies["ball"], strict=True):
            assert ball.pos == pytest.approx((plate.pos[0], plate.pos[1], plate.pos[2] + 0.2))
            assert ball.quat == pytest.approx(plate.quat)  # of the pattern the turns count

    def test_a_range_in_brackets_pairs_too_and_a_bare_name_means_all(self):
        posts = f"post: {{{CUBE}, repeat: {{kind: line, count: 5, step: [1, 0, 0.1]}}}}"
        two = "repeat: {kind: line, count: 2, step: [0.5, 0, 0]}"
        pair = placed(posts, f"ball: {{{BALL}, {two}, place: {{on: 'post[3:5]'}}}}")["ball"]
        assert [ball.pos for ball in pair] == [pytest.approx((3, 0, 0.5)), pytest.approx((4, 0, 0.6))]
        together = placed(posts, f"ball: {{{BALL}, {two}, place: {{above: post}}}}")["ball"]
        assert [ball.pos[0] for ball in together] == pytest.approx([1.75, 2.25])
        one = placed(posts, f"ball: {{{BALL}, {two}, place: {{above: 'post[2]'}}}}")["ball"]
        assert [ball.pos[0] for ball in one] == pytest.approx([1.75, 2.25])

    def test_each_copy_has_its_own_words(self):
        posts = f"post: {{{CUBE}, repeat: {{kind: line, count: 2, step: [1, 0, 0]}}}}"
        ball = f"ball: {{{BALL}, repeat: {{kind: line, count: 2, step: [0, 0, 0]}},"
        copies = placed(posts, ball + " place: {on: 'post[*]', clearance: '${0.1 * i}', offset: [0, 0, '${i}']}}")
        assert [copy.pos[2] for copy in copies["ball"]] == pytest.approx([0.2, 1.3])

    def test_fifteen_hundred_follow_each_other_in_a_moment(self):
        shapes = ("{kind: box, size: [0.24, 0.11, 0.07]}", "{kind: cylinder, radius: 0.1, height: 0.05}")
        bodies = [
            f"b{i}: {{kind: rigid, shape: {shapes[i % 2]}, place: {{on: {f'b{i - 1}' if i else 'table'}}}}}"
            for i in range(1500)
        ]
        loaded = load_text(HEAD + "".join(f"  {body}\n" for body in bodies))
        begin = time.process_time()
        copies, problems = place_all(loaded)
        assert time.process_time() - begin < 20.0  # 0.1 s on an idle core; far more if every pair were looked at
        assert problems == []
        assert copies["b1499"][0].pos[2] == pytest.approx(0.75 + 750 * 0.12 - 0.025, abs=1e-3)

    def test_nine_hundred_cups_stand_in_a_moment(self):
        cup = "kind: rigid, shape: {kind: cup, radius: 0.05, height: 0.08, thickness: 0.01}"
        plate = "kind: rigid, shape: {kind: cylinder, radius: 0.1, height: 0.02}"
        grid = "repeat: {kind: grid, counts: [30, 30], spacing: 0.25}"
        loaded = load_text(
            f"{HEAD}  plate: {{{plate}, {grid}, place: {{on: floor}}}}\n  mug: {{{cup}, {grid}, place: {{on: 'plate[*]'}}}}\n"
        )
        begin = time.process_time()
        copies, problems = place_all(loaded)
        assert time.process_time() - begin < 20.0  # 0.15 s on an idle core; far more if every pair were looked at
        assert problems == []
        assert {round(cup.pos[2], 6) for cup in copies["mug"]} == {0.06}


class TestAround:
    @pytest.mark.parametrize(
        ("words", "height"),
        [("", 1.0), (", align: bottom", 0.02), (", align: top", 1.98), (", offset: [0, 0, 0.3]", 1.3)],
    )
    def test_a_ring_goes_on_its_pole(self, words, height):
        copies = placed(f"ring: {{{RING}, place: {{around: pole{words}}}}}")
        assert copies["ring"][0].pos == pytest.approx((1, 1, height))
        assert apart(copies, "ring", "pole") == pytest.approx(0.028, abs=1e-3)  # the ring is made of straight pieces

    @pytest.mark.parametrize(("target", "axis"), [("rod", (math.sqrt(3) / 2, 0.5, 0)), ("beam", (0, 1, 0))])
    def test_it_is_turned_with_what_it_goes_around(self, target, axis):
        """The axis of what is round is its own; that of a box is its longest side."""
        copies = placed(f"ring: {{{RING}, place: {{around: {target}}}}}")
        assert copies["ring"][0].pos == pytest.approx(copies[target][0].pos)
        found = quat_rotate(copies["ring"][0].quat, (0, 0, 1))
        assert abs(sum(a * b for a, b in zip(found, axis, strict=True))) == pytest.approx(1)

    def test_several_rings_hang_on_one_pole(self):
        copies = placed(
            f"ring: {{{RING}, repeat: {{kind: line, count: 3, step: [0, 0, 0.2]}}, place: {{around: pole}}}}"
        )
        assert [ring.pos for ring in copies["ring"]] == [pytest.approx((1, 1, z)) for z in (0.8, 1.0, 1.2)]

    def test_chairs_stand_around_a_table_and_face_it(self):
        chair = "chair: {kind: rigid, shape: {kind: box, size: [0.4, 0.4, 0.5]}, repeat: {kind: ring, count: 6, radius: 1.5},"
        copies = placed(f"{chair} place: {{around: table, facing: table}}}}")
        for copy in copies["chair"]:
            assert math.hypot(copy.pos[0] - 5, copy.pos[1]) == pytest.approx(1.5)
            assert copy.pos[2] == pytest.approx(0.65 + 0.25)
            x, y, _ = quat_rotate(copy.quat, (1, 0, 0))
            assert (x * 1.5, y * 1.5) == pytest.approx((5 - copy.pos[0], -copy.pos[1]))

    @pytest.mark.parametrize(
        ("body", "key", "said"),
        [
            (f"{BALL}, place: {{around: pole}}", "around", "does not fit around `pole`, which is 0.1 m across"),
            (f"{RING}, place: {{around: table}}", "around", "its hole is 0.16 m wide, and that is 0.1 m by 1 m across"),
            (f"{RING}, place: {{around: pole, clearance: 0.04}}", "clearance", "only 0.0281 m is left"),
            (f"{RING}, place: {{around: pole, offset: [0, 0, 3]}}", "offset", "does not surround"),
            (f"{RING}, place: {{around: floor}}", "around", "a plane"),
            (f"{RING}, place: {{around: pole, align: {{x: min}}}}", "align", "already determines x"),
            (f"{CUBE}, repeat: {{kind: ring, count: 3, radius: 0.12}}, place: {{around: pole}}", "around", "larger by 0.03 m"),
            (f"{CUBE}, repeat: {{kind: ring, count: 3, radius: 0.3}}, place: {{around: pole, clearance: 0.2}}", "around", "larger by 0.05 m"),
        ],
    )  # fmt: skip
    def test_what_does_not_fit_is_said(self, body, key, said):
        _, (problem,) = start(f"it: {{{body}}}")
        assert problem.path == f"/bodies/it/place/{key}"
        assert said in problem.message
        assert problem.line == FIRST_LINE


class TestFacing:
    def test_a_thing_that_moves_as_it_turns_faces_in_the_end(self):
        copies = placed(
            f"ball: {{{BALL}, place: {{on: floor, at: [8, 3]}}}}",
            "plank: {kind: rigid, shape: {kind: box, size: [1, 0.1, 0.1]}, place: {right_of: pole, facing: ball}}",
        )
        plank = copies["plank"][0]
        ahead = quat_rotate(plank.quat, (1, 0, 0))
        assert ahead[1] / ahead[0] == pytest.approx((3 - plank.pos[1]) / (8 - plank.pos[0]))
        assert apart(copies, "pole", "plank") >= 0

    @pytest.mark.parametrize(
        ("place", "said"),
        [
            ("on: table, facing: [5, 0, 9]", "right above or below"),
            ("on: floor, euler_deg: [0, 90, 0], facing: table", "straight up or down"),
            ("on: floor, facing: tabel", "there is no body or static `tabel`"),
        ],
    )
    def test_what_cannot_face_is_said(self, place, said):
        _, (problem,) = start(f"ball: {{{BALL}, place: {{{place}}}}}")
        assert (problem.path, said in problem.message) == ("/bodies/ball/place/facing", True)


class TestProblems:
    @pytest.mark.parametrize(
        ("place", "key", "said"),
        [
            ("on: table, offset: [3, 0, 0]", "offset", "along x it would reach from 7.9 to 8.1, and `table` reaches from 4 to 6"),
            ("on: floor, at: {edge: left}", "at", "a plane has neither sides nor corners"),
            ("on: table, at: {corner: [left, bottom]}", "at", "the bottom of `table` points down"),
            ("on: table, at: {sphere: {center: [0, 0, 0], radius: 0.01}}", "at", "the nearest point of it is 40 mm away"),
            ("on: table, at: {edge: left}, inset: 2.5", "at", "along x it would reach"),
            ("inside: pole, at: {edge: left}", "inside", "one solid piece"),
            ("on: floor, align: {x: min}", "align", "no ends"),
            ("touching: floor, direction: z, align: {x: min}", "align", "no ends"),
            ("beside: floor", "beside", "no sides"),
        ],
    )  # fmt: skip
    def test_are_located(self, place, key, said):
        _, (problem,) = start(f"ball: {{{BALL}, place: {{{place}}}}}")
        assert problem.path == f"/bodies/ball/place/{key}"
        assert said in problem.message

    @pytest.mark.parametrize(
        ("parts", "inside"),
        [
            # Four legs and a top; a frame of two posts; a lone wall with a foot.
            ({f"leg_{k}": ([0.05, 0.05, 0.7], [x, y, 0.35]) for k, (x, y) in enumerate([(-0.5, -0.4), (0.5, -0.4), (-0.5, 0.4), (0.5, 0.4)])} | {"top": ([1.1, 0.9, 0.03], [0, 0, 0.715])}, False),
            ({"left": ([0.05, 0.25, 1], [-0.3, 0, 0.5]), "right": ([0.05, 0.25, 1], [0.3, 0, 0.5]), "bar": ([0.65, 0.25, 0.05], [0, 0, 1])}, False),
            ({"foot": ([1, 1, 0.02], [0, 0, 0.01]), "wall": ([0.02, 1, 1], [0.49, 0, 0.52])}, False),
            # A channel with open ends; a shelf that is open in front; a cage of bars.
            ({"ground": ([0.4, 2, 0.02], [0, 0, 0.01]), "left": ([0.02, 2, 0.4], [-0.2, 0, 0.2]), "right": ([0.02, 2, 0.4], [0.2, 0, 0.2])}, True),
            ({"ground": ([1, 0.6, 0.02], [0, 0, 0.01]), "left": ([0.02, 0.6, 1], [-0.5, 0, 0.5]), "right": ([0.02, 0.6, 1], [0.5, 0, 0.5]), "back": ([1, 0.02, 1], [0, 0.3, 0.5])}, True),
            ({"ground": ([1, 1, 0.02], [0, 0, 0.01])} | {f"bar_{k}": ([0.02, 0.02, 1], [0.4 * math.cos(k * math.pi / 8), 0.4 * math.sin(k * math.pi / 8), 0.5]) for k in range(16)}, True),
        ],
    )  # fmt: skip
    def test_what_has_an_inside(self, parts, inside):
        listed = ", ".join(
            f"{name}: {{shape: {{kind: box, size: {size}}}, pose: {{pos: {pos}}}}}"
            for name, (size, pos) in parts.items()
        )
        thing = f"thing: {{kind: rigid, shape: {{kind: compound, parts: {{{listed}}}}}, pose: {{pos: [20, 0, 0]}}}}"
        _, problems = start(thing, f"ball: {{{BALL}, place: {{inside: thing}}}}")
        assert [problem.path for problem in problems] == ([] if inside else ["/bodies/ball/place/inside"])
        assert all("`thing` has no inside there" in problem.message for problem in problems)

    def test_partners_must_be_as_many(self):
        posts = f"post: {{{CUBE}, repeat: {{kind: line, count: 3, step: [1, 0, 0]}}}}"
        _, (problem,) = start(posts, f"b: {{{BALL}, repeat: {{kind: stack, count: 2}}, place: {{on: 'post[*]'}}}}")
        assert (problem.rule, problem.path) == ("pairs", "/bodies/b/place/on")
        assert "`post[*]` means 3, `b` has 2; `post` means all of them together" in problem.message

    def test_the_copy_that_fails_is_named(self):
        ball = f"ball: {{{BALL}, repeat: {{kind: line, count: 3, step: [0, 0, 0]}},"
        _, (problem,) = start(ball + " place: {on: table, at: ['${5 + 2 * i}', 0]}}")
        assert problem.message.startswith("copy 1: `table` is nowhere under it")

    def test_nothing_is_said_of_what_hangs_on_a_failure(self):
        _, (problem,) = start(
            f"a: {{{BALL}, place: {{on: table, at: [9, 9]}}}}",
            f"b: {{{BALL}, place: {{inside: a}}}}",
            f"c: {{{BALL}, place: {{on: b}}}}",
        )
        assert problem.path == "/bodies/a/place/at"

    def test_two_that_face_each_other_are_a_circle(self):
        _, (problem,) = start(
            *(f"{a}: {{{BALL}, place: {{on: floor, at: [{x}, 0], facing: {b}}}}}" for a, b, x in ("ab0", "ba1"))
        )
        assert problem.rule == "circular-place"
        assert "a -> b -> a; give one of them a pose" in problem.message


LIFT = """\
lift:
    kind: articulated
    pose: {pos: [3, 2, 0], euler_deg: [0, 0, 90]}
    initial: {tray: 0.25}
    links:
      mast: {shape: {kind: box, size: [0.1, 0.1, 2]}, pose: {pos: [0, 0, 1]}}
      tray:
        parent: mast
        shape: {kind: box, size: [0.4, 0.4, 0.02]}
        pose: {pos: [0.3, 0, -0.5]}
        joint: {kind: slider, axis: z}
"""


def test_a_link_is_a_place_where_it_starts():
    # The mast turns the tray's 0.3 m along x to y; its slider starts 0.25 m up, so its top is at 1 - 0.5 + 0.25 + 0.01.
    assert pos_of(LIFT, f"cube: {{{CUBE}, place: {{on: lift.tray}}}}") == pytest.approx((3, 2.3, 0.86), abs=1e-6)
    # Beside the tray's right edge, and not the mast's.
    x, y, _ = pos_of(LIFT, f"cube: {{{CUBE}, place: {{right_of: lift.tray}}}}")
    assert (x, y) == pytest.approx((3 + 0.2 + 0.1, 2.3), abs=1e-6)


def test_a_link_without_a_shape_in_the_case_is_none():
    chain = "chain: {kind: chain, links: 4, link_length: 0.1, radius: 0.02, pose: {pos: [0, 0, 3]}}"
    _, (problem,) = start(chain, f"ball: {{{BALL}, place: {{on: chain.link_1}}}}")
    assert "`chain.link_1` has no shape in the case" in problem.message
    assert "the whole body `chain`" in problem.message
