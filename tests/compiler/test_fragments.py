"""`repeat: {kind: fragments}`: bodies that are cut so that they can shatter."""

import numpy as np
import pytest
from manifold3d import Manifold

from text2sim.compiler.build import resolve_case
from text2sim.compiler.masses import masses
from text2sim.compiler.shapes import cutting, geometry
from text2sim.compiler.shapes.inertials import combined_inertial, piece_inertial
from text2sim.compiler.shapes.rotation import quat_from_euler_deg
from text2sim.lint.facts import Facts
from text2sim.lint.rules import find_rule
from text2sim.spec_schema.errors import SpecError
from text2sim.spec_schema.load import load_text

CASE = """\
text2sim: 2
name: shards
scene: {{duration: 1, statics: {{floor: {{shape: {{kind: plane}}}}}}}}
bodies:
  pane:
    kind: {kind}
    shape: {shape}
    material: {{{material}}}
    pose: {{pos: [1, 2, 3], euler_deg: [0, 0, 90]}}
    repeat: {{kind: fragments, {cut}}}
{more}"""
PANE = "{kind: box, size: [0.6, 0.4, 0.008]}"
CUP = "{kind: cup, radius: 0.04, height: 0.1, thickness: 0.003}"


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


def resolved(folder, shape=PANE, cut="count: 20", kind="rigid", material="density: 2000", more=""):
    text = CASE.format(shape=shape, cut=cut, kind=kind, material=material, more=more)
    return resolve_case(load_text(text, folder / "case.yaml"))


def hulls(copies):
    """Convex pieces of each copy in the world, as solids."""
    found = []
    for copy in copies:
        turn = (
            np.array(geometry.quat_rotate(copy.quat, (1, 0, 0))),
            np.array(geometry.quat_rotate(copy.quat, (0, 1, 0))),
        )
        rows = np.array([*turn, np.cross(*turn)])
        found.append([
            Manifold.hull_points(np.array(piece.vertices) @ rows + np.array(copy.pos))
            for piece in geometry.pieces(copy.shape, None)
        ])  # fmt: skip
    return found


class TestCutting:
    @pytest.mark.parametrize(
        "shape",
        [
            PANE,
            "{kind: sphere, radius: 0.1}",
            "{kind: cone, radius: 0.1, height: 0.2}",
            "{kind: torus, radius: 0.1, bar_radius: 0.02}",
            "{kind: tube, outer_radius: 0.1, inner_radius: 0.09, height: 0.2}",
            CUP,
            "{kind: text, text: Hi, height: 0.2, depth: 0.05}",
            "{kind: compound, parts: {a: {shape: {kind: box, size: [0.2, 0.1, 0.1]}},"
            " b: {shape: {kind: cylinder, radius: 0.05, height: 0.2}, pose: {pos: [0, 0, 0.15]}},"
            " c: {shape: {kind: sphere, radius: 0.05}, pose: {pos: [0, 0, 0.3]}}}}",
        ],
    )
    def test_fragments_weigh_what_the_body_does(self, tmp_path, shape):
        resolution = resolved(tmp_path, shape)
        whole = geometry.volume(resolution.loaded.case.bodies["pane"].shape, tmp_path)
        assert sum(masses(resolution).values()) == pytest.approx(2000 * whole, rel=1e-3)
        assert sum(copy.shape.volume for copy in resolution.placed["pane"]) == pytest.approx(whole, rel=1e-3)

    def test_a_mass_is_that_of_all_together(self, tmp_path):
        assert sum(masses(resolved(tmp_path, CUP, material="mass: 0.2")).values()) == pytest.approx(0.2)

    def test_they_have_the_centre_and_inertia_of_the_body(self, tmp_path):
        resolution = resolved(tmp_path)
        copies = resolution.placed["pane"]
        links = (resolution.lowering.trees[copy.name].roots[0].inertial.at(copy.pos, copy.quat) for copy in copies)
        together = combined_inertial(list(links))
        body = resolution.loaded.case.bodies["pane"].shape
        whole = piece_inertial(geometry.pieces(body, tmp_path)[0], 2000).at((1, 2, 3), quat_from_euler_deg((0, 0, 90)))
        assert together.center == pytest.approx(whole.center, abs=1e-9)
        assert together.inertia == pytest.approx(whole.inertia, abs=1e-6 * max(whole.inertia))

    @pytest.mark.parametrize("shape", [PANE, CUP])
    def test_what_they_touch_with_does_not_overlap(self, tmp_path, shape):
        resolution = resolved(tmp_path, shape)
        solids = hulls(resolution.placed["pane"])
        least = min(copy.shape.volume for copy in resolution.placed["pane"])
        for k, own in enumerate(solids):
            for other in solids[:k]:
                assert sum((a ^ b).volume() for a in own for b in other) < 1e-6 * least
        rule = find_rule("overlap")
        assert rule is not None
        assert list(rule.run(Facts(resolution))) == []

    def test_shards_of_a_pane_are_as_thick_as_it_is(self, tmp_path):
        for copy in resolved(tmp_path).placed["pane"]:
            long, wide, thick = np.ptp(copy.shape.solid.vertices, axis=0)
            assert thick == pytest.approx(0.008)
            assert min(long, wide) > 0.05, "no slivers: a cell of 0.012 m2 is 0.11 m wide"

    def test_a_cup_keeps_its_hollow(self, tmp_path):
        solids = hulls(resolved(tmp_path, CUP, "count: 60").placed["pane"])
        inside = Manifold.cylinder(0.08, 0.03).translate((1, 2, 2.965))
        assert sum((piece ^ inside).volume() for own in solids for piece in own) < 0.02 * inside.volume()

    def test_a_cell_in_two_places_gives_two_fragments(self, tmp_path):
        bars = (
            "{kind: compound, parts: {a: {shape: {kind: box, size: [0.02, 0.5, 0.02]}, pose: {pos: [-0.03, 0, 0]}},"
            " b: {shape: {kind: box, size: [0.02, 0.5, 0.02]}, pose: {pos: [0.03, 0, 0]}}}}"
        )
        assert len(resolved(tmp_path, bars, "count: 2").placed["pane"]) == 4

    def test_fragments_are_smaller_near_the_focus(self, tmp_path):
        copies = resolved(tmp_path, cut="count: 60, focus: [0.2, 0.1, 0]").placed["pane"]
        # The pane is turned by 90 degrees about z.
        away = [np.hypot(copy.pos[0] - (1 - 0.1), copy.pos[1] - (2 + 0.2)) for copy in copies]
        assert away == sorted(away)
        sizes = [copy.shape.volume for copy in copies]
        assert np.mean(sizes[-10:]) > 8 * np.mean(sizes[:10])

    def test_stretched_cells_are_splinters(self, tmp_path):
        beam = "{kind: box, size: [0.1, 0.1, 0.4]}"
        copies = resolved(tmp_path, beam, "count: 20, stretch: [1, 1, 8]").placed["pane"]
        sides = np.array([np.ptp(copy.shape.solid.vertices, axis=0) for copy in copies])
        assert np.median(sides[:, 2] / sides[:, :2].max(axis=1)) > 3

    def test_the_same_seed_gives_the_same_fragments(self, tmp_path):
        def digests(cut):
            cutting._KNOWN.clear()
            return [copy.shape.solid.digest for copy in resolved(tmp_path, CUP, cut).placed["pane"]]

        first = digests("count: 12, seed: 4")
        for path in (tmp_path / "cache").rglob("*.answer"):
            path.unlink()
        assert digests("count: 12, seed: 4") == first
        assert digests("count: 12, seed: 5") != first

    def test_round_surfaces_stay_smooth_and_cuts_are_flat(self, tmp_path):
        for copy in resolved(tmp_path, "{kind: sphere, radius: 0.1}").placed["pane"]:
            solid = copy.shape.solid
            places = solid.vertices + (np.array(copy.pos) - (1, 2, 3)) @ np.array([(0, -1, 0), (1, 0, 0), (0, 0, 1)])
            radial = places / np.linalg.norm(places, axis=1, keepdims=True)
            outer = np.einsum("ij,ij->i", radial, solid.normals) > 0.999
            corners = solid.vertices[solid.faces]
            flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            size = np.linalg.norm(flat, axis=1)
            flat /= size[:, None]
            along = np.einsum("ij,ikj->ik", flat, solid.normals[solid.faces])
            cut = np.isclose(along, 1, atol=1e-5).all(axis=1)
            assert (cut | outer[solid.faces].all(axis=1))[size > 1e-9].all()
            assert outer.any()
            assert cut.any()

    def test_fragments_of_a_spinning_body_move_as_one(self, tmp_path):
        spin = (
            "actions: {controls: {spin: {kind: initial_velocity, body: pane, linear: [1, 0, 0], angular: [0, 0, 2]}}}\n"
        )
        resolution = resolved(tmp_path, more=spin)
        for copy, row in zip(resolution.placed["pane"], resolution.rows.velocities, strict=True):
            # v = u + w x r, about the centre of mass of the whole
            x, y, _ = np.subtract(copy.pos, (1, 2, 3))
            assert row.linear == pytest.approx((1 - 2 * y, 2 * x, 0), abs=1e-6)

    def test_a_ball_is_placed_inside_a_cup(self, tmp_path):
        ball = "  ball: {kind: rigid, shape: {kind: sphere, radius: 0.01}, place: {inside: pane}}\n"
        (ball,) = resolved(tmp_path, CUP, "count: 60", more=ball).placed["ball"]
        assert ball.pos == pytest.approx((1, 2, 3 - 0.05 + 0.003 + 0.01), abs=2e-3)


class TestErrors:
    @pytest.mark.parametrize(
        ("changes", "line", "said"),
        [
            ({"kind": "soft", "material": ""}, 10, "only a body of `kind: rigid` is cut into fragments"),
            ({"more": "    mount: {kind: hinge, axis: z}\n"}, 11, "fragments are free or fixed"),
            ({"cut": "count: 1000"}, 10, "must be from 2 to 200"),
            ({"shape": "{kind: mesh, file: open.obj}"}, 7, "its surface is open"),
            ({"shape": "{kind: box, size: ['${0.1 + i}', 1, 1]}"}, 7, "its `shape` differs in copy 1"),
            (
                {"shape": "{kind: compound, parts: {a: {shape: {kind: sphere, radius: 1}, density: 5}}}"},
                7,
                "part `a` cannot have a `density` of its own",
            ),
        ],
    )
    def test_what_cannot_be_cut_is_said_at_its_place(self, tmp_path, changes, line, said):
        (tmp_path / "open.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 4 2\n")
        with pytest.raises(SpecError) as caught:
            resolved(tmp_path, **changes)
        problem = caught.value.problems[0]
        assert said in problem.message
        assert problem.line == line


def test_contacts_of_fragments_last_four_milliseconds_at_most(tmp_path):
    found = resolved(tmp_path)
    assert found.settings.timeconst <= 0.004
    assert "fragments" in found.settings.why["substeps"]
