"""Mounts and joints of the language as joints of a tree, and the other way round."""

from math import degrees, radians
from typing import Any

from text2sim.compiler.shapes.rotation import vector_unit
from text2sim.compiler.trees.tree import TreeJoint
from text2sim.spec_schema.models.bodies import BallMount, HingeMount, SliderMount
from text2sim.spec_schema.models.materials import Actuator


def joint_model(
    kind: str, limits: tuple[float, float] | None = None, actuator: Actuator | None = None
) -> HingeMount | SliderMount | BallMount:
    """Return a joint that the case does not write, as a model of the language, without checks of its values.

    Args:
        kind: hinge, slider or ball.
        limits: Its range [rad or m].
        actuator: Its motor.
    """
    if kind == "hinge":
        limits = None if limits is None else (degrees(limits[0]), degrees(limits[1]))
        return HingeMount.model_construct(kind="hinge", range_deg=limits, actuator=actuator)
    if kind == "slider":
        return SliderMount.model_construct(kind="slider", range=limits, actuator=actuator)
    assert kind == "ball", kind
    return BallMount.model_construct(kind="ball")


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
        return TreeJoint(
            "hinge", vector_unit(mount.axis), mount.anchor, limits, **common, velocity=mount.initial_velocity
        )
    if isinstance(mount, SliderMount):
        velocity = mount.initial_velocity
        return TreeJoint("slider", vector_unit(mount.axis), range=mount.range, **common, velocity=velocity)
    assert isinstance(mount, BallMount)
    return TreeJoint("ball", anchor=mount.anchor, **common)
