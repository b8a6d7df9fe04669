"""Mass, centre and inertia of every shape, as the engine has them (`layout.json`), against formulas.

Formulas: Bronshtein, Handbook of Mathematics, 3.3 (volumes) and 8 (moments of inertia). What is made of flat staves or
of capsules has the mass of its formula too, and is held in its inertia to the error of the polygon in the circle.
"""

import math

import numpy as np
import pytest

SHAPES = {
    "box": "{kind: box, size: [0.1, 0.2, 0.3]}",
    "sphere": "{kind: sphere, radius: 0.1}",
    "cylinder": "{kind: cylinder, radius: 0.1, height: 0.3}",
    "capsule": "{kind: capsule, radius: 0.1, length: 0.3}",
    "ellipsoid": "{kind: ellipsoid, radii: [0.1, 0.2, 0.3]}",
    "cone": "{kind: cone, radius: 0.1, height: 0.3}",
    "frustum": "{kind: cone, radius: 0.1, height: 0.3, top_radius: 0.05}",
    "polyhedron": "{kind: polyhedron, points: [[-0.1, -0.1, 0], [0.1, -0.1, 0], [-0.1, 0.1, 0], [0.1, 0.1, 0], [0, 0, 0.3]]}",
    "torus": "{kind: torus, radius: 0.2, bar_radius: 0.03, segments: 24}",
    "tube": "{kind: tube, outer_radius: 0.3, inner_radius: 0.25, height: 0.4}",
    "cup": "{kind: cup, radius: 0.2, height: 0.4, thickness: 0.02}",
    "funnel": "{kind: funnel, top_radius: 0.3, bottom_radius: 0.1, height: 0.3, thickness: 0.03}",
    "extrusion": "{kind: extrusion, outline: [[-0.2, 0], [0.2, 0], [0.2, 0.1], [0.1, 0.1], [0.1, 0.3], [-0.1, 0.3], [-0.1, 0.1], [-0.2, 0.1]], depth: 0.2}",
}
DENSITY, MASS = 700.0, 2.5


@pytest.fixture(scope="module")
def shapes(simulate):
    """Every shape, twice: by density, and by mass; and once on a hinge."""
    bodies, k = [], 0
    for name, shape in SHAPES.items():
        for which, material, mount in (
            ("dense", f"density: {DENSITY}", ""),
            ("given", f"mass: {MASS}", ""),
            ("hung", f"mass: {MASS}", ", mount: {kind: hinge}"),
        ):
            bodies.append(
                f"  {name}_{which}: {{kind: rigid, shape: {shape}, material: {{{material}}}, pose: {{pos: [{k}, 0, 0], euler_deg: [20, 30, 40]}}{mount}}}\n"
            )
            k += 1
    return simulate("scene: {duration: 0.01, dt: 0.01, gravity: [0, 0, 0]}\nbodies:\n" + "".join(bodies))


def disc(radius, height):
    """Mass, height of the centre, and moments about it of a solid cylinder of density 1: (m, z, across, along)."""
    m = math.pi * radius**2 * height
    return m, 0.0, m * (3 * radius**2 + height**2) / 12, m * radius**2 / 2


def theory(name):
    """(m, z, Ixx, Iyy, Izz) of the shapes above for density 1, about the centre of mass at height z."""
    if name == "box":
        m = 0.1 * 0.2 * 0.3
        return m, 0, m * (0.2**2 + 0.3**2) / 12, m * (0.1**2 + 0.3**2) / 12, m * (0.1**2 + 0.2**2) / 12
    if name == "extrusion":  # a box on a broader one: 0.2 x 0.2 x 0.2 m on 0.4 x 0.2 x 0.1 m
        upper, lower = 0.2**3, 0.4 * 0.2 * 0.1
        m, z = upper + lower, (0.2 * upper + 0.05 * lower) / (upper + lower)
        heights = upper * (0.2 - z) ** 2 + lower * (0.05 - z) ** 2  # Steiner
        x, y, tall = (upper * 0.2**2 + lower * w for w in (0.4**2, 0.2**2, 0.1**2))
        return m, z, (y + tall) / 12 + heights, (x + tall) / 12 + heights, (x + y) / 12
    if name == "polyhedron":  # a pyramid
        m = 0.2**2 * 0.3 / 3
        across = m * (0.2**2 / 20 + 3 * 0.3**2 / 80)
        return m, 0.3 / 4, across, across, m * 0.2**2 / 10
    if name == "sphere":
        m = 4 / 3 * math.pi * 0.1**3
        return m, 0, *3 * [0.4 * m * 0.1**2]
    if name == "cylinder":
        m, z, across, along = disc(0.1, 0.3)
        return m, z, across, across, along
    if name == "capsule":
        r, straight = 0.1, 0.3
        rod, ball = math.pi * r**2 * straight, 4 / 3 * math.pi * r**3
        across = rod * (3 * r**2 + straight**2) / 12
        across += ball * (0.4 * r**2 + straight**2 / 4 + 3 * straight * r / 8)
        return rod + ball, 0, across, across, rod * r**2 / 2 + 0.4 * ball * r**2
    if name == "ellipsoid":
        a, b, c = 0.1, 0.2, 0.3
        m = 4 / 3 * math.pi * a * b * c
        return m, 0, m * (b * b + c * c) / 5, m * (a * a + c * c) / 5, m * (a * a + b * b) / 5
    if name == "cone":
        m = math.pi * 0.1**2 * 0.3 / 3
        across = m * (0.15 * 0.1**2 + 0.0375 * 0.3**2)
        return m, 0.3 / 4 - 0.15, across, across, 0.3 * m * 0.1**2
    if name == "torus":
        big, small = 0.2, 0.03
        m = 2 * math.pi**2 * big * small**2
        across = m * (4 * big**2 + 5 * small**2) / 8
        return m, 0, across, across, m * (big**2 + 0.75 * small**2)
    # The rest are differences of bodies of revolution; integrate pi (R^2 - r^2) and its moments over the height.
    edges = {"frustum": _frustum, "tube": _tube, "cup": _cup, "funnel": _funnel}[name]
    parts = np.concatenate([np.linspace(*span, 4001)[:-1] + (span[1] - span[0]) / 8000 for span in edges[1]])
    dz = np.concatenate([np.full(4000, (span[1] - span[0]) / 4000) for span in edges[1]])
    inner, outer = edges[0](parts)
    area, polar = math.pi * (outer**2 - inner**2) * dz, math.pi / 2 * (outer**4 - inner**4) * dz
    m, z = area.sum(), (area * parts).sum() / area.sum()
    across = polar.sum() / 2 + (area * (parts - z) ** 2).sum()
    return m, z, across, across, polar.sum()


_frustum = (lambda z: (0 * z, 0.075 - z / 0.3 * 0.05), [(-0.15, 0.15)])
_tube = (lambda z: (0.25 + 0 * z, 0.3 + 0 * z), [(-0.2, 0.2)])
_cup = (lambda z: (np.where(z < -0.18, 0.0, 0.18), 0.2 + 0 * z), [(-0.2, -0.18), (-0.18, 0.2)])
_funnel = (lambda z: (0.2 + z / 0.15 * 0.1, 0.23 + z / 0.15 * 0.1), [(-0.15, 0.15)])

POLYGON = {"cone": 32, "frustum": 32, "torus": 24, "tube": 24, "cup": 24, "funnel": 24}


def tolerance(name):
    """Relative error of moments by flat sides.

    Corners of n sides lie on the circle, or their middles: where mass is, in the mean of r^2, is off by at most
    (2 pi / n)^2 / 6; of a ring, where capsules overlap and end in half spheres, by the square of bar over radius more.
    """
    if name not in POLYGON:
        return 2e-6
    return (2 * math.pi / POLYGON[name]) ** 2 / 6 + (0.15**2 if name == "torus" else 0.0)


@pytest.mark.parametrize("name", SHAPES)
def test_a_shape_has_the_mass_centre_and_inertia_of_its_formula(shapes, agree, name):
    """By density: the integral of the density over the shape."""
    link = shapes.link(f"{name}_dense")
    m, z, *moments = theory(name)
    size = tolerance(name)
    agree(f"{name}: mass / theory", link.mass / (m * DENSITY), 1.0, within=2e-6)
    # At least ten roundings to single precision (2^-24) of 0.3 m: the engine keeps corners of meshes so, and adds them.
    agree(f"{name}: centre [m]", link.com, (0, 0, z), within=max(size * 0.15, 1e-6))
    agree(f"{name}: moments / theory", np.diag(link.inertia) / (np.array(moments) * DENSITY), 1.0, within=size)
    off = np.array(link.inertia) - np.diag(np.diag(link.inertia))
    agree(f"{name}: products of inertia / moment", off / (max(moments) * DENSITY), 0.0, within=1e-5)


@pytest.mark.parametrize("name", SHAPES)
def test_a_given_mass_is_the_mass(shapes, agree, name):
    """Free and on a hinge, to float32; the inertia per mass does not change with it."""
    for which in ("given", "hung"):
        link = shapes.link(f"{name}_{which}")
        agree(f"{name} of {MASS} kg, {which}: mass [kg]", link.mass, MASS, within=MASS * 1e-6)
        dense = shapes.link(f"{name}_dense")
        agree(
            f"{name} of {MASS} kg, {which}: inertia per mass [m2]",
            np.array(link.inertia) / MASS,
            np.array(dense.inertia) / dense.mass,
            within=1e-6,
        )
        agree(f"{name} of {MASS} kg, {which}: centre [m]", link.com, dense.com, within=1e-6)


def test_a_compound_adds_up_its_parts(simulate, agree):
    """Sums: m = sum m_i, centre = sum m_i x_i / m, I = sum R_i I_i R_i' + m_i (r^2 - r r') (Steiner)."""
    trial = simulate("""
scene: {duration: 0.01, dt: 0.01, gravity: [0, 0, 0]}
bodies:
  tool:
    kind: rigid
    shape:
      kind: compound
      parts:
        head: {shape: {kind: box, size: [0.3, 0.1, 0.1]}, pose: {pos: [0.05, 0, 0.3], euler_deg: [0, 0, 90]}, density: 5000}
        shaft: {shape: {kind: cylinder, radius: 0.02, height: 0.6}}
    material: {density: 800}
""")
    head, shaft = 5000 * 0.3 * 0.1 * 0.1, 800 * math.pi * 0.02**2 * 0.6
    total, centre = head + shaft, head * np.array([0.05, 0, 0.3]) / (head + shaft)
    moments = head * np.diag([0.3**2 + 0.1**2, 0.1**2 + 0.1**2, 0.3**2 + 0.1**2]) / 12
    moments += shaft * np.diag([3 * 0.02**2 + 0.6**2, 3 * 0.02**2 + 0.6**2, 6 * 0.02**2]) / 12
    for mass, place in ((head, np.array([0.05, 0, 0.3])), (shaft, np.zeros(3))):
        r = place - centre
        moments += mass * (r @ r * np.eye(3) - np.outer(r, r))
    link = trial.link("tool")
    agree("compound: mass [kg]", link.mass, total, within=1e-6 * total)
    agree("compound: centre [m]", link.com, centre, within=1e-6)
    agree("compound: inertia [kg m2]", link.inertia, moments, within=1e-5 * moments.max())
