"""Trees for ragdolls."""

import math

from text2sim.compiler.shapes.rotation import ORIGIN, Y_AXIS, Z_AXIS, Vec
from text2sim.compiler.trees.generators import Rgba, ball_joint, capsule_bar, capsule_mass, density_of
from text2sim.compiler.trees.tree import Tree, TreeGeom, TreeJoint, TreeLink
from text2sim.spec_schema.models.bodies import Ragdoll

# Segments of the doll as parts of its height: (name, parent, joint in parent frame, direction, length, radius, kind).
# Lengths follow Winter, Biomechanics and Motor Control of Human Movement (2009), figure 4.1, rounded.
_LIMBS = (
    ("chest", "pelvis", (0.0, 0.0, 0.06), Z_AXIS, 0.20, 0.075, "ball"),
    ("head", "chest", (0.0, 0.0, 0.29), Z_AXIS, 0.06, 0.062, "ball"),
    ("arm_l", "chest", (0.0, 0.115, 0.19), "arm", 0.16, 0.030, "ball"),
    ("forearm_l", "arm_l", None, "arm", 0.16, 0.025, "elbow"),
    ("arm_r", "chest", (0.0, -0.115, 0.19), "arm", 0.16, 0.030, "ball"),
    ("forearm_r", "arm_r", None, "arm", 0.16, 0.025, "elbow"),
    ("thigh_l", "pelvis", (0.0, 0.052, -0.03), "leg", 0.22, 0.043, "ball"),
    ("shin_l", "thigh_l", None, "leg", 0.23, 0.033, "knee"),
    ("thigh_r", "pelvis", (0.0, -0.052, -0.03), "leg", 0.22, 0.043, "ball"),
    ("shin_r", "thigh_r", None, "leg", 0.23, 0.033, "knee"),
)


def ragdoll_tree(doll: Ragdoll, colors: dict[str, Rgba]) -> Tree:
    """Return a doll of eleven capsules: ball joints at waist, neck, shoulders and hips, hinges at elbows and knees.

    Args:
        doll: The body.
        colors: rgba by link name; the key `""` is for all others.
    """
    h = doll.height
    sizes = {"pelvis": (0.10 * h, 0.065 * h)} | {name: (length * h, r * h) for name, _, _, _, length, r, _ in _LIMBS}
    density = density_of(doll.material, sum(capsule_mass(r, length, 1.0) for length, r in sizes.values()))

    def geom(name: str, direction: Vec) -> TreeGeom:
        length, radius = sizes[name]
        if name == "pelvis":
            start, end = (0.0, -length / 2, 0.0), (0.0, length / 2, 0.0)
        else:
            start, end = ORIGIN, tuple(length * d for d in direction)
        rgba = colors.get(name, colors.get(""))
        return capsule_bar(length, radius, density, doll.material.friction, rgba, start, end)  # type: ignore[arg-type]

    def limb(name: str) -> tuple[TreeLink, ...]:
        found = []
        for child, parent, at, toward, length, radius, kind in _LIMBS:
            if parent != name:
                continue
            direction = _direction(toward, child, doll.limb_spread)
            if at is None:
                parent_length, _ = sizes[parent]
                pos = tuple(parent_length * d for d in _direction(toward, parent, doll.limb_spread))
            else:
                pos = tuple(h * x for x in at)
            mass = capsule_mass(radius * h, length * h, density)
            joint = ball_joint(doll.joint, mass, length * h, damping=1.0)
            if kind != "ball":
                # Elbows bend forwards, knees backwards; both a little at the start, off their limit.
                bend = (0.0, math.radians(140)) if kind == "knee" else (math.radians(-140), 0.0)
                joint = TreeJoint("hinge", axis=Y_AXIS, range=bend, damping=joint.damping, armature=joint.armature)
            found.append(
                TreeLink(child, pos=pos, joint=joint, geoms=(geom(child, direction),), children=limb(child))  # type: ignore[arg-type]
            )
        return tuple(found)

    root = TreeLink("pelvis", joint=TreeJoint("free"), geoms=(geom("pelvis", Y_AXIS),), children=limb("pelvis"))
    return Tree((root,))


def _direction(toward: str | Vec, name: str, spread: float) -> Vec:
    if not isinstance(toward, str):
        return toward
    side = 1.0 if name.endswith("_l") else -1.0
    angle = spread * (math.radians(80) if toward == "arm" else math.radians(40))
    return (0.0, side * math.sin(angle), -math.cos(angle))
