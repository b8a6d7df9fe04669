"""The grid by which a mesh touches exactly: its cells, its walls, its bounds."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh

from text2sim.compiler.build import compile_case
from text2sim.compiler.plan import Plan
from text2sim.compiler.shapes import distance_field
from text2sim.compiler.shapes.distance_field import field_of, wall_of
from text2sim.spec_schema.errors import AssetError, SpecError
from text2sim.spec_schema.load import load_case

WALL = 0.01
FEM = "  gum: {kind: soft, solver: fem, shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [0, 0, 2]}}\n"


def shell() -> trimesh.Trimesh:
    """A cube of 0.2 m with a hollow inside, and so with walls of 10 mm."""
    outer, inner = trimesh.creation.box((0.2,) * 3), trimesh.creation.box((0.2 - 2 * WALL,) * 3)
    inner.invert()
    return trimesh.Trimesh(
        np.vstack([outer.vertices, inner.vertices]), np.vstack([outer.faces, inner.faces + len(outer.vertices)])
    )


def arrays(mesh: trimesh.Trimesh) -> tuple[np.ndarray, np.ndarray]:
    return np.array(mesh.vertices), np.array(mesh.faces)


def test_walls_are_measured_across() -> None:
    assert wall_of(*arrays(shell())) == pytest.approx(WALL, rel=1e-3)
    plank = trimesh.creation.box((1.0, 0.5, 0.02))
    assert wall_of(*arrays(plank)) == pytest.approx(0.02, rel=1e-3)


def test_cells_follow_the_walls_between_a_95th_and_a_127th_of_the_grid() -> None:
    field = field_of(*arrays(shell()), None)
    assert field.wall == pytest.approx(WALL, rel=1e-3)
    side = 0.2 * 1.2
    assert field.cell == pytest.approx(side / 95)
    assert field.nodes == (96, 96, 96)
    thin = field_of(*arrays(trimesh.creation.box((0.2, 0.2, 0.003))), None)
    assert thin.cell == pytest.approx(side / 127)
    # Along the thin side, as along the others, no cell is larger than half of the wall if 128 nodes allow.
    assert thin.nodes[0] == 128
    assert (thin.nodes[2] - 1) * 0.0015 >= 0.003 + 0.04 - 1e-9


def test_a_field_that_is_too_large_names_the_least_cell() -> None:
    with pytest.raises(
        AssetError, match=r"a field of 2,401 x 2,401 x 2,401 nodes, and 4,000,000 .* take ([0-9.]+) m"
    ) as raised:
        field_of(*arrays(shell()), 1e-4)
    least = float(str(raised.value).split("take ")[1].split(" m")[0])
    assert np.prod(field_of(*arrays(shell()), least).nodes) <= distance_field.MOST_NODES


def test_a_mesh_of_very_many_triangles_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(distance_field, "MOST_TRIANGLES", 10)
    with pytest.raises(AssetError, match="has 24 triangles, and exact contact takes 10 at most"):
        field_of(*arrays(shell()), None)


@pytest.fixture
def make(tmp_path: Path) -> Callable[..., Plan]:
    """Compile a case with a shell and whatever else, and say what the plan is."""
    shell().export(tmp_path / "shell.obj")
    box = trimesh.creation.box((0.2, 0.2, 0.2))
    trimesh.Trimesh(box.vertices, box.faces[2:]).export(tmp_path / "open.obj")

    def compiled(shape: dict[str, object], scene: str = "scene: {duration: 1}", more: str = "") -> Plan:
        body = {"kind": "rigid", "shape": {"kind": "mesh", **shape}, "pose": {"pos": [0, 0, 1]}}
        text = f"text2sim: 1\nname: t\n{scene}\nbodies:\n  m: {json.dumps(body)}\n{more}"
        (tmp_path / "case.yaml").write_text(text)
        return compile_case(load_case(tmp_path), tmp_path / "program")

    return compiled


class TestExactMeshes:
    def test_the_engine_gets_the_surface_and_its_grid(self, make: Callable[..., Plan], tmp_path: Path) -> None:
        plan = make({"file": "shell.obj", "collision": "exact", "cell": 0.004})
        (entity,) = plan.bodies[0].entities
        assert entity.options["contact"] == "exact"
        assert entity.material_options == {"sdf_cell_size": 0.004, "sdf_min_res": 16, "sdf_max_res": 61}
        program = (tmp_path / "program" / "bodies.py").read_text()
        assert "convexify=False" in program
        assert "sdf_cell_size=0.004" in program
        assert any("61 x 61 x 61 nodes" in note for note in plan.notes)

    def test_an_open_surface_has_no_inside(self, make: Callable[..., Plan]) -> None:
        with pytest.raises(SpecError, match="`open.obj` is open") as raised:
            make({"file": "open.obj", "collision": "exact"})
        assert raised.value.problems[0].path == "/bodies/m/shape/file"

    def test_a_cell_belongs_to_exact_contact(self, make: Callable[..., Plan]) -> None:
        with pytest.raises(SpecError, match="cell needs collision: exact"):
            make({"file": "shell.obj", "cell": 0.004})

    def test_contact_models_of_volumes_have_none(self, make: Callable[..., Plan]) -> None:
        with pytest.raises(SpecError, match="contact model `sap` has no `collision: exact`"):
            make({"file": "shell.obj", "collision": "exact"}, "scene: {duration: 1, contact: {model: sap}}", FEM)
