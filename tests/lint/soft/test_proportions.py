"""Deformable bodies that collapse under their weight or cannot fold, and their angles, forces and measures."""

from pathlib import Path

import pytest
from lint_support import findings

BODY = "bodies: {{a: {{kind: {}, pose: {{pos: [0, 0, 1]}}, {}}}}}"
CUBE = "shape: {kind: box, size: [0.2, 0.2, 0.2]}"


@pytest.mark.parametrize(
    ("stiffness", "hint"), [(0.05, "50000"), (20, "20000"), (1500, None), (2500, ""), (5e4, ""), (1e6, "")]
)
def test_the_stiffness_that_was_meant(tmp_path: Path, stiffness: float, hint: str | None) -> None:
    """A cube of 20 cm weighs 1962 Pa on its foot."""
    body = BODY.format("soft", f"{CUBE}, material: {{youngs_modulus: {stiffness}}}")
    found = findings(tmp_path, "squashes-itself", body)
    assert [problem.hint for problem in found] == ([] if hint == "" else [hint])
    assert findings(tmp_path, "squashes-itself", body, "scene: {gravity: [0, 0, 0]}") == []


def test_a_soft_liquid(tmp_path: Path) -> None:
    (found,) = findings(tmp_path, "squashes-itself", BODY.format("liquid", f"{CUBE}, material: {{stiffness: 0.5}}"))
    assert (found.path, found.hint) == ("/bodies/a/material/stiffness", "500000")


@pytest.mark.parametrize(("cell", "count"), [(0.3, 1), (0.1, 1), (0.05, 0), (0.02, 0)])
def test_coarse_cloth(tmp_path: Path, cell: float, count: int) -> None:
    cloth = BODY.format("cloth", f"shape: {{kind: sheet, size: [0.5, 0.5]}}, cell: {cell}")
    assert len(findings(tmp_path, "coarse-cloth", cloth)) == count


def test_a_cloth_narrower_than_its_particles_are_apart(tmp_path: Path) -> None:
    (found,) = findings(tmp_path, "coarse-cloth", BODY.format("cloth", "shape: {kind: sheet, size: [1.0e-6, 0.9]}"))
    assert "0.001 mm wide" in found.message


def test_a_ribbon_is_no_coarse_cloth(tmp_path: Path) -> None:
    ribbon = BODY.format("cloth", "shape: {kind: sheet, size: [0.5, 0.05]}, cell: 0.02")
    assert findings(tmp_path, "coarse-cloth", ribbon) == []


@pytest.mark.parametrize(("angle", "count"), [(0.6, 1), (0.35, 1), (5, 0), (35, 0)])
def test_a_heap_in_radians(tmp_path: Path, angle: float, count: int) -> None:
    sand = BODY.format("granular", f"{CUBE}, material: {{friction_angle_deg: {angle}}}")
    assert len(findings(tmp_path, "looks-like-radians", sand)) == count


@pytest.mark.parametrize("region", ["corner: [left, front, top]", "edge: [left, top]"])
def test_a_corner_is_torn_off(tmp_path: Path, region: str) -> None:
    pull = "actions: {{controls: {{p: {{kind: force, body: a, region: {{{}}}, force: [{}, 0, 0]}}}}}}"
    body = BODY.format("soft", CUBE)
    assert len(findings(tmp_path, "tearing-force", body, pull.format(region, 1e5))) == 1
    assert findings(tmp_path, "tearing-force", body, pull.format(region, 0.1)) == []


@pytest.mark.parametrize(
    ("measure", "expect", "rule"),
    [
        ("kind: stretch, of: rag", "during: all, above: 0", "cannot-fail"),
        ("kind: strain, of: a", "during: all, above: -0.1", "cannot-fail"),
        ("kind: stretch, of: rag", "at: start, above: 1.2", "cannot-hold"),
        ("kind: strain, of: a", "at: start, above: 0.1", "cannot-hold"),
        ("kind: volume, of: a, relative: true", "at: start, below: 0.9", "cannot-hold"),
        ("kind: share_in, of: a, region: {kind: sphere, center: [0, 0, 0], radius: 1}", "at: end, above: 2", "cannot-hold"),
    ],
)  # fmt: skip
def test_what_measures_of_deformation_can_be(tmp_path: Path, measure: str, expect: str, rule: str) -> None:
    rag = "bodies: {rag: {kind: cloth, shape: {kind: sheet, size: [0.5, 0.5]}, pose: {pos: [2, 0, 1]}}}"
    asked = f"actions: {{measures: {{m: {{{measure}}}}}, expect: {{e: {{measure: m, {expect}}}}}}}"
    assert len(findings(tmp_path, rule, BODY.format("soft", CUBE), rag, asked)) == 1


@pytest.mark.parametrize(
    ("model", "key", "count"),
    [
        ("particle", "poisson_ratio", 1),
        ("particle", "stretch_compliance", 0),
        ("ipc", "air_resistance", 1),
        ("ipc", "poisson_ratio", 0),
    ],
)
def test_stuff_that_a_derived_solver_leaves_out(tmp_path: Path, model: str, key: str, count: int) -> None:
    """If the case names the solver, the schema rejects these values already."""
    cloth = BODY.format("cloth", f"shape: {{kind: sheet, size: [0.5, 0.5]}}, material: {{{key}: 0.4}}")
    found = findings(tmp_path, "unheeded-stuff", cloth, f"scene: {{contact: {{model: {model}}}}}")
    assert [problem.path for problem in found] == [f"/bodies/a/material/{key}"] * count


@pytest.mark.parametrize(("model", "count"), [("particle", 0), ("sap", 1), ("ipc", 1)])
def test_a_contact_model_with_nothing_to_do(tmp_path: Path, model: str, count: int) -> None:
    ball = "bodies: {ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [0, 0, 0.5]}}}"
    found = findings(tmp_path, "unheeded-stuff", ball, f"scene: {{contact: {{model: {model}}}}}")
    assert [problem.path for problem in found] == ["/scene/contact/model"] * count


@pytest.mark.parametrize(("model", "count"), [("particle", 0), ("ipc", 1)])
def test_damping_of_free_bodies_that_another_solver_moves(tmp_path: Path, model: str, count: int) -> None:
    cloth = BODY.format("cloth", "shape: {kind: sheet, size: [0.5, 0.5]}")
    ball = "bodies: {ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [2, 0, 1]}, mount: {kind: free, damping: 1}}}"
    found = findings(tmp_path, "unheeded-stuff", cloth, ball, f"scene: {{contact: {{model: {model}}}}}")
    assert [problem.path for problem in found] == ["/bodies/ball/mount/damping"] * count


@pytest.mark.parametrize(("stiffness", "scene", "percent"), [
    (1e6, "{}", None),
    (1e6, "{dt: 0.01, substeps: 10}", None),
    (1e6, "{dt: 0.01, substeps: 10, pbd: {stretch_iterations: 4}}", 24),
    (1e9, "{}", 19),
])  # fmt: skip
def test_sheets_that_are_softer_than_their_material(
    tmp_path: Path, stiffness: float, scene: str, percent: int | None
) -> None:
    """`K w m c^2 / (2 h^2)` [N/m] is all that K sweeps of relaxation w = 0.3 reach in a substep h.

    With m = 1 kg/m2, cells c of 0.02 m and 4 sweeps in 1e-3 s that is 240 N/m; with 32 in 1e-4 s, 192,000 N/m.
    """
    sheet = "cell: 0.02, shape: {kind: sheet, size: [0.5, 0.5]}, "
    body = BODY.format("cloth", f"{sheet}material: {{area_density: 1, youngs_modulus: {stiffness}}}")
    found = findings(tmp_path, "unheeded-stuff", body, f"scene: {scene}")
    assert [problem.path for problem in found] == ["/bodies/a/material/youngs_modulus"] * (percent is not None)
    assert all(f"about {percent} % as stiff" in problem.message for problem in found), found


@pytest.mark.parametrize(("radius", "count"), [(0.005, 1), (0.02, 0)])
def test_creases_too_tight_for_the_cells(tmp_path: Path, radius: float, count: int) -> None:
    """An edge turns by pi at most, over one cell of 0.02 m."""
    sheet = f"cell: 0.02, shape: {{kind: sheet, size: [0.5, 0.5]}}, material: {{crease_radius: {radius}}}"
    found = findings(tmp_path, "unheeded-stuff", BODY.format("cloth", sheet))
    assert [problem.path for problem in found] == ["/bodies/a/material/crease_radius"] * count


def test_no_way_out_leads_under_the_floor(tmp_path: Path) -> None:
    table = "scene: {statics: {table: {shape: {kind: box, size: [1, 1, 0.4]}, place: {on: floor}}}}"
    sand = f"bodies: {{sand: {{kind: granular, {CUBE}, place: {{on: floor}}}}}}"
    (found,) = findings(tmp_path, "soft-inside", table, sand)
    assert "-z" not in found.message


@pytest.mark.parametrize(("felt", "count"), [("true", 1), ("false", 0)])
def test_only_links_that_are_felt_throw_out_what_starts_in_them(tmp_path: Path, felt: str, count: int) -> None:
    arm = (
        "bodies: {arm: {kind: articulated, base: fixed, pose: {pos: [0, 2, 1]}, links: {post: {shape: {kind: box, size: [0.1, 0.1, 0.1]}}, "
        "bar: {parent: post, shape: {kind: box, size: [0.1, 2, 0.1]}, pose: {pos: [0, -2, 0]}, joint: {kind: slider, axis: x}, "
        f"material: {{touch_soft: {felt}}}}}}}}}}}"
    )
    sheet = "bodies: {sheet: {kind: cloth, shape: {kind: sheet, size: [0.5, 0.5]}, pose: {pos: [0, 0, 1]}}}"
    assert len(findings(tmp_path, "soft-inside", arm, sheet)) == count


@pytest.mark.parametrize(("kind", "count"), [("soft", 0), ("cloth", 1)])
def test_a_reach_that_no_grid_heeds(tmp_path: Path, kind: str, count: int) -> None:
    shape = CUBE if kind == "soft" else "shape: {kind: sheet, size: [0.5, 0.5]}"
    wall = "scene: {statics: {wall: {shape: {kind: box, size: [1, 0.1, 1]}, material: {soft_reach: 0.01}, pose: {pos: [0, 2, 1]}}}}"
    found = findings(tmp_path, "unheeded-stuff", BODY.format(kind, shape), wall)
    assert [problem.path for problem in found] == ["/scene/statics/wall/material/soft_reach"] * count


@pytest.mark.parametrize(("more", "count"), [("", 0), ("bending_compliance: 1, ", 1)])
@pytest.mark.parametrize(("cell", "softer"), [(0.05, 0), (0.005, 1)])
def test_a_rigidity_that_substeps_do_not_reach(tmp_path: Path, more: str, count: int, cell: float, softer: int) -> None:
    sheet = f"cell: {cell}, shape: {{kind: sheet, size: [0.5, 0.5]}}, material: {{{more}rigidity: 0.01}}"
    found = findings(tmp_path, "unheeded-stuff", BODY.format("cloth", sheet))
    keys = ["bending_compliance"] * count + ["rigidity"] * softer
    assert sorted(problem.path for problem in found) == [f"/bodies/a/material/{key}" for key in keys]


def test_the_rigidity_that_substeps_reach_is_named(tmp_path: Path) -> None:
    sheet = "cell: 0.005, shape: {{kind: sheet, size: [0.5, 0.5]}}, material: {{rigidity: {}}}"
    (found,) = findings(tmp_path, "unheeded-stuff", BODY.format("cloth", sheet.format(0.01)))
    softer = found.message.rpartition("rigidity of ")[2]
    assert 0 < float(softer) < 0.005
    dt = "scene: {dt: 0.005, substeps: 10}"
    (found,) = findings(tmp_path, "unheeded-stuff", BODY.format("cloth", sheet.format(0.01)), dt)
    softer = found.message.rpartition("rigidity of ")[2]
    assert not findings(tmp_path, "unheeded-stuff", BODY.format("cloth", sheet.format(softer)), dt)
