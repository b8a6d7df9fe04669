"""Articulated bodies from files: what a mechanism becomes in a plan."""

from collections.abc import Iterator
from typing import Any

from text2sim.assets.mechanism import Mechanism, MechanismGeom, MechanismJoint, MechanismLink
from text2sim.compiler.plan import JointChange, Motor
from text2sim.compiler.shapes.piece import Piece
from text2sim.compiler.trees.joints import joint_model
from text2sim.compiler.trees.tree import Tree, TreeGeom, TreeJoint, TreeLink
from text2sim.spec_schema.models.bodies import Articulated, BallMount, HingeMount, JointOverride, SliderMount
from text2sim.spec_schema.models.materials import Actuator
from text2sim.spec_schema.names.name_table import Parts
from text2sim.spec_schema.names.selectors import keys_for, spread_over


def mechanism_tree(mechanism: Mechanism, body: Articulated) -> Tree:
    """Return the links, joints and shapes of a file's body, as far as the rest of the compiler needs them.

    Shapes that are only drawn are left out, unless nothing else is there.
    """
    touching = any(geom.touches for link in mechanism.links for geom in link.geoms)

    def shapes(link: MechanismLink) -> tuple[TreeGeom, ...]:
        return tuple(geom_of(geom) for geom in link.geoms if geom.touches or not touching)

    initial = spread_over([j.name for j in mechanism.joints if j.kind in ("hinge", "slider")], body.initial)
    # Parents come before children: in reverse order, every link finds its children made.
    children: dict[int, list[TreeLink]] = {}
    for index in range(len(mechanism.links) - 1, 0, -1):
        link = mechanism.links[index]
        joints = tuple((joint.name, _joint(joint)) for joint in mechanism.joints if joint.link == link.name)
        if link.parent == 0 and mechanism.kind == "urdf" and body.base == "free":
            joints = ((link.name, TreeJoint("free")),)
        own = tuple(reversed(children.get(index, ())))
        tree_link = TreeLink(link.name, link.pos, link.quat, joints=joints, geoms=shapes(link), children=own)
        children.setdefault(link.parent, []).append(tree_link)
    roots = tuple(reversed(children.get(0, ())))
    return Tree(roots, fixtures=shapes(mechanism.links[0]), initial=initial)


def _joint(joint: MechanismJoint) -> TreeJoint:
    return TreeJoint(
        joint.kind, joint.axis, joint.anchor, joint.range, joint.damping, joint.friction, joint.armature, joint.spring
    )


def geom_of(geom: MechanismGeom) -> TreeGeom:
    """Return a shape of a file's body as a convex piece."""
    size = geom.size
    sizes = {
        "box": tuple(2 * half for half in size),
        "sphere": size[:1],
        "cylinder": (size[0], 2 * size[1]),
        "capsule": (size[0], 2 * size[1]),
        "ellipsoid": size,
        "mesh": (1.0,),
    }
    piece = Piece(geom.kind, geom.pos, geom.quat, sizes[geom.kind], geom.corners)
    return TreeGeom(piece, 0.0, 0.0, touches=geom.touches)


def joint_change(body: Articulated, name: str) -> JointOverride | None:
    """Return what the case changes about a joint; its own name overrides patterns."""
    found: dict[str, Any] = {}
    for key in keys_for(name, body.joints):
        found |= {field: getattr(body.joints[key], field) for field in body.joints[key].model_fields_set}
    return JointOverride.model_construct(**found) if found else None


def mechanism_parts(mechanism: Mechanism, body: Articulated) -> Parts:
    """Return the links and joints of a file's body, which selectors can name."""
    return Parts(mechanism.link_names, dict(_joint_models(mechanism, body)))


def _joint_models(
    mechanism: Mechanism, body: Articulated
) -> Iterator[tuple[str, HingeMount | SliderMount | BallMount]]:
    for joint in mechanism.joints:
        change = joint_change(body, joint.name)
        actuator = change.actuator if change is not None else None
        if actuator is None and joint.motor is not None:
            # Values from a file need not keep the limits of the language.
            motor = joint.motor
            actuator = Actuator.model_construct(stiffness=motor.stiffness, damping=motor.damping, max_force=motor.limit)
        if joint.kind in ("hinge", "slider", "ball"):
            yield joint.name, joint_model(joint.kind, joint.range, actuator)


def file_motors(mechanism: Mechanism, body: Articulated, entity: str) -> list[Motor]:
    """Return the motors that the case puts on joints of a file's body; those of the file stay in the file.

    Args:
        mechanism: What the file holds.
        body: The body of the case.
        entity: Name of the entity.
    """
    motors = []
    for joint in mechanism.joints:
        change = joint_change(body, joint.name)
        actuator = change.actuator if change is not None else None
        if actuator is not None:
            limit = actuator.max_force if actuator.max_force is not None else joint.limit
            motors.append(Motor(entity, joint.name, actuator.stiffness, actuator.damping, limit))
    return motors


def file_changes(mechanism: Mechanism, body: Articulated, entity: str) -> list[JointChange]:
    """Return how the case changes the passive joints of a file's body.

    Args:
        mechanism: What the file holds.
        body: The body of the case.
        entity: Name of the entity.
    """
    rows = [
        JointChange(entity, joint.name, change.damping, change.friction, change.armature, change.spring)
        for joint in mechanism.joints
        if (change := joint_change(body, joint.name)) is not None
    ]
    return [row for row in rows if (row.damping, row.friction, row.armature, row.spring) != (None,) * 4]
