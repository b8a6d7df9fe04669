"""Trees for chains, ropes and nets."""

import math
from dataclasses import replace
from itertools import pairwise

from text2sim.compiler.shapes.piece import Piece
from text2sim.compiler.shapes.rotation import (
    IDENTITY,
    ORIGIN,
    Z_AXIS,
    Quaternion,
    Vec,
    quat_between,
    quat_conjugate,
    quat_multiply,
    quat_rotate,
    vector_minus,
    vector_plus,
    vector_times,
)
from text2sim.compiler.trees.tree import Tree, TreeGeom, TreeJoint, TreeLink, TreeLoop, strung
from text2sim.spec_schema.models.bodies import Chain, Net
from text2sim.spec_schema.models.materials import DENSITY, JointDynamics, Material
from text2sim.spec_schema.models.soft_bodies import Rope

Rgba = tuple[float, float, float, float] | None


def capsule_mass(radius: float, length: float, density: float) -> float:
    """Return the mass [kg] of a capsule whose straight part is `length`: a cylinder and a ball.

    Args:
        radius: [m]
        length: [m]
        density: [kg/m3]
    """
    return density * (math.pi * radius**2 * length + 4 / 3 * math.pi * radius**3)


def ball_joint(
    dynamics: JointDynamics, mass: float, length: float, damping: float, armature: float = 0.02
) -> TreeJoint:
    """Return a ball joint that cannot explode.

    An undamped tree of ball joints without armature diverges at ordinary time steps. What the author leaves out is
    scaled with the inertia `mass length^2` of the link: a part `armature` of it, and a part `damping` of it per second.

    Args:
        dynamics: What the author says.
        mass: Of the link [kg].
        length: Of the link [m].
        damping: Part of the inertia, per second [1/s].
        armature: Part of the inertia.
    """
    inertia = mass * length**2
    return TreeJoint(
        "ball",
        damping=dynamics.damping if dynamics.damping is not None else damping * inertia,
        armature=dynamics.armature if dynamics.armature is not None else armature * inertia,
        friction=dynamics.friction,
        spring=dynamics.spring,
    )


def density_of(material: Material, volume: float) -> float:
    """Return the density [kg/m3] of a material; `mass` counts for the whole `volume` [m3]."""
    return material.mass / volume if material.mass is not None else material.density or DENSITY


def capsule_bar(
    length: float, radius: float, density: float, friction: float, rgba: Rgba, start: Vec, end: Vec
) -> TreeGeom:
    """Return a capsule between two points.

    Args:
        length: Of its straight part [m].
        radius: [m]
        density: [kg/m3]
        friction: Coulomb coefficient.
        rgba: Its colour.
        start: The middle of its one end [m].
        end: That of its other end [m].
    """
    middle, turn = vector_times(vector_plus(start, end), 0.5), quat_between(Z_AXIS, vector_minus(end, start))
    piece = Piece(kind="capsule", pos=middle, quat=turn, size=(radius, length))
    return TreeGeom(piece, density, friction, rgba)


LOADED_ARMATURE = 2e-6
"""Least armature of the joints of a chain that carries a payload, over `M L^2` of the payload about the upper end.

The mass matrix is factored with numbers of 32 bits (relative error 1.2e-7). A thin chain's own inertia is lost in it
beside the payload's, and any touch throws the chain apart. Measured with 50 kg on links of 5 cm and 3 mm, at 28
substeps of 10 ms: 20 links need 8e-8 to 8e-7 of `M L^2`, and 40 links 2.2e-7 to 4.5e-7.
"""

LONG_ARMATURE = 1.5e-6
"""The same of the joints of a rope and the inertia of a link about its joint together, over `M L^2` of the whole rope.

At least as much as a rope of 62 links has by itself, which runs; one of 122 links over a pulley flew apart at once.
"""


def chain_tree(chain: Chain, direction: Vec, rgba: Rgba, payload: tuple[tuple[TreeGeom, ...], float] | None) -> Tree:
    """Return a hanging chain as one tree of ball joints: it cannot stretch, whatever hangs on it.

    Args:
        chain: The body.
        direction: Unit vector from the upper end downwards, in the body's frame.
        rgba: Colour of the links.
        payload: The load's geoms in its own frame, and the distance [m] from the last joint to its frame.
    """
    length, radius = chain.link_length, chain.radius
    bar = max(length - 2 * radius, 0.1 * length)
    bare_volume = chain.links * capsule_mass(radius, bar, 1.0)
    density = density_of(chain.material, bare_volume)
    joint = ball_joint(chain.joint, capsule_mass(radius, bar, density), length, damping=0.05)
    middle = length / 2
    geom = capsule_bar(
        bar, radius, density, chain.material.friction, rgba, (0, 0, -middle + bar / 2), (0, 0, -middle - bar / 2)
    )

    hung: list[TreeLink] = []
    if payload is not None:
        geoms, reach = payload
        if chain.joint.armature is None:
            load = sum(geom.density * geom.piece.volume() for geom in geoms)
            least = LOADED_ARMATURE * load * (chain.links * length + reach) ** 2
            joint = replace(joint, armature=max(joint.armature, least))
        hanger = TreeJoint("ball", anchor=(0.0, 0.0, reach), damping=joint.damping, armature=joint.armature)
        hung = [TreeLink("payload", pos=(0.0, 0.0, -length - reach), joint=hanger, geoms=geoms)]
    links = [
        TreeLink(
            f"link_{index}",
            pos=(0.0, 0.0, -length) if index else ORIGIN,
            quat=IDENTITY if index else quat_between((0.0, 0.0, -1.0), direction),
            joint=joint if index or chain.anchored else TreeJoint("free"),
            geoms=(geom,),
        )
        for index in range(chain.links)
    ]
    return Tree((strung(links + hung),))


LAID_DAMPING = 15.0
"""Damping of the joints of a rope that is laid along a path, per second, over m l2.

The links of a rope that slides round a post under tension spin and chatter ever faster: 70 links of 0.3 g that carry
3 kg flew apart within 0.3 s with the damping of other ropes, 0.05. At the speed v round the radius R it takes some
30 m l2 v / R2 off the pull: 1 mN of 17 N.
"""
BEND_DAMPING = 0.1
"""Damping ratio of a link of a rope against the spring that keeps it straight."""


def rope_tree(rope: Rope, direction: Vec, rgba: Rgba) -> Tree:
    """Return a rope as capsules on ball joints, which cannot stretch.

    A bend of the angle b between two links of length l is a curve of curvature b / l: the bending moment E I b / l is
    that of a spring of stiffness E I / l. I = pi r^4 / 4 is the second moment of area of a round section. Springs of
    ball joints are isotropic: the same stiffness resists twist, G J / l with J = 2 I and G = E / 2, that of Poisson's
    ratio 0. The first joint, which holds the rope, turns freely.

    Args:
        rope: The body.
        direction: Unit vector from its first end to its last, in the body's frame.
        rgba: Colour of the links.
    """
    length, radius = _link_length(rope), rope.radius
    mass, spring = _rope_link(rope)
    # Round ends make the joints smooth. Where they overlap they weigh nothing: the whole weighs what a cylinder does.
    density = mass / capsule_mass(radius, length, 1.0)
    damping = 0.05 if rope.along is None else LAID_DAMPING
    joint = ball_joint(JointDynamics.model_construct(damping=rope.damping), mass, length, damping=damping)
    least = (LONG_ARMATURE * rope.segments**3 - 1 / 3) * mass * length**2
    joint = replace(joint, armature=max(joint.armature, least))
    if rope.damping is None and spring > 0.0:
        inertia = mass * length**2 / 3 + joint.armature
        joint = replace(joint, damping=max(joint.damping, 2 * BEND_DAMPING * math.sqrt(spring * inertia)))
    bar = capsule_bar(length, radius, density, rope.material.friction, rgba, ORIGIN, (0.0, 0.0, -length))
    start, turns = _rope_poses(rope, direction)
    held, bent = joint if rope.anchored else TreeJoint("free"), replace(joint, spring=spring)
    links = [
        TreeLink(
            f"link_{index}",
            pos=(0.0, 0.0, -length) if index else start,
            quat=turn,
            joint=bent if index else held,
            geoms=(bar,),
        )
        for index, turn in enumerate(turns)
    ]
    return Tree((strung(links),), self_collision=rope.self_collision)


def _rope_poses(rope: Rope, direction: Vec) -> tuple[Vec, list[Quaternion]]:
    """Return where a rope begins [m], and the turn of each link from the one before, or from the body's frame."""
    if rope.along is None:
        return ORIGIN, [quat_between((0.0, 0.0, -1.0), direction), *[IDENTITY] * (rope.segments - 1)]
    nodes: list[Vec] = list(rope.along)  # type: ignore[arg-type]  # laid: the places of its joints
    turns, before = [], IDENTITY
    for a, b in pairwise(nodes):
        own = quat_rotate(quat_conjugate(before), vector_minus(b, a))
        turns.append(quat_between((0.0, 0.0, -1.0), own))
        before = quat_multiply(before, turns[-1])
    return nodes[0], turns


def _link_length(rope: Rope) -> float:
    assert rope.length is not None
    return rope.length / rope.segments


def _rope_link(rope: Rope) -> tuple[float, float]:
    """Return the mass [kg] of a link of a rope, and the stiffness [N m/rad] of the spring at its joint."""
    length, section = _link_length(rope), math.pi * rope.radius**2
    mass = density_of(rope.material, section * length * rope.segments) * section * length
    return mass, rope.youngs_modulus * section * rope.radius**2 / 4 / length


def link_of(body: Rope | Chain) -> tuple[float, float]:
    """Return mass [kg] and length [m] of a link."""
    if isinstance(body, Rope):
        return _rope_link(body)[0], _link_length(body)
    length = body.link_length
    volume = capsule_mass(body.radius, max(length - 2 * body.radius, 0.1 * length), 1.0)
    return density_of(body.material, body.links * volume) * volume, length


def rope_frequency(rope: Rope) -> float:
    """Return the largest angular frequency [rad/s] at which a rope bends from link to link: 4 sqrt(k / m) / l."""
    mass, spring = _rope_link(rope)
    return 4 * math.sqrt(spring / mass) / _link_length(rope)


def net_tree(net: Net, rgba: Rgba) -> Tree:
    """Return a net of strands. Each strand is one chain from one edge to the other, closed there and at every crossing.

    A net of free links joined by constraints alone is three times softer than this form, and slower.
    """
    (nx, ny), (lx, ly), radius = net.cells, net.size, net.radius

    def node(i: int, j: int) -> Vec:
        u, v = 2 * i / nx - 1, 2 * j / ny - 1
        return (lx * u / 2, ly * v / 2, -net.sag * (1 - u * u) * (1 - v * v))

    spans = [[(node(i, j), node(i + 1, j)) for i in range(nx)] for j in range(1, ny)]
    spans += [[(node(i, j), node(i, j + 1)) for j in range(ny)] for i in range(1, nx)]
    names = [f"x{j}" for j in range(1, ny)] + [f"y{i}" for i in range(1, nx)]
    volume = sum(capsule_mass(radius, math.dist(a, b), 1.0) for strand in spans for a, b in strand)
    density = density_of(net.material, volume)

    roots, loops = [], []
    for name, strand in zip(names, spans, strict=True):
        roots.append(_strand(name, strand, net, density, rgba))
        start, end = strand[-1]
        loops.append(TreeLoop("connect", f"{name}_{len(strand) - 1}", None, vector_minus(end, start)))
    for j in range(1, ny):
        for i in range(1, nx):
            # The link that ends at the crossing, and the crossing strand's link that ends there too.
            start, end = spans[j - 1][i - 1]
            loops.append(TreeLoop("connect", f"x{j}_{i - 1}", f"y{i}_{j - 1}", vector_minus(end, start)))
    corners = [node(0, 0), node(nx, 0), node(nx, ny), node(0, ny)]
    edges = tuple(
        capsule_bar(math.dist(a, b), 1.5 * radius, density, net.material.friction, rgba, a, b)
        for a, b in zip(corners, corners[1:] + corners[:1], strict=True)
    )
    return Tree(tuple(roots), tuple(loops), fixtures=edges)


def _strand(name: str, spans: list[tuple[Vec, Vec]], net: Net, density: float, rgba: Rgba) -> TreeLink:
    links, previous = [], ORIGIN
    for index, (start, end) in enumerate(spans):
        length = math.dist(start, end)
        # Bodies far heavier than a strand fall into a net: with the armature of a chain it flew apart under dolls of
        # a hundred times a link's mass.
        joint = ball_joint(net.joint, capsule_mass(net.radius, length, density), length, damping=8.0, armature=0.4)
        # Links of a net keep the net's axes, so that a span is its own local vector.
        bar = capsule_bar(length, net.radius, density, net.material.friction, rgba, ORIGIN, vector_minus(end, start))
        links.append(TreeLink(f"{name}_{index}", pos=vector_minus(start, previous), joint=joint, geoms=(bar,)))
        previous = start
    return strung(links)
