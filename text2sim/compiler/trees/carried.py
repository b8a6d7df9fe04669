"""Links of a tree beside what they carry: how small their part of it is, and how fast they shake under it."""

import math
from typing import NamedTuple

from text2sim.compiler.shapes.rotation import IDENTITY, ORIGIN, Quaternion, Vec, frame_apply, quat_multiply
from text2sim.compiler.trees.tree import Tree, TreeLink


class CarriedLink(NamedTuple):
    """A link with all that hangs on it."""

    link: TreeLink
    mass: float
    """Its own [kg]."""
    load: float
    """Of all that hangs on it [kg], itself included."""
    inertia: float
    """Its own about its joint [kg m2], armature included."""
    carried: float
    """Of all that hangs on it, itself and armature included [kg m2]."""
    reach: float
    """Distance [m] to the nearest joint of what hangs on it; 0 at an end."""


class _Lump(NamedTuple):
    mass: float
    center: Vec
    spin: float
    """Inertia about its centre [kg m2], roughly: that of a bar."""


def carried_links(tree: Tree) -> list[CarriedLink]:
    """Return the links of a tree, as it stands at the start, with what hangs on each."""
    found: list[CarriedLink] = []
    for root in tree.roots:
        _walk(root, ORIGIN, IDENTITY, found)
    return found


def _walk(link: TreeLink, pos: Vec, quat: Quaternion, found: list[CarriedLink]) -> tuple[list[_Lump], Vec]:
    pos, quat = frame_apply(pos, quat, link.pos), quat_multiply(quat, link.quat)
    own = _lumps(link, pos, quat)
    joints = [joint for _, joint in link.all_joints()]
    pivot = pos
    if joints and joints[0].kind == "free" and own:
        pivot = own[0].center
    elif joints:
        pivot = frame_apply(pos, quat, joints[0].anchor)
    lumps, reach = list(own), math.inf
    for child in link.children:
        more, joint = _walk(child, pos, quat, found)
        lumps += more
        reach = min(reach, math.dist(pivot, joint))
    if joints:
        armature = max(joint.armature for joint in joints)
        found.append(
            CarriedLink(
                link, sum(lump.mass for lump in own), sum(lump.mass for lump in lumps),
                _inertia_about(own, pivot) + armature, _inertia_about(lumps, pivot) + armature,
                0.0 if reach == math.inf else reach,
            )
        )  # fmt: skip
    return lumps, pivot


def _inertia_about(lumps: list[_Lump], pivot: Vec) -> float:
    return sum(lump.spin + lump.mass * math.dist(lump.center, pivot) ** 2 for lump in lumps)


def _lumps(link: TreeLink, pos: Vec, quat: Quaternion) -> list[_Lump]:
    if link.inertia is not None:
        whole = link.inertia
        return [_Lump(whole.mass, frame_apply(pos, quat, whole.center), max(whole.inertia[:3]))]
    found = []
    for geom in link.geoms:
        center, radius = geom.piece.ball
        mass = geom.density * geom.piece.volume()
        found.append(_Lump(mass, frame_apply(pos, quat, center), mass * radius**2 / 3))
    return found


def smallest_share(tree: Tree) -> float:
    """Return the least part that a link has in the inertia of all that it carries, about its joint."""
    shares = (row.inertia / row.carried for row in carried_links(tree) if row.carried > 0.0)
    return min(shares, default=1.0)
