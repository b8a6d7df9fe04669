"""Mesh files that are open, inverted or coarse, and links of one body that overlap."""

from pathlib import Path

from lint_support import findings

MESH = "bodies: {{box: {{kind: rigid, shape: {{kind: mesh, file: {0}}}, pose: {{pos: [0, 0, 0.5]}}{1}}}}}"


class TestMeshes:
    def test_a_missing_side_is_counted(self, assets: Path) -> None:
        (found,) = findings(assets, "open-mesh", MESH.format("open.obj", ""))
        assert found.path == "/bodies/box/shape/file"
        assert "is open (4 edges do not join two triangles)" in found.message
        assert "0.008 m3" in found.message

    def test_what_has_a_mass_or_never_moves_may_be_open(self, assets: Path) -> None:
        assert findings(assets, "open-mesh", MESH.format("open.obj", ", material: {mass: 1}")) == []
        assert findings(assets, "open-mesh", MESH.format("open.obj", ", mount: {kind: fixed}")) == []
        still = "scene: {statics: {box: {shape: {kind: mesh, file: open.obj}, pose: {pos: [2, 0, 1]}}}}"
        assert findings(assets, "open-mesh", still, MESH.replace("box:", "other:").format("closed.obj", "")) == []

    def test_each_fault_has_its_own_name(self, assets: Path) -> None:
        assert findings(assets, "open-mesh", MESH.format("inverted.obj", "")) == []
        assert len(findings(assets, "inside-out-mesh", MESH.format("inverted.obj", ""))) == 1
        assert findings(assets, "inside-out-mesh", MESH.format("open.obj", "")) == []
        for rule in ("open-mesh", "inside-out-mesh", "slow-mesh"):
            assert findings(assets, rule, MESH.format("closed.obj", "")) == []

    def test_parts_of_a_compound(self, assets: Path) -> None:
        parts = "parts: {a: {shape: {kind: mesh, file: open.obj}}, b: {shape: {kind: sphere, radius: 0.1}}}"
        body = f"bodies: {{c: {{kind: rigid, shape: {{kind: compound, {parts}}}, pose: {{pos: [0, 0, 1]}}}}}}"
        (found,) = findings(assets, "open-mesh", body)
        assert found.path == "/bodies/c/shape/parts/a/shape/file"

    def test_walls_take_two_cells(self, assets: Path) -> None:
        """The bar of the ring is 80 mm thick."""
        ring = MESH.format("ring.obj, collision: exact, cell: %g", "")
        assert findings(assets, "coarse-field", ring % 0.035) == []
        (found,) = findings(assets, "coarse-field", ring % 0.06)
        assert (found.severity, found.path) == ("warning", "/bodies/box/shape/cell")
        assert findings(assets, "coarse-field", ring % 0.09)[0].severity == "error"

    def test_one_hollow_mesh_is_reason_enough_for_exact_contact(self, assets: Path) -> None:
        crate = MESH.format("closed.obj, collision: exact", "")
        assert len(findings(assets, "convex-exact", crate)) == 1
        ring = MESH.replace("box:", "ring:").format("ring.obj, collision: exact", "").replace("0.5]", "5]")
        assert findings(assets, "convex-exact", crate, ring) == []

    def test_a_surface_of_many_triangles_has_vertices_everywhere(self, assets: Path) -> None:
        assert findings(assets, "few-vertices", MESH.format("ring.obj, collision: exact", "")) == []
        (found,) = findings(assets, "few-vertices", MESH.format("channel.obj, collision: exact", ""))
        assert found.path == "/bodies/box/shape/collision"

    def test_only_what_is_taken_apart_is_slow(self, assets: Path) -> None:
        assert findings(assets, "slow-mesh", MESH.format("fine.obj", "")) == []


class TestSelfOverlap:
    ARM = """\
bodies:
  arm:
    kind: articulated
    self_collision: %s
    initial: {lower: %s}
    links:
      base: {shape: {kind: box, size: [0.1, 0.1, 0.1]}, pose: {pos: [0, 0, 1]}}
      upper: {parent: base, shape: {kind: box, size: [0.04, 0.04, 0.4]}, pose: {pos: [0, 0, 0.25]},
              joint: {kind: hinge, axis: y, anchor: [0, 0, -0.2]}}
      lower: {parent: upper, shape: {kind: box, size: [0.04, 0.04, %s]}, pose: {pos: [0.05, 0, 0]},
              joint: {kind: hinge, axis: y, anchor: [0, 0, 0.2]}}
"""

    def test_neighbours_do_not_count(self, tmp_path: Path) -> None:
        assert findings(tmp_path, "self-overlap", self.ARM % ("true", 0, 0.3)) == []

    def test_overlap_at_zero_is_never_seen_by_the_engine(self, tmp_path: Path) -> None:
        (found,) = findings(tmp_path, "self-overlap", self.ARM % ("true", 0, 0.5))
        assert found.path == "/bodies/arm/self_collision"
        assert "`arm.base` and `arm.lower` overlap by" in found.message
        assert "never collide" in found.message

    def test_overlap_at_the_start_pushes(self, tmp_path: Path) -> None:
        slider = (self.ARM % ("true", -0.1, 0.3)).replace("hinge, axis: y, anchor: [0, 0, 0.2]", "slider, axis: z")
        (found,) = findings(tmp_path, "self-overlap", slider)
        assert found.path == "/bodies/arm/initial"
        assert "m/s" in found.message

    def test_without_self_collision_links_pass_through_each_other_anyway(self, tmp_path: Path) -> None:
        assert findings(tmp_path, "self-overlap", self.ARM % ("false", 0, 0.5)) == []
