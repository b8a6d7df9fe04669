"""Trees for beams: straight elastic strips."""

import math
from dataclasses import replace

from text2sim.compiler.shapes.inertials import piece_inertial
from text2sim.compiler.shapes.piece import Piece
from text2sim.compiler.shapes.rotation import IDENTITY, ORIGIN, Y_AXIS
from text2sim.compiler.trees.generators import Rgba, density_of
from text2sim.compiler.trees.tree import Tree, TreeGeom, TreeJoint, TreeLink, strung
from text2sim.spec_schema.models.soft_bodies import Beam

FIRST_ROOT = 1.8751040687
"""First root of cos x cosh x = -1, the equation of a beam that is clamped at one end and free at the other."""
OVERLAP = 0.14
"""How far a box extends beyond a joint, over its thickness: tan(b / 2) / 2 fills the wedge of a bend b, here 31 deg."""


def beam_tree(beam: Beam, rgba: Rgba) -> Tree:
    """Return a beam as boxes on hinges about y, each with its frame at its first end.

    A joint between links of length l stands for the curvature of half a link on either side: a spring of E I / l, with
    I = w t^3 / 12. The clamp stands for half a link: a spring of 2 E I / l. The tip's deflection under a force F there
    is the integral of F (L - x)^2 / (E I) by the trapezoidal rule: F L^3 / (3 E I) times 1 + 1 / (2 N^2) for N links.
    The springs of a clamped beam are stiffer by this factor, so that the deflection is exact.

    Dampers in proportion to the springs, 2 z k / w1, give mode n the damping ratio z wn / w1, and the first one z
    (Rayleigh damping without its mass-proportional term: Clough and Penzien, Dynamics of Structures).

    Args:
        beam: The body.
        rgba: Colour of the links.
    """
    spring = _spring(beam) * (1 + 1 / (2 * beam.segments**2) if beam.anchored else 1.0)
    slope = 2 * beam.damping_ratio / first_frequency(beam)
    density = density_of(beam.material, math.prod(beam.size))
    inertia = piece_inertial(_box(beam, 0.0, _link_length(beam)), density)
    joint = TreeJoint("hinge", axis=Y_AXIS, spring=spring, damping=slope * spring)
    clamp = replace(joint, spring=2 * spring, damping=slope * (2 * spring)) if beam.anchored else TreeJoint("free")
    links = [
        TreeLink(
            f"link_{index}",
            pos=(_link_length(beam), 0.0, 0.0) if index else ORIGIN,
            joint=joint if index else clamp,
            geoms=_geoms(beam, rgba, index),
            inertia=inertia,
        )
        for index in range(beam.segments)
    ]
    return Tree((strung(links),))


def _geoms(beam: Beam, rgba: Rgba, index: int) -> tuple[TreeGeom, ...]:
    """Return the boxes of a link, which overlap those of its neighbours, so that no wedge is open between them.

    A clamp may stand flush with what holds it. The edges of a box that turns about the clamp would press on that, and
    stiffen the beam: the box that touches begins half a thickness farther on.
    """
    overlap = OVERLAP * beam.size[2]
    start = -overlap if index else 0.0
    end = _link_length(beam) + (overlap if index < beam.segments - 1 else 0.0)
    density = density_of(beam.material, math.prod(beam.size)) * _link_length(beam) / (end - start)
    geom = TreeGeom(_box(beam, start, end), density, beam.material.friction, rgba)
    if index or not beam.anchored:
        return (geom,)
    touched = replace(geom, piece=_box(beam, beam.size[2] / 2, end), density=0.0, drawn=False)
    return replace(geom, touches=False), touched


def _box(beam: Beam, start: float, end: float) -> Piece:
    """Return the box of a link from one distance [m] to another along it."""
    return Piece("box", ((start + end) / 2, 0.0, 0.0), IDENTITY, (end - start, *beam.size[1:]))


def _link_length(beam: Beam) -> float:
    return beam.size[0] / beam.segments


def _spring(beam: Beam) -> float:
    """Return the stiffness [N m/rad] of half a link on either side of a joint."""
    _, width, thickness = beam.size
    return beam.youngs_modulus * width * thickness**3 / 12 / _link_length(beam)


def first_frequency(beam: Beam) -> float:
    """Return the angular frequency [rad/s] of the first swing, clamped at one end: x^2 sqrt(E I / (rho A L^4)).

    Euler and Bernoulli's; x is `FIRST_ROOT`. That of the tree is lower by 0.21 / N^2 for N links.
    """
    length, _, thickness = beam.size
    density = density_of(beam.material, math.prod(beam.size))
    return FIRST_ROOT**2 * math.sqrt(beam.youngs_modulus / (12 * density)) * thickness / length**2


def shaking_frequency(beam: Beam) -> float:
    """Return the angular frequency [rad/s] whose undamped oscillation would need as short a step as a beam does.

    Rigid links of mass m that bend to and fro, one against the next, swing fastest: at w = sqrt(48 k / m) / l, since a
    zigzag of the height a has m a^2 w^2 / 6 and k (4 a / l)^2 / 2 for each link. With the damping ratio z of this mode,
    an integrator that is explicit in stiffness and implicit in damping is stable up to h w = 2 (z + sqrt(1 + z^2))
    (`lint/numbers/stiffness.py`), and without damping up to h w = 2.
    """
    length, volume = _link_length(beam), math.prod(beam.size)
    mass = density_of(beam.material, volume) * volume / beam.segments
    fastest = math.sqrt(48 * _spring(beam) / mass) / length
    ratio = beam.damping_ratio * fastest / first_frequency(beam)
    return fastest / (ratio + math.sqrt(1 + ratio**2))


def beam_frequency(beam: Beam) -> float:
    """Return the angular frequency [rad/s] that the substeps of a beam must resolve.

    It is at least four times the frequency of the first swing, which a strongly damped beam could otherwise miss: it is
    stable at steps that are too long to resolve that swing. At h w = 0.2 the frequency is 0.2 % wrong.
    """
    return max(shaking_frequency(beam), 4 * first_frequency(beam))
