"""Reader of URDF documents, which reduces them to what the engine supports."""

import io
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree as ET

from text2sim.assets.answer_cache import cached_answer
from text2sim.assets.bundle import PICTURES, Bundle
from text2sim.assets.markup import write_markup
from text2sim.assets.mjcf import MAX_LINKS, MechanismDraft
from text2sim.spec_schema.errors import AssetError, did_you_mean
from text2sim.spec_schema.names.reference_cycles import find_cycles

if TYPE_CHECKING:
    from yourdfpy.urdf import Joint, Robot

COLLISIONS = (".obj", ".stl")
VISUALS = (".obj", ".stl", ".dae", ".glb")
KNOWN_ELEMENTS = {
    "robot": frozenset("link joint material".split()),
    "link": frozenset("inertial visual collision".split()),
    "joint": frozenset("origin parent child axis limit dynamics mimic".split()),
}
"""Elements that are kept; the engine ignores the rest (gazebo, transmission, …) or interprets it differently."""
JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed")


def read_urdf(root: ET.Element, bundle: Bundle, base: str | None) -> MechanismDraft:
    """Return the model with its files in the bundle.

    Args:
        root: Root of the document; it is changed.
        bundle: Collects the files.
        base: `free` if the world does not hold its root.

    Raises:
        AssetError: if it is not a tree of links, or has something that cannot be simulated.
    """
    if any(element.tag.startswith("xacro:") for element in root.iter()):
        raise AssetError("is a xacro document; convert it first: `xacro robot.urdf.xacro > robot.urdf`")
    for element in [root, *root]:
        if element.tag in ("robot", "link", "joint") and not element.get("name"):
            raise AssetError(f"has a {element.tag} without a name")
        for end in ("parent", "child") if element.tag == "joint" else ():
            if (link := element.find(end)) is None or not link.get("link"):
                raise AssetError(f'joint `{element.get("name")}` has no {end} link; give it `<{end} link="…"/>`')
    notes = _leave_out(root)
    notes += _draw_collisions(root)
    _take_files(root, bundle)
    text, free = write_markup(root), base == "free"
    rules = Path(__file__).read_bytes()
    question = [rules, text.encode(), b"free" if free else b"held"]
    facts = cached_answer(question, lambda: _facts(text, free=free))
    return MechanismDraft(text, notes, facts["limits"], facts["inertialess"])


def _facts(text: str, *, free: bool) -> dict[str, Any]:
    """Check a reduced document, and return what the compiler needs."""
    robot = _parse(text)
    _check_tree(robot)
    _check_joints(robot)
    _check_masses(robot, free=free)
    limits = {j.name: float(j.limit.effort or 0.0) for j in robot.joints if j.limit is not None}
    limits = {name: limit for name, limit in limits.items() if limit > 0.0}
    return {"limits": limits, "inertialess": any(link.inertial is None for link in robot.links)}


def _leave_out(root: ET.Element) -> list[str]:
    found = set()
    for parent in [root, *root]:
        for child in [
            child for child in parent if parent.tag in KNOWN_ELEMENTS and child.tag not in KNOWN_ELEMENTS[parent.tag]
        ]:
            found.add(child.tag)
            parent.remove(child)
    return [f"left out, because it is not part of a body: {', '.join(sorted(found))}"] if found else []


def _draw_collisions(root: ET.Element) -> list[str]:
    bare = []
    for link in root.iter("link"):
        if link.find("visual") is None and link.find("collision") is not None:
            bare.append(link.get("name", ""))
            for collision in link.findall("collision"):
                visual = ET.SubElement(link, "visual")
                visual.extend(child for child in collision if child.tag in ("origin", "geometry"))
    return [f"drawn with collision shapes, because there is no `<visual>`: {', '.join(bare)}"] if bare else []


def _take_files(root: ET.Element, bundle: Bundle) -> None:
    taken: set[ET.Element] = set()
    for parent, suffixes in (("collision", COLLISIONS), ("visual", VISUALS)):
        for mesh in (mesh for holder in root.iter(parent) for mesh in holder.iter("mesh")):
            # A collision shape that is drawn is the same element in both.
            if mesh in taken:
                continue
            taken.add(mesh)
            try:
                mesh.set("filename", bundle.add(mesh.get("filename", ""), suffixes, painted=parent == "visual"))
            except AssetError as error:
                raise AssetError(f"{error}" + (" for contact" if "must end" in str(error) else "")) from None
    for texture in root.iter("texture"):
        texture.set("filename", bundle.add(texture.get("filename", ""), PICTURES))


def _parse(text: str) -> "Robot":
    import yourdfpy

    try:
        urdf = yourdfpy.URDF.load(
            io.BytesIO(text.encode()), build_scene_graph=False, load_meshes=False,
            build_collision_scene_graph=False, load_collision_meshes=False,
        )  # fmt: skip
    except Exception as error:  # a reader of untrusted files can raise anything
        raise AssetError(f"is not a URDF document ({type(error).__name__}: {str(error)[:120]})") from None
    return urdf.robot


def _check_tree(robot: "Robot") -> None:
    links = [link.name for link in robot.links]
    joints = [joint.name for joint in robot.joints]
    if not 0 < len(links) <= MAX_LINKS:
        raise AssetError(f"has {len(links)} links; at least one and at most {MAX_LINKS} are possible")
    for what, names in (("link", links), ("joint", joints)):
        if len(set(names)) < len(names):
            duplicate = next(name for name in names if names.count(name) > 1)
            raise AssetError(f"has two {what}s named `{duplicate}`")
    parents: dict[str, str] = {}
    for joint in robot.joints:
        for end in (joint.parent, joint.child):
            if end not in links:
                message = f"joint `{joint.name}` refers to a link `{end}` that does not exist"
                raise AssetError(message + did_you_mean(end, links))
        if joint.child in parents:
            raise AssetError(f"link `{joint.child}` is the child of two joints; a URDF is a tree")
        parents[joint.child] = joint.parent
    for cycle in find_cycles(parents):
        raise AssetError(f"links form a cycle: {' -> '.join([*cycle, cycle[0]])}")
    roots = [link for link in links if link not in parents]
    if len(roots) != 1:
        raise AssetError(f"has several roots ({', '.join(roots[:6])}); join them with fixed joints")


def _check_joints(robot: "Robot") -> None:
    joints = {joint.name: joint for joint in robot.joints}
    for joint in robot.joints:
        if joint.type not in JOINT_TYPES:
            remedy = "; use `base: free` for a free root" if joint.type == "floating" else ""
            kind = f"is {joint.type}" if joint.type else "has no type"
            raise AssetError(f"joint `{joint.name}` {kind}; the engine has {', '.join(JOINT_TYPES)}{remedy}")
        if joint.type == "fixed":
            continue
        if joint.axis is not None and not any(joint.axis):
            raise AssetError(f"joint `{joint.name}` has an axis of length zero")
        _check_limit(joint)
        _check_mimic(joint, joints)
    for cycle in find_cycles({joint.name: joint.mimic.joint for joint in robot.joints if joint.mimic is not None}):
        raise AssetError(f"joints mimic each other in a cycle: {' -> '.join([*cycle, cycle[0]])}")


def _check_limit(joint: "Joint") -> None:
    if joint.type == "continuous":
        return
    limit = joint.limit
    if limit is None:
        raise AssetError(f"joint `{joint.name}` ({joint.type}) has no `<limit>`")
    if limit.lower is not None and limit.upper is not None and limit.lower > limit.upper:
        raise AssetError(f"joint `{joint.name}` has a lower limit ({limit.lower:g}) above its upper ({limit.upper:g})")


def _check_mimic(joint: "Joint", joints: dict[str, Any]) -> None:
    if joint.mimic is not None and (joint.mimic.joint not in joints or joints[joint.mimic.joint].type == "fixed"):
        raise AssetError(f"joint `{joint.name}` mimics `{joint.mimic.joint}`, which is not a movable joint")


def _check_masses(robot: "Robot", *, free: bool) -> None:
    import numpy as np

    fixed = {joint.child for joint in robot.joints if joint.type == "fixed"}
    for link in robot.links:
        if link.inertial is None:
            continue
        mass, inertia = link.inertial.mass or 0.0, link.inertial.inertia
        if mass < 0 or not math.isfinite(mass):
            raise AssetError(f"link `{link.name}` has a mass of {mass:g} kg")
        if inertia is None:
            continue
        low, middle, high = np.linalg.eigvalsh(0.5 * (inertia + inertia.T))
        # The engine's tolerances for rounding. A fixed link is merged with its parent, and need not be possible alone.
        impossible = low + middle < high * (1 - 1e-6) - 1e-9 and link.name not in fixed
        if low < -1e-6 * high - 1e-9 or impossible:
            raise AssetError(
                f"link `{link.name}` has an inertia that no body can have (principal moments {low:.3g}, "
                f"{middle:.3g}, {high:.3g} kg m2); correct it, or remove its `<inertial>`, so that shape and "
                "density give it"
            )
    _check_moving(robot, free=free)


def _check_moving(robot: "Robot", *, free: bool) -> None:
    """Refuse a movable link that has no mass, nor have its descendants."""
    parents = {joint.child: joint.parent for joint in robot.joints}
    heavy: set[str | None] = {None}
    for link in robot.links:
        own = bool(link.collisions or link.visuals) if link.inertial is None else (link.inertial.mass or 0.0) > 0
        name: str | None = link.name if own else None
        while name not in heavy:
            heavy.add(name)
            name = parents.get(str(name))
    moving = [joint.child for joint in robot.joints if joint.type != "fixed"]
    if free:
        moving += {link.name for link in robot.links} - {joint.child for joint in robot.joints}
    for name in moving:
        if name not in heavy:
            raise AssetError(f"link `{name}` is movable and has no mass; give it an `<inertial>` or a shape")


def mesh_names(text: str) -> set[str]:
    """Return the names of the mesh files of collision shapes in a reduced document."""
    root = ET.fromstring(text)
    return {Path(mesh.get("filename", "")).name for c in root.iter("collision") for mesh in c.iter("mesh")}
