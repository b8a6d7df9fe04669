"""Parts of a body that deforms keep their looks: which triangle has whose."""

from io import BytesIO
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from text2sim.compiler.build import plan_case
from text2sim.compiler.digests import render_digest, sim_digest
from text2sim.compiler.emit import emit
from text2sim.compiler.plan import Plan
from text2sim.spec_schema.load import load_text
from text2sim.templates.shading import part_of_triangles

SCULPT = """
      kind: sculpt
      parts:
        trunk: {kind: ellipsoid, radii: [0.12, 0.09, 0.08]}
        head: {kind: ellipsoid, radii: [0.05, 0.05, 0.05], pose: {pos: [0, 0, 0.12]}, look: {color: orange}}
        belly: {kind: box, size: [0.3, 0.3, 0.05], op: paint, pose: {pos: [0, 0, -0.065]}, look: {color: %s}}
"""
COMPOUND = """
      kind: compound
      parts:
        stick: {shape: {kind: cylinder, radius: 0.03, height: 0.2}}
        top: {shape: {kind: sphere, radius: 0.08}, pose: {pos: [0, 0, 0.12]}, look: {color: red}}
"""
CASE = """
text2sim: 2
name: toy
scene: {duration: 0.1, statics: {floor: {shape: {kind: plane}}}}
bodies:
  toy:
    kind: soft
    solver: %s
    cell: 0.03
    shape: %s
    pose: {pos: [0.5, 0, 0.4], euler_deg: [0, 20, 30]}
"""


def planned(shape: str, solver: str = "mpm") -> Plan:
    return plan_case(load_text(CASE % (solver, shape), Path("case.yaml")))


def labelled(plan: Plan) -> tuple[np.ndarray, np.ndarray]:
    """Centers of triangles [m] and the parts whose looks they have."""
    with np.load(BytesIO(plan.files["models/toy_looks.npz"])) as file:
        return file["centers"], file["parts"]


@pytest.mark.parametrize("solver", ["mpm", "fem"])
def test_a_triangle_has_the_look_of_the_part_that_it_lies_on(solver: str) -> None:
    centers, parts = labelled(planned(SCULPT % "white", solver))
    edge = 0.02 if solver == "mpm" else 0.03  # those of fem are melted together across the borders
    assert (parts[centers[:, 2] < -0.04 - edge] == 2).all(), "the belly is painted up to z = -0.04"
    assert (parts[(centers[:, 2] > -0.04 + edge) & (centers[:, 2] < 0.05)] == -1).all()
    assert (parts[centers[:, 2] > 0.13] == 1).all()


def test_borders_of_paint_are_edges_of_the_surface() -> None:
    """Else the border would be as jagged as the triangles are large."""
    centers, parts = labelled(planned(SCULPT % "white"))
    assert centers[parts == 2][:, 2].max() < -0.038
    assert centers[parts == -1][:, 2].min() > -0.042


def test_parts_of_a_compound_keep_theirs() -> None:
    centers, parts = labelled(planned(COMPOUND))
    assert (parts[centers[:, 2] > 0.07] == 1).all()
    assert (parts[centers[:, 2] < 0.0] == -1).all()


def test_a_turned_body_is_painted_as_it_was_turned() -> None:
    from scipy.spatial.transform import Rotation

    plan = planned(SCULPT % "white")
    centers, parts = labelled(plan)
    pos, turn = np.array([0.5, 0, 0.4]), Rotation.from_euler("xyz", [0, 20, 30], degrees=True)
    vertices = turn.apply(np.repeat(centers, 3, axis=0)) + pos
    faces = np.arange(len(vertices)).reshape(-1, 3)[::-1]
    file = BytesIO(plan.files["models/toy_looks.npz"])
    found = part_of_triangles(file, vertices, faces, pos, turn.as_quat(scalar_first=True))  # type: ignore[arg-type]
    assert (found == parts[::-1]).all(), "in whatever order a solver has them"


def test_another_colour_is_another_film_and_no_other_simulation() -> None:
    white, black = planned(SCULPT % "white"), planned(SCULPT % "black")
    assert sim_digest(white) == sim_digest(black)
    assert render_digest(white) != render_digest(black)
    assert b'"parts": [null, {"color": [1.0, 0.6471, 0.0]' in emit(white)["looks.json"]


def test_an_invisible_part_touches_and_is_not_drawn() -> None:
    text = """
text2sim: 2
name: tank
scene:
  duration: 0.1
  statics:
    tank:
      shape:
        kind: compound
        parts:
          wall: {shape: {kind: box, size: [0.1, 1, 1]}, pose: {pos: [-0.05, 0, 0]}, look: {visible: false}}
          pane: {shape: {kind: box, size: [0.01, 1, 1]}, pose: {pos: [-0.005, 0, 0]}, look: {finish: glass}, decor: true}
          frame: {shape: {kind: box, size: [0.1, 1, 0.1]}, pose: {pos: [-0.05, 0, 0.6]}}
          hidden: {shape: {kind: sphere, radius: 0.1}, decor: true, look: {visible: false}}
bodies: {ball: {kind: rigid, shape: {kind: sphere, radius: 0.1}, pose: {pos: [2, 0, 1]}}}
"""
    plan = plan_case(load_text(text, Path("case.yaml")))
    model = ElementTree.fromstring(plan.files["models/tank.xml"])
    geoms = [(geom.get("name"), geom.get("group"), geom.get("contype")) for geom in model.iter("geom")]
    assert [name for name, _, contype in geoms if contype == "1"] == ["tank_0@wall", "tank_1@frame"]
    assert sum(group == "2" for _, group, _ in geoms) == 2, "the pane and the frame are drawn"
    assert len(plan.entities[0].part_surfaces["tank"]) == 2
