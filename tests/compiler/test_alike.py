"""Copies that are alike share what is made of them, and keep what is their own."""

import time

from text2sim.compiler.build import resolve_case
from text2sim.compiler.shapes.geometry import pieces
from text2sim.spec_schema.load import load_text

HEAD = "text2sim: 1\nname: alike\nscene: {duration: 1, statics: {floor: {shape: {kind: plane}}}}\nbodies:\n"
CUP = "kind: rigid, shape: {kind: cup, radius: 0.05, height: 0.08, thickness: 0.01}"


def plan_of(body):
    return resolve_case(load_text(f"{HEAD}  cup: {{{body}}}\n")).plan


def test_copies_in_many_colours_share_one_model_and_keep_their_colours():
    plan = plan_of(
        f"{CUP}, repeat: {{kind: line, count: 5, step: [1, 0, 0]}}, look: {{color: [red, blue], vary: {{value: 0.2}}}}"
    )
    (group,) = plan.bodies
    assert {entity.options["file"] for entity in group.entities} == {"models/cup.xml"}
    assert len({entity.surface.rgba for entity in group.entities}) == 5
    assert [entity.pos[0] for entity in group.entities] == [0, 1, 2, 3, 4]
    group.entities[0].options["file"] = "changed"
    assert group.entities[1].options["file"] == "models/cup.xml"


def test_copies_of_different_weight_have_models_of_their_own():
    plan = plan_of(
        f"{CUP}, repeat: {{kind: line, count: 3, step: [1, 0, 0]}}, material: {{density: '${{500 * (1 + i % 2)}}'}}"
    )
    (group,) = plan.bodies
    files = [entity.options["file"] for entity in group.entities]
    assert files[0] == files[2] != files[1]


def test_parts_in_colours_of_their_own_are_not_mixed_up():
    part = "shape: {kind: box, size: [0.1, 0.1, 0.1]}"
    shape = f"{{kind: compound, parts: {{a: {{{part}, look: {{color: [red, green]}}}}, b: {{{part}, pose: {{pos: [1, 0, 0]}}}}}}}}"
    plan = plan_of(
        f"kind: rigid, shape: {shape}, repeat: {{kind: line, count: 4, step: [0, 1, 0]}}, look: {{color: blue}}"
    )
    (group,) = plan.bodies
    files = [entity.options["file"] for entity in group.entities]
    assert files[0] == files[2] != files[1] == files[3]
    assert all(entity.surface is None for entity in group.entities)


def test_equal_shapes_have_the_same_pieces_and_a_list_of_their_own():
    one, same = (load_text(f"{HEAD}  cup: {{{CUP}}}\n").case.bodies["cup"].shape for _ in range(2))
    first, second = pieces(one, None), pieces(same, None)
    assert first is not second
    assert all(a is b for a, b in zip(first, second, strict=True))


def test_seven_hundred_cups_are_resolved_in_a_moment():
    loaded = load_text(
        f"{HEAD}  cup: {{{CUP}, place: {{on: floor}}, repeat: {{kind: grid, counts: [28, 25], spacing: 0.2}}}}\n"
    )
    begin = time.process_time()
    plan = resolve_case(loaded).plan
    assert time.process_time() - begin < 20.0  # 0.1 s on an idle core
    assert len(plan.bodies[0].entities) == 700
