"""Implausible densities and masses, and the units that were probably meant."""

from pathlib import Path

import pytest
from lint_support import findings

ROOT = Path(__file__).resolve().parents[3]
BALL = "bodies: {{ball: {{kind: rigid, shape: {{kind: sphere, radius: {0}}}, place: {{on: floor}}{1}}}}}"


@pytest.mark.parametrize(
    ("density", "count"), [(0.01, 1), (7.8, 1), (19, 1), (25, 0), (22_600, 0), (24_000, 1), (7.8e6, 1)]
)
def test_implausible_density(tmp_path: Path, density: float, count: int) -> None:
    found = findings(tmp_path, "implausible-density", BALL.format(0.1, f", material: {{density: {density}}}"))
    assert [problem.path for problem in found] == ["/bodies/ball/material/density"] * count


@pytest.mark.parametrize(
    ("density", "unit", "meant"), [(7.8, "g/cm3", "7800"), (0.6, "g/cm3", "600"), (2.7e6, "g/m3", "2700")]
)
def test_the_density_that_was_meant(tmp_path: Path, density: float, unit: str, meant: str) -> None:
    (found,) = findings(tmp_path, "implausible-density", BALL.format(0.1, f", material: {{density: {density}}}"))
    assert (found.hint, found.severity) == (meant, "warning")
    assert f"{unit} are {meant} kg/m3" in found.message


def test_a_heavy_ball_that_a_case_makes_light(tmp_path: Path) -> None:
    """The ball of the brick wall, its density in g/cm3."""
    wall = (ROOT / "cases/brick_wall/case.yaml").read_text(encoding="utf-8")
    assert findings(tmp_path, "implausible-density", wall) == []
    (found,) = findings(tmp_path, "implausible-density", wall.replace("density: 7800", "density: 7.8"))
    assert found.path == "/bodies/ball/material/density"


@pytest.mark.parametrize(("density", "count"), [(1, 0), (1.2, 0), (2.7, 1), (500, 0)])
def test_air_in_a_part(tmp_path: Path, density: float, count: int) -> None:
    part = f"parts: {{a: {{shape: {{kind: sphere, radius: 0.1}}}}, b: {{shape: {{kind: sphere, radius: 0.09}}, density: {density}}}}}"
    bottle = f"bodies: {{c: {{kind: rigid, shape: {{kind: compound, {part}}}, place: {{on: floor}}}}}}"
    assert len(findings(tmp_path, "implausible-density", bottle)) == count


def test_densities_of_parts_and_statics(tmp_path: Path) -> None:
    parts = "parts: {a: {shape: {kind: sphere, radius: 0.1}, density: 1.0e+6}, b: {shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 0.2]}}}"
    (found,) = findings(
        tmp_path,
        "implausible-density",
        f"bodies: {{c: {{kind: rigid, shape: {{kind: compound, {parts}}}, place: {{on: floor}}}}}}",
    )
    assert found.path == "/bodies/c/shape/parts/a/density"


@pytest.mark.parametrize(
    ("mass", "words"),
    [(0.17, ""), (5, ""), (170, "170 g are 0.17 kg"), (1e-6, "which no material has")],
)
def test_a_mass_that_no_matter_has(tmp_path: Path, mass: float, words: str) -> None:
    found = findings(tmp_path, "implausible-density", BALL.format(0.0286, f", material: {{mass: {mass}}}"))
    assert [words in problem.message for problem in found] == [True] * bool(words)
    assert all(problem.path == "/bodies/ball/material/mass" for problem in found)


@pytest.mark.parametrize(("mass", "wanted"), [(0.0005, True), (50, False), (50000, True)])
def test_a_link_of_a_mass_that_no_matter_has(tmp_path: Path, mass: float, wanted: bool) -> None:
    links = f"""\
bodies:
  arm:
    kind: articulated
    pose: {{pos: [0, 0, 1]}}
    links: {{hub: {{shape: {{kind: box, size: [0.4, 0.4, 0.4]}}, material: {{mass: {mass}}}}}}}
"""
    found = [problem.path for problem in findings(tmp_path, "implausible-density", links)]
    assert found == ["/bodies/arm/links/hub/material/mass"] * wanted


@pytest.mark.parametrize(
    ("body", "key", "value", "hint"),
    [
        ("kind: soft, shape: {kind: sphere, radius: 0.1}", "density", 0.9, "900"),
        ("kind: granular, shape: {kind: sphere, radius: 0.1}", "density", 1.6, "1600"),
        ("kind: liquid, shape: {kind: sphere, radius: 0.1}", "density", 1.0, "1000"),
        ("kind: cloth, shape: {kind: sheet, size: [1, 1]}", "area_density", 300, "0.3"),
        ("kind: soft, shape: {kind: sphere, radius: 0.1}", "density", 1e9, None),
        ("kind: cloth, shape: {kind: sheet, size: [1, 1]}", "area_density", 0.0001, None),
    ],
)
def test_densities_of_what_deforms(tmp_path: Path, body: str, key: str, value: float, hint: str | None) -> None:
    case = "bodies: {{a: {{{}, pose: {{pos: [0, 0, 1]}}, material: {{{}: {}}}}}}}"
    (found,) = findings(tmp_path, "implausible-density", case.format(body, key, value))
    assert (found.path, found.hint) == (f"/bodies/a/material/{key}", hint)
    fine = hint or {"density": "900", "area_density": "0.2"}[key]
    assert findings(tmp_path, "implausible-density", case.format(body, key, fine)) == []


@pytest.mark.parametrize(("mount", "count"), [("free", 1), ("hinge", 1), ("fixed", 0)])
def test_mass_that_overlapping_parts_have_twice(tmp_path: Path, mount: str, count: int) -> None:
    """What never moves needs no mass."""
    parts = "a: {shape: {kind: box, size: [0.2, 0.1, 0.1]}}, b: {shape: {kind: box, size: [0.1, 0.1, 0.2]}}"
    body = f"{{kind: rigid, shape: {{kind: compound, parts: {{{parts}}}}}, mount: {{kind: {mount}}}, pose: {{pos: [0, 0, 1]}}}}"
    found = findings(tmp_path, "counted-twice", f"bodies: {{cross: {body}}}")
    assert [problem.path for problem in found] == ["/bodies/cross/shape/parts"] * count
