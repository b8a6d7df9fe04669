"""What parts look like: finishes of parts and links, dark glass, ground that fades."""

import json
from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
import trimesh

from text2sim.compiler.build import plan_case
from text2sim.compiler.emit import ENGINE_FINISHES, emit
from text2sim.drawing.surfaces import GLOSS
from text2sim.recording.film_record import Cut, SurfaceLook, WornMesh, _looks_of_pieces
from text2sim.rendering.backdrop import backdrop_mesh, clearness, haze_distance
from text2sim.rendering.decorating import decorated, drift
from text2sim.rendering.finishes import FINISHES, _pattern, drawn_finish
from text2sim.rendering.meshes import RenderMesh, boxed_uvs
from text2sim.rendering.rigid import _grained, _pattern_rates, _rim, narrow_sides
from text2sim.rendering.scene import texture_scale
from text2sim.spec_schema.load import load_case
from text2sim.spec_schema.models.materials import Finish
from text2sim.templates.patterns import Decoration

CASE = """
text2sim: 2
name: lamp
scene: {duration: 0.1}
bodies:
  lamp:
    kind: articulated
    base: fixed
    links:
      foot: {shape: {kind: box, size: [0.2, 0.2, 0.1]}, look: {color: walnut, finish: wood}}
      arm:
        parent: foot
        shape:
          kind: compound
          parts:
            rod: {shape: {kind: box, size: [0.02, 0.02, 0.4]}, pose: {pos: [0, 0, 0.25]}}
            bulb: {shape: {kind: sphere, radius: 0.05}, pose: {pos: [0, 0, 0.5]}, look: {color: "#eef6ff", finish: glass}}
        joint: {kind: hinge, axis: y}
        look: {color: steel, finish: brushed_metal}
"""
RED, GREY = (1.0, 0.0, 0.0), (0.5, 0.5, 0.5)


def look(color: tuple[float, float, float], finish: str) -> dict[str, object]:
    return {"color": color, "opacity": 1.0, "finish": finish}


def test_links_and_parts_keep_their_finishes(tmp_path: Path) -> None:
    path = tmp_path / "case.yaml"
    path.write_text(CASE)
    looks = json.loads(emit(plan_case(load_case(path)))["looks.json"])
    worn = {
        link: {looks["lamp"]["looks"][k]["finish"] for k in numbers} for link, numbers in looks["lamp"]["links"].items()
    }
    assert worn == {"foot": {"wood"}, "arm": {"glass", "brushed_metal"}}, "and no look that none wears"
    (glass,) = (row for row in looks["lamp"]["looks"] if row["finish"] == "glass")
    assert np.allclose(glass["color"], np.array([0xEE, 0xF6, 0xFF]) / 255, atol=1e-4)


def test_recorded_parts_find_their_looks_whatever_the_colours_are() -> None:
    red, grey = look(RED, "wood"), look(GREY, "cloth")
    looks = {"looks": [red, grey, None], "links": {"bed": [0, 1, 0], "cab": [2]}}
    assert _looks_of_pieces(looks, "bed", 3) == [red, grey, red]
    assert _looks_of_pieces(looks, "cab", 1) == [None], "a mesh in colours of its own keeps them"
    assert _looks_of_pieces(looks, "bed", 2) == [None, None], "another body was recorded"
    assert _looks_of_pieces(grey, "bed", 2) == [grey, grey], "one look is that of all parts"


def test_parts_of_one_colour_are_told_apart_by_finish(tmp_path: Path) -> None:
    path = tmp_path / "case.yaml"
    path.write_text(CASE.replace('look: {color: "#eef6ff", finish: glass}', "look: {color: steel, finish: rubber}"))
    looks = json.loads(emit(plan_case(load_case(path)))["looks.json"])["lamp"]
    assert {looks["looks"][k]["finish"] for k in looks["links"]["arm"]} == {"brushed_metal", "rubber"}


@pytest.mark.parametrize("finish", get_args(Finish))
def test_every_finish_has_its_surface_in_each_renderer(finish: str) -> None:
    tables = {"rendering/finishes.py": FINISHES, "compiler/emit.py": ENGINE_FINISHES, "drawing/surfaces.py": GLOSS}
    assert [file for file, table in tables.items() if finish not in table] == [], "a row is missing there"


def test_dark_glass_is_not_clear() -> None:
    assert FINISHES[drawn_finish("glass", (0.2, 0.4, 0.2))].kind == "tinted"
    assert FINISHES[drawn_finish("glass", (0.8, 0.9, 1.0))].kind == "clear"
    assert FINISHES[drawn_finish("smooth", (0.2, 0.4, 0.2), 0.4)].kind == "clear"
    assert drawn_finish("smooth", (0.2, 0.4, 0.2), 0.5) == "smooth"
    assert drawn_finish("metal", (0.2, 0.4, 0.2), 0.4) == "metal"
    assert drawn_finish("wood", (0.2, 0.1, 0.1)) == "wood"


def test_ground_without_an_end_fades_before_it_ends() -> None:
    # From above: sky, the edge of the ground, where few samples meet it, far ground, near ground.
    depth = np.array([0.0, 20.0, 600.0, 10.0, 3.0])[:, None] * np.ones((1, 3))
    alpha = np.array([0.0, 0.03, 1.0, 1.0, 1.0])[:, None] * np.ones((1, 3))
    seen = clearness(1.2 * 14.0, depth, alpha)[:, 1]
    assert seen[4] > 0.99, "what the film is about is seen as it is"
    assert seen[4] > seen[3] > 0.8
    assert (seen[1:3] < 1e-6).all(), "the edge is as far as what it is the edge of"
    assert (clearness(0.0, depth, alpha) == 1).all()


def test_ground_without_an_end_ends_where_it_is_not_seen_any_more() -> None:
    backdrop = {"kind": "horizon", "level": 0.0, "center": (1.0, 2.0, 0.0), "radius": 5.0}
    eyes = [np.array([1.0, -4.0, 1.5]), np.array([9.0, 2.0, 3.0])]
    haze = haze_distance(backdrop, eyes[0], np.zeros((0, 3)))
    ground = backdrop_mesh(backdrop, eyes, haze=haze)
    assert ground is not None
    rim = np.hypot(*(ground.vertices[:, :2] - backdrop["center"][:2]).T)
    edge = ground.vertices[rim > rim.max() * 0.999]
    for eye in eyes:
        depth = np.linalg.norm(edge - eye, axis=1)[:, None]
        assert clearness(haze, depth, np.ones_like(depth)).max() < 0.01


def test_bodies_far_from_the_camera_are_not_lost_in_haze() -> None:
    backdrop, eye = {"kind": "horizon", "radius": 3.0}, np.array([0.0, -8.0, 1.0])
    assert haze_distance(backdrop, eye, np.array([[0.0, -5.0, 0.0]])) == pytest.approx(2.5 * 10**0.5)
    haze = haze_distance(backdrop, eye, np.array([[0.0, 2.0, 1.0]]))
    assert clearness(haze, np.array([[10.0]]), np.ones((1, 1))).min() > 0.95
    assert haze_distance(backdrop, eye, np.array([[0.0, 1000.0, 1.0]])) == pytest.approx(6 * 1.2 * 3.0)
    assert haze_distance(backdrop | {"kind": "wall"}, eye, np.zeros((1, 3))) == 0.0


def test_the_wall_stands_behind_cameras_that_others_look_at() -> None:
    """On its open side nothing stands in the way; a camera that goes round needs all of the wall, and room."""
    backdrop = {"kind": "cyclorama", "level": 0.0, "center": (0.0, 0.0, 0.0), "radius": 8.0}
    still = backdrop_mesh(backdrop, [np.array([0.0, -20.0, 1.0])])
    angle = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    round_about = backdrop_mesh(backdrop, [np.array([20 * np.cos(a), 20 * np.sin(a), 1.0]) for a in angle])
    assert still is not None
    assert round_about is not None
    walls = [mesh.vertices[np.unique(mesh.faces)] for mesh in (still, round_about)]
    walls = [wall[wall[:, 2] > 0.1] for wall in walls]
    assert walls[0][:, 1].min() > -3, "nothing between a still camera and what it looks at"
    assert np.hypot(*walls[0][:, :2].T).max() < 8
    assert np.hypot(*walls[1][:, :2].T).min() > 20, "and none of it before a camera that goes round"


def test_no_camera_sees_the_ends_of_the_wall() -> None:
    backdrop, eye = (
        {"kind": "cyclorama", "level": 0.0, "center": (0.0, 0.0, 0.0), "radius": 0.5},
        np.array([0, -4.0, 1]),
    )
    for degrees, outside in ((3.0, True), (20.0, False)):
        side = np.radians(degrees)
        rays = np.array([[0.0, 1.0, -0.2], [-np.sin(side), np.cos(side), 0.0], [np.sin(side), np.cos(side), 0.0]])
        room = backdrop_mesh(backdrop, [eye], [rays])
        assert room is not None
        assert (np.hypot(*room.vertices[:, :2].T).max() < 4) == outside, f"{degrees} degrees to each side"


def test_textures_are_finer_in_small_scenes_and_never_show_their_texels() -> None:
    assert [texture_scale(radius) for radius in (0.1, 1.0, 5.0)] == [0.2, 0.5, 1.0]
    for name in ("specks", "clouds", "grain"):
        # Neighbouring texels of a band-limited texture differ little compared to its contrast.
        values = _pattern(name)
        step = np.abs(np.diff(values, axis=0)).mean()
        assert step < 0.6 * values.std(), name  # white noise: 1.13


def box(*size: float) -> RenderMesh:
    made = trimesh.creation.box(size)
    return RenderMesh(np.array(made.vertices), np.array(made.faces), np.array(made.vertex_normals))


def test_panes_of_clear_glass_have_sides_that_show_and_other_glass_has_none() -> None:
    pane = narrow_sides(box(0.6, 0.02, 0.4))
    assert pane is not None
    corners = pane.vertices[pane.faces]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum() / 2
    assert area == pytest.approx(2 * 0.02 * (0.6 + 0.4)), "all sides but the broad ones"
    assert narrow_sides(box(0.3, 0.2, 0.4)) is None, "a block"
    ball = trimesh.creation.icosphere(3)
    flat = np.array(ball.vertices) * (1, 1, 0.1)
    assert narrow_sides(RenderMesh(flat, np.array(ball.faces), flat)) is None, "a lens"


def test_fragments_have_the_texture_and_the_edges_of_the_whole() -> None:
    whole, half = boxed_uvs(box(0.6, 0.02, 0.4)), box(0.3, 0.02, 0.4)
    cut = Cut((-0.15, 0.0, 0.0), (-0.3, -0.01, -0.2), (0.3, 0.01, 0.2))
    look = SurfaceLook((1.0, 1.0, 1.0), 1.0, "wood", True, None, None)
    part = WornMesh("pane[0]", 0, Path("half"), (0.0, 0.0, 0.0), (np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)), look)
    turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    mesh = RenderMesh(half.vertices @ turn, half.faces, half.normals @ turn)
    grained = _grained(mesh, part, cut)
    placed = grained.vertices @ turn.T + cut.place
    assert whole.uvs is not None
    assert grained.uvs is not None
    for place, uv in zip(whole.vertices, whole.uvs, strict=True):
        same = np.abs(placed - place).max(axis=1) < 1e-9
        assert place[0] > 0 or np.abs(grained.uvs[same] - uv).max(axis=1).min() < 1e-9
    edge = _rim(mesh, part, cut)
    assert edge is not None
    middles = (edge.vertices @ turn.T + cut.place)[edge.faces].mean(axis=1)
    assert len(middles) == 6
    assert middles[:, 0].max() < -0.05, "where it was cut is no edge of the pane"


@pytest.mark.parametrize("turned", [False, True])
def test_a_repeating_pattern_moves_with_the_surface(turned: bool) -> None:
    """What is seen at p after a time t was seen at p - v t: its texture coordinates fall at their slope times v."""
    velocity = np.array([0.5, 0.0, 0.0])
    whole = trimesh.creation.box((2.0, 0.4, 0.1))
    vertices, normals = whole.vertices[whole.faces].reshape(-1, 3), np.repeat(whole.face_normals, 3, axis=0)
    block = RenderMesh(np.array(vertices), np.arange(len(vertices)).reshape(-1, 3), normals)
    mesh, layer, _ = decorated(block, Decoration("stripes", 0.1, turned=turned), (0.2, 0.2, 0.2), np.eye(3))
    rates = drift(mesh, velocity)
    assert mesh.uvs is not None
    for axis, side in ((2, 0.05), (1, -0.2)):
        on = np.flatnonzero((np.abs(mesh.vertices[:, axis] - side) < 1e-9) & (np.abs(mesh.normals[:, axis]) > 0.9))
        first = on[mesh.vertices[on, 0].argmin()]
        across = mesh.vertices[on, 3 - axis] == mesh.vertices[first, 3 - axis]
        last = on[across][mesh.vertices[on[across], 0].argmax()]
        slope = (mesh.uvs[last] - mesh.uvs[first]) / (mesh.vertices[last, 0] - mesh.vertices[first, 0])
        assert np.abs(slope).max() == pytest.approx(1, abs=0.1)
        assert np.allclose(rates[on], -slope * velocity[0]), "the pattern moves with the surface, and is not distorted"
    ends = np.abs(mesh.normals[:, 0]) > 0.9
    assert np.abs(rates[ends]).max() < 1e-9, "across the ends nothing moves"
    belt = WornMesh("belt", 0, Path("belt"), (0.0,) * 3, (1.0, 0.0, 0.0, 0.0), SurfaceLook((0.2,) * 3), tuple(velocity))
    assert np.allclose(_pattern_rates(mesh, belt, layer), rates)
    assert not _pattern_rates(mesh, belt, replace(layer, unit=None)).any(), "a label stays where it is"
