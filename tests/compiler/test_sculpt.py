"""Sculpted shapes against the volumes, areas and moments of what they stand for, and their limits."""

import math
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from text2sim.compiler.build import resolve_case
from text2sim.compiler.shapes import geometry
from text2sim.compiler.shapes.distances import round_cone
from text2sim.compiler.shapes.extents import extents
from text2sim.compiler.shapes.levelset import MAX_NODES, fillet, grid_of, placed_parts
from text2sim.compiler.shapes.sculpting import sculpted
from text2sim.compiler.shapes.softmesh import soft_surface
from text2sim.compiler.trees.tree import tree_pieces
from text2sim.spec_schema.errors import AssetError, SpecError
from text2sim.spec_schema.load import load_text
from text2sim.spec_schema.models.sculpts import Sculpt
from text2sim.spec_schema.published.reference_prose import SCULPT

BALL = {"kind": "ellipsoid", "radii": [0.1, 0.1, 0.1]}


def sculpt(blend: float = 0.0, detail: float | None = None, collision: str = "parts", **parts: Any) -> Sculpt:
    return Sculpt.model_validate(
        {"kind": "sculpt", "parts": parts, "blend": blend, "detail": detail, "collision": collision}
    )


@pytest.mark.parametrize(
    ("part", "volume"),
    [
        ({"kind": "ellipsoid", "radii": [0.1, 0.06, 0.04]}, 4 / 3 * math.pi * 0.1 * 0.06 * 0.04),
        # A box of a, b, c rounded by r: the inner box, its slabs, quarter cylinders and eighths of a ball.
        (
            {"kind": "box", "size": [0.2, 0.1, 0.1], "rounding": 0.03},
            0.14 * 0.04 * 0.04 + 2 * 0.03 * (2 * 0.14 * 0.04 + 0.04 * 0.04) + math.pi * 0.03**2 * 0.22
            + 4 / 3 * math.pi * 0.03**3,
        ),
        ({"kind": "limb", "points": [[0, 0, 0], [0.2, 0, 0]], "radii": 0.04}, math.pi * 0.04**2 * (0.2 + 4 / 3 * 0.04)),
        ({"kind": "revolve", "profile": [[0.1, 0], [0, 0.2]]}, math.pi * 0.1**2 * 0.2 / 3),
        # Pappus: the area of the profile times the way of its middle.
        (
            {"kind": "revolve", "closed": True, "profile": [[0.08, 0], [0.12, 0], [0.12, 0.04], [0.08, 0.04]]},
            0.04**2 * 2 * math.pi * 0.1,
        ),
        ({"kind": "loft", "sections": [{"at": 0, "size": [0.1, 0.06]}, {"at": 0.2, "size": [0.1, 0.06]}]},
         math.pi * 0.05 * 0.03 * 0.2),
    ],
    ids=["ellipsoid", "box", "limb", "cone", "ring", "loft"],
)  # fmt: skip
def test_each_part_encloses_what_its_formula_says(part: dict[str, Any], volume: float) -> None:
    made = sculpted(sculpt(part=part))
    # Marching cubes cuts corners: by the square of a cell over the radius of what it cuts, and at edges by half a cell.
    assert made.volume == pytest.approx(volume, rel=0.02)
    edges = np.sort(made.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()


def test_mass_properties_are_those_of_the_solid() -> None:
    made = sculpted(sculpt(egg={"kind": "ellipsoid", "radii": [0.1, 0.06, 0.04], "pose": {"pos": [0.3, 0, 0.1]}}))
    assert made.center == pytest.approx((0.3, 0, 0.1), abs=2e-4)
    # I = m (b2 + c2) / 5
    of = made.volume / 5
    wanted = (of * (0.06**2 + 0.04**2), of * (0.1**2 + 0.04**2), of * (0.1**2 + 0.06**2))
    assert made.inertia[:3] == pytest.approx(wanted, rel=0.02)
    assert made.inertia[3:] == pytest.approx((0, 0, 0), abs=0.002 * wanted[0])


def test_a_round_cone_is_the_hull_of_its_balls() -> None:
    a, b = np.zeros(3), np.array([0.0, 0, 1])
    p = np.array([(0, 0, -1), (0, 0, 2), (0.5, 0, 0.5)], float)
    # On the side: the tangent of both balls, whose slope is the difference of the radii over their distance.
    lean = math.asin(0.2)
    side = 0.5 * math.cos(lean) - 0.5 * math.sin(-lean) - 0.3
    assert round_cone(p, a, b, 0.3, 0.1) == pytest.approx([0.7, 0.9, side])


def test_a_fillet_has_its_radius_and_ends_where_it_should() -> None:
    r = 0.1
    # Between two walls, a = 0 and b = 0, the circle about (r, r).
    t = np.linspace(0, math.pi / 2, 7)
    assert fillet(r - r * np.cos(t), r - r * np.sin(t), r) == pytest.approx(np.zeros(7), abs=1e-12)
    assert fillet(np.array([0.02]), np.array([0.3]), r) == pytest.approx([0.02])
    arm = {"kind": "box", "size": [0.04, 0.04, 0.3]}
    plain = sculpt(base={"kind": "box", "size": [0.3, 0.3, 0.08]}, arm=arm)
    # Around the foot, on both sides: a spandrel of area A along four sides, and turned by 90 deg at each corner, where
    # its centroid goes round at 0.2234 r (Pappus).
    foot, s = 0.04, 0.02
    spandrel = (1 - math.pi / 4) * s**2
    wanted = 2 * spandrel * (4 * foot + 2 * math.pi * 0.2234 * s)
    added = sculpted(plain.model_copy(update={"blend": s})).volume - sculpted(plain).volume
    assert added == pytest.approx(wanted, rel=0.1)


def test_mirrored_parts_are_mirror_images_and_do_not_swell() -> None:
    made = sculpted(sculpt(0.03, trunk=BALL, ear={**BALL, "pose": {"pos": [0, 0.12, 0.05]}, "mirror": "y"}))
    assert made.vertices[:, 1].max() == pytest.approx(-made.vertices[:, 1].min(), abs=1e-3)
    alone = sculpted(sculpt(0.03, trunk={**BALL, "mirror": "y"}))
    assert alone.volume == pytest.approx(4 / 3 * math.pi * 0.1**3, rel=0.02)


def test_cuts_take_away_and_paint_only_paints() -> None:
    half = sculpted(sculpt(ball=BALL, knife={"kind": "box", "op": "cut", "size": [0.4, 0.4, 0.2],
                                             "pose": {"pos": [0, 0, 0.1]}}))  # fmt: skip
    assert half.volume == pytest.approx(2 / 3 * math.pi * 0.1**3, rel=0.03)
    cap = {
        "kind": "box",
        "op": "paint",
        "size": [0.4, 0.4, 0.1],
        "pose": {"pos": [0, 0, 0.1]},
        "look": {"color": "red"},
    }
    made = sculpted(sculpt(ball=BALL, cap=cap))
    assert made.volume == pytest.approx(4 / 3 * math.pi * 0.1**3, rel=0.02)
    red = made.vertices[made.faces[made.looks == 1]]
    # Archimedes: a zone of height h has the area 2 pi r h, wherever it lies.
    area = np.linalg.norm(np.cross(red[:, 1] - red[:, 0], red[:, 2] - red[:, 0]), axis=1).sum() / 2
    assert area == pytest.approx(2 * math.pi * 0.1 * 0.05, rel=0.03)
    assert red[:, :, 2].min() == pytest.approx(0.05, abs=2e-4)
    shapes = made.visuals()
    assert [one.part for one in shapes] == [None, "cap"]
    assert np.linalg.norm(shapes[1].normals, axis=1) == pytest.approx(1.0)


def test_pieces_follow_the_parts() -> None:
    legs = {"kind": "limb", "points": [[0, 0.1, 0], [0, 0.1, -0.3]], "radii": [0.03, 0.02], "mirror": "y"}
    shape = sculpt(0.02, trunk={"kind": "ellipsoid", "radii": [0.3, 0.12, 0.1]}, leg=legs)
    pieces = geometry.pieces(shape, Path())
    assert len(pieces) == 3
    assert min(z for piece in pieces for *_, z in piece.vertices) == pytest.approx(-0.32, abs=1e-3)
    assert extents(shape, (1, 0, 0, 0), Path())[0][2] == pytest.approx(-0.32, abs=2e-3)
    assert all(piece.volume() > 0 for piece in pieces)
    (hull,) = geometry.pieces(shape.model_copy(update={"collision": "hull"}), Path())
    assert hull.volume() > 1.5 * geometry.volume(shape, Path())
    (whole,) = geometry.pieces(shape.model_copy(update={"collision": "decompose"}), Path())
    assert whole.collision == "decompose" and whole.enclosed == pytest.approx(geometry.volume(shape, Path()))
    (surface,) = geometry.pieces(shape.model_copy(update={"collision": "exact"}), Path())
    assert surface.collision == "exact" and surface.field is not None
    assert surface.field.wall < 0.2, "a trunk of 0.2 m has thinner legs"


def test_a_bore_does_not_cut_a_wheel_into_slices() -> None:
    """Every slice of the wheel is as full as the whole: slices of 1 mm would leak, and ask for tiny time steps."""
    wheel = {"kind": "revolve", "smooth": True, "profile": [[0.02, 0], [0.055, 0.008], [0.055, 0.032], [0.02, 0.04]]}
    bore = {"kind": "limb", "op": "cut", "points": [[0, 0, -0.02], [0, 0, 0.06]], "radii": 0.008}
    (corners, _), *others = sculpted(sculpt(wheel=wheel, bore=bore)).hulls
    assert not others
    assert np.ptp(corners[:, 2]) == pytest.approx(0.04, rel=0.02)


def test_limits_hold_before_anything_is_made() -> None:
    fine = sculpt(detail=1e-6, ball=BALL)
    with pytest.raises(AssetError, match=r"`detail` can be 0\.\d+ m or more"):
        grid_of(fine, placed_parts(fine))
    long = sculpt(rod={"kind": "limb", "points": [[0, 0, 0], [9, 9, 9]], "radii": 1.0},
                  wire={"kind": "limb", "points": [[0, 0, 0], [0, 0, 5]], "radii": 0.01},
                  pin={"kind": "limb", "points": [[0, 0, 0], [0, 5, 0]], "radii": 0.011})  # fmt: skip
    with pytest.raises(AssetError, match=r"part `wire` is 0.02 m thick, .* it would be lost, as would `pin`; make"):
        sculpted(long)
    # The advice must not be rounded up to what is refused.
    thin = {"kind": "limb", "points": [[0, 0, 0], [0, 0, 0.4]], "radii": 0.0085}
    with pytest.raises(AssetError, match=r"or take a `detail` of (0\.\d+) m") as refused:
        sculpted(sculpt(detail=0.02, ball=BALL, thin=thin))
    sculpted(sculpt(detail=float(str(refused.value).split("`detail` of ")[1].split(" ")[0]), ball=BALL, thin=thin))
    plinth = sculpt(plinth={"kind": "box", "size": [0.2, 0.2, 1000.0]})
    with pytest.raises(AssetError, match=r"part `plinth` is 0\.2 m thick, .* it would be lost"):
        sculpted(plinth)  # took 18 s: the grid had 14,000 nodes along it
    assert math.prod(grid_of(sculpt(ball=BALL), placed_parts(sculpt(ball=BALL))).counts) < MAX_NODES
    with pytest.raises(AssetError, match="in 2 pieces: .* to part `far`"):
        sculpted(sculpt(ball=BALL, far={**BALL, "radii": [0.03, 0.03, 0.03], "pose": {"pos": [0.5, 0, 0]}}))
    with pytest.raises(AssetError, match="nothing left"):
        sculpted(sculpt(ball=BALL, all={"kind": "box", "op": "cut", "size": [1, 1, 1]}))


CASE = """\
text2sim: 2
name: toy
prompt: A toy stands.
scene: {{duration: 1, statics: {{floor: {{shape: {{kind: plane}}}}}}}}
bodies:
  toy:
    kind: {kind}
    material: {{density: 500}}
    place: {{on: floor}}
    shape:
      kind: sculpt
      {more}
      parts:
        base: {{kind: box, size: [0.2, 0.2, 0.1]}}
        knob: {{kind: ellipsoid, radii: [0.04, 0.04, 0.06], pose: {{pos: [0.05, 0, 0.06]}}, look: {{color: red}}}}
"""


def test_a_body_weighs_what_its_surface_encloses() -> None:
    found = resolve_case(load_text(CASE.format(kind="rigid", more="blend: 0.01"), Path("case.yaml")))
    tree = found.lowering.trees["toy"]
    (link,) = tree.links()
    assert link.inertia is not None
    assert link.inertia.mass == pytest.approx(500 * sculpted(found.placed["toy"][0].shape).volume)
    assert len(link.visuals) == 2 and link.visuals[0].rgba != link.visuals[1].rgba
    assert len(tree_pieces(tree)) == 2
    assert found.placed["toy"][0].pos[2] == pytest.approx(0.05, abs=1e-3)
    mujoco = import_module("mujoco")  # whose names come to be as it is loaded
    text = found.lowering.files["models/toy.xml"]

    assets = {name.split("/")[-1]: content for name, content in found.lowering.files.items() if name.endswith(".obj")}
    model = mujoco.MjModel.from_xml_string(text.decode(), assets=assets)
    assert model.body_mass[1] == pytest.approx(link.inertia.mass, rel=1e-6)
    assert model.body_ipos[1] == pytest.approx(link.inertia.center, abs=1e-7)


def test_what_cannot_be_made_is_said_where_it_stands() -> None:
    with pytest.raises(SpecError) as told:
        resolve_case(load_text(CASE.format(kind="rigid", more="detail: 0.00001"), Path("case.yaml")))
    (problem,) = told.value.problems
    assert problem.line == 11 and "`detail` can be" in problem.message


def test_what_deforms_is_one_volume() -> None:
    shape = sculpt(0.02, trunk=BALL, head={**BALL, "pose": {"pos": [0.12, 0, 0]}})
    made = soft_surface(shape, Path(), 0.03)
    sides = np.linalg.norm(made.vertices[made.faces[:, 0]] - made.vertices[made.faces[:, 1]], axis=1)
    assert 0.012 < np.median(sides) < 0.04
    found = resolve_case(load_text(CASE.format(kind="soft", more="blend: 0.01"), Path("case.yaml")))
    (group,) = found.plan.bodies
    assert group.entities[0].soft is not None
    assert group.entities[0].soft.mass == pytest.approx(500 * sculpted(found.placed["toy"][0].shape).volume, rel=1e-6)


def test_a_blend_that_fills_all_there_is_is_refused() -> None:
    swollen = {f"ball_{k}": BALL for k in range(9)}
    with pytest.raises(AssetError, match="take a smaller `blend`"):  # it reaches the border of the grid alone
        sculpted(sculpt(blend=0.5, **swollen))
    parts = "{a: {kind: ellipsoid, radii: [0.2, 0.1, 0.1]}, b: {kind: ellipsoid, radii: [0.1, 0.1, 0.2]}}"
    body = f"{{kind: rigid, shape: {{kind: sculpt, blend: 1.0e+6, parts: {parts}}}, pose: {{pos: [0, 0, 1]}}}}"
    with pytest.raises(SpecError, match="blend"):
        resolve_case(load_text(f"text2sim: 2\nname: a\nprompt: p\nscene: {{duration: 1}}\nbodies:\n  b: {body}\n"))


def test_the_coil_of_the_reference_is_a_wire_along_a_helix() -> None:
    """A wire of length L and radius r with round ends has the volume pi r^2 (L + 4 r / 3)."""
    example = SCULPT.split("```yaml\n")[2].removesuffix("```").replace("\n", "\n    ")
    case = load_text(
        f"text2sim: 2\nname: coil\nprompt: A coil.\nscene: {{duration: 1}}\nbodies:\n  coil:\n    kind: rigid\n    {example}\n"
    ).case
    made = sculpted(case.bodies["coil"].shape)  # type: ignore[union-attr]
    radius, pitch, turns, wire = 0.03, 0.016, 5, 0.003
    length = turns * math.hypot(2 * math.pi * radius, pitch)
    # Chords of a twentieth turn are 0.4 % shorter than the arc; cells of a fifth of the wire cut off 4 % of its section.
    assert made.volume == pytest.approx(math.pi * wire**2 * (length + 4 / 3 * wire), rel=0.05)
    away = np.hypot(made.vertices[:, 0], made.vertices[:, 1])
    assert (away.min(), away.max()) == (pytest.approx(radius * math.cos(math.pi / 20) - wire, abs=2e-4),
                                        pytest.approx(radius + wire, abs=2e-4))  # fmt: skip
    assert np.ptp(made.vertices[:, 2]) == pytest.approx(turns * pitch + 2 * wire, abs=4e-4)
    # What is at its angle and height is wire; half a pitch above it is a gap.
    angle = np.arctan2(made.vertices[:, 1], made.vertices[:, 0])
    offset = (made.vertices[:, 2] / pitch - angle / (2 * math.pi) + 0.5) % 1 - 0.5
    inside = (made.vertices[:, 2] > 0) & (made.vertices[:, 2] < turns * pitch)
    assert np.abs(offset[inside]).max() * pitch < 1.1 * wire
