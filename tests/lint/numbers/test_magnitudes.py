"""Sizes, masses and positions beyond the bounds that were measured in the engine."""

from pathlib import Path

import pytest
from lint_support import findings

BALL = "bodies: {{ball: {{kind: rigid, shape: {{kind: sphere, radius: {0}}}, place: {{on: floor}}{1}}}}}"


@pytest.mark.parametrize(
    ("radius", "severity"), [(2e-6, "error"), (5e-6, "error"), (0.0005, "error"), (0.002, "warning"), (0.01, None)]
)
def test_too_small(tmp_path: Path, radius: float, severity: str | None) -> None:
    found = findings(tmp_path, "too-small", BALL.format(radius, ""))
    assert [problem.severity for problem in found] == ([severity] if severity else [])


def test_a_shorter_timeconst_carries_smaller_bodies(tmp_path: Path) -> None:
    (found,) = findings(tmp_path, "too-small", BALL.format(0.002, ""))
    assert "scene.contact.timeconst of 0.019 s with scene.substeps of 2 or more" in found.message
    better = "scene: {contact: {timeconst: 0.019}, substeps: 2}"
    assert findings(tmp_path, "too-small", better, BALL.format(0.002, "")) == []


def test_without_gravity_nothing_sinks(tmp_path: Path) -> None:
    free = "scene: {gravity: [0, 0, 0]}"
    assert findings(tmp_path, "too-small", free, BALL.format(0.002, "")) == []
    assert len(findings(tmp_path, "too-small", free, BALL.format(1e-6, ""))) == 1


@pytest.mark.parametrize(("radius", "severity"), [(20, None), (120, "warning"), (9e5, "error")])
def test_too_large(tmp_path: Path, radius: float, severity: str | None) -> None:
    found = findings(tmp_path, "huge-body", BALL.format(radius, ""))
    assert [problem.severity for problem in found] == ([severity] if severity else [])


def test_a_brick_in_millimetres(tmp_path: Path) -> None:
    (found,) = findings(
        tmp_path,
        "huge-body",
        "bodies: {b: {kind: rigid, shape: {kind: box, size: [240, 115, 71]}, place: {on: floor}}}",
    )
    assert "240 mm are 0.24 m" in found.message


@pytest.mark.parametrize(("size", "count"), [([1500, 800, 40], 1), ([1500, 800, 1], 0), ([90, 60, 40], 0)])
def test_a_table_in_millimetres_among_things_in_metres(tmp_path: Path, size: list[float], count: int) -> None:
    """A thin ground and a house may be large."""
    table = f"scene: {{statics: {{table: {{shape: {{kind: box, size: {size}}}, place: {{on: floor}}}}}}}}"
    found = findings(tmp_path, "huge-body", table, BALL.format(0.1, "").replace("floor", "table"))
    assert [problem.path for problem in found] == ["/scene/statics/table/shape"] * count


def test_the_unit_of_a_mesh(assets: Path) -> None:
    mesh = "bodies: {ring: {kind: rigid, shape: {kind: mesh, file: ring.obj%s}, pose: {pos: [0, 0, 5000]}}}"
    assert findings(assets, "huge-body", mesh % "") == []
    (found,) = findings(assets, "huge-body", mesh % ", scale: 400")
    assert "scale: 0.001" not in found.message
    big = (assets / "ring.obj").read_text().splitlines()
    lines = [
        " ".join(["v", *(str(5000 * float(x)) for x in line.split()[1:4])]) if line.startswith("v ") else line
        for line in big
    ]
    (assets / "big.obj").write_text("\n".join(lines))
    (found,) = findings(assets, "huge-body", mesh.replace("ring.obj", "big.obj") % "")
    assert "`scale: 0.001` if the file is in millimetres" in found.message


@pytest.mark.parametrize(("mass", "severity"), [(1e6, None), (1e9, "warning"), (1e11, "error")])
def test_too_heavy(tmp_path: Path, mass: float, severity: str | None) -> None:
    found = findings(tmp_path, "too-heavy", BALL.format(0.1, f", material: {{mass: {mass}}}"))
    assert [problem.severity for problem in found] == ([severity] if severity else [])


@pytest.mark.parametrize(("x", "severity"), [(3000, None), (20_000, "warning"), (1e6, "error")])
def test_far_away(tmp_path: Path, x: float, severity: str | None) -> None:
    ball = f"bodies: {{ball: {{kind: rigid, shape: {{kind: sphere, radius: 0.1}}, pose: {{pos: [{x}, 0, 1]}}}}}}"
    found = findings(tmp_path, "far-away", ball)
    assert [(problem.path, problem.severity) for problem in found] == (
        [("/bodies/ball/pose", severity)] if severity else []
    )


def test_dishes_of_the_library_stand_at_5_ms(tmp_path: Path) -> None:
    """Their walls yield by at most a tenth of a millimetre, which is invisible (in Genesis a glass sank 4 um)."""
    dishes = "bodies: {glass: {use: wine_glass, place: {on: floor}}, bottle: {use: bottle, place: {right_of: glass}}}"
    assert findings(tmp_path, "too-small", "scene: {dt: 0.005}", dishes) == []
