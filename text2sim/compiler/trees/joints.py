"""Mounts and joints of the language as joints of a tree."""

from math import radians
from typing import Any

from text2sim.compiler.shapes.rotation import vector_unit
from text2sim.compiler.trees.tree import TreeJoint
from text2sim.spec_schema.models.bodies import BallMount, HingeMount, SliderMount


def joint_of(mount: Any) -> TreeJoint:
    """Return the tree joint for a hinge, slider or ball; damping and armature default to zero."""
    common = {
        "damping": mount.damping or 0.0,
        "friction": mount.friction,
        "armature": mount.armature or 0.0,
        "spring": mount.spring,
    }
    if isinstance(mount, HingeMount):
        limits = None if mount.range_deg is None else (radians(mount.range_deg[0]), radians(mount.range_deg[1]))
        return TreeJoint("hinge", vector_unit(mount.axis), mount.anchor, limits, **common)
    if isinstance(mount, SliderMount):
        return TreeJoint("slider", vector_unit(mount.axis), range=mount.range, **common)
    assert isinstance(mount, BallMount)
    return TreeJoint("ball", anchor=mount.anchor, **common)
