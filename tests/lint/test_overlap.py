"""Bodies that start inside each other are named, those that only touch are not."""

from pathlib import Path

import pytest

from text2sim.compiler.build import plan_case
from text2sim.spec_schema.load import load_case

HEAD = "text2sim: 1\nname: probe\nscene: {duration: 1.0, statics: {floor: {shape: {kind: plane}}}}\nbodies:\n"
BOX = "{{kind: rigid, shape: {{kind: box, size: [1, 1, 1]}}, pose: {{pos: {pos}}}{more}}}"


def warnings(folder: Path, bodies: str) -> list[str]:
    (folder / "case.yaml").write_text(HEAD + bodies)
    return [
        f"{p.line}: {p.message.split(' at the start')[0]}"
        for p in plan_case(load_case(folder)).warnings
        if p.rule == "overlap"
    ]


@pytest.mark.parametrize(
    ("bodies", "wanted"),
    [
        (["[0, 0, 0.5]", "[1, 0, 0.5]"], []),
        (["[0, 0, 0.5]", "[0.9, 0, 0.5]"], ["5: a and b overlap"]),
        (["[0, 0, 0.5]", "[5, 0, 0.4]"], ["6: b is partly or wholly under floor"]),
    ],
)
def test_two_boxes(tmp_path: Path, bodies: list[str], wanted: list[str]) -> None:
    text = "".join(f"  {name}: {BOX.format(pos=pos, more='')}\n" for name, pos in zip("ab", bodies, strict=True))
    assert warnings(tmp_path, text) == wanted


def test_a_ball_in_a_cup_is_not_in_its_wall(tmp_path: Path) -> None:
    cup = "  cup: {kind: rigid, shape: {kind: cup, radius: 0.5, height: 1.0, thickness: 0.1}, place: {on: floor}}\n"
    ball = "  ball: {kind: rigid, shape: {kind: sphere, radius: 0.3}, place: {inside: cup}}\n"
    assert warnings(tmp_path, cup + ball) == []
    assert warnings(tmp_path, cup + ball.replace("place: {inside: cup}", "pose: {pos: [0.3, 0, 0.5]}")) == [
        "5: cup and ball overlap"
    ]


def test_many_copies_make_one_warning(tmp_path: Path) -> None:
    text = f"  a: {BOX.format(pos='[0, 0, 0.5]', more=', repeat: {kind: line, count: 4, step: [0.5, 0, 0]}')}\n"
    assert warnings(tmp_path, text) == ["5: a[0] and a[1] overlap"]


def test_what_the_world_holds_may_stand_in_what_never_moves(tmp_path: Path) -> None:
    fixed = f"  a: {BOX.format(pos='[0, 0, 0.3]', more=', mount: {kind: fixed}')}\n"
    assert warnings(tmp_path, fixed) == []
