"""Trees as MJCF text, the format in which the engine reads mechanisms."""

from collections.abc import Iterable
from xml.etree import ElementTree as ET

from text2sim.compiler.shapes.rotation import IDENTITY
from text2sim.compiler.trees.tree import Tree, TreeGeom, TreeLink, TreeVisual

# The engine reads MuJoCo's collision masks within one model only: 1 and 2 keep a model's own links apart
# while everything else still touches them.
_MASKS = {True: {}, False: {"contype": "1", "conaffinity": "2"}}
# Pieces of a link with equal masks would be merged into one mesh before it is decomposed.
_APART = {True: {"contype": "3", "conaffinity": "3"}, False: {"contype": "4", "conaffinity": "8"}}
# Impedance d. Constraints give way in proportion to force / mass (1 - d) / d. With d = 0.9, which is usual, a rack of
# 20 kg sags by 18 mm on a pinion of 50 g, and what dry friction should hold creeps by a centimetre a second. Links
# joined at points keep it: the net of cases/catch_net ends in nan when it is hit, if it is as firm.
_FIRM = "0.9999 0.9999"
# The engine takes that of dry friction from the limit of the joint, MuJoCo from an attribute of its own.
_FIRM_FRICTION = {"solimplimit": _FIRM, "solimpfriction": _FIRM}
_UNTOUCHED = {"contype": "0", "conaffinity": "0"}


def number(value: float) -> str:
    """Return a number with nine digits; rounding errors around zero become 0."""
    return "0" if abs(value) < 1e-12 else f"{value:.9g}"


def _row(values: Iterable[float]) -> str:
    return " ".join(number(v) for v in values)


def write_mjcf(tree: Tree, model: str, meshes: dict[str, str]) -> str:
    """Return the tree as an MJCF document, indented, with stable order.

    Args:
        tree: The mechanism.
        model: Its name.
        meshes: File name (in the model's folder) of every drawn mesh by `VisualMesh.digest`, of its picture
            by `VisualMesh.digest` and `.png`, and of every mesh that touches by `Piece.file`.
    """
    root = ET.Element("mujoco", model=model)
    ET.SubElement(root, "compiler", angle="radian", autolimits="true")
    asset = ET.SubElement(root, "asset")
    world = ET.SubElement(root, "worldbody")
    writer = _Writer(asset, meshes, self_collision=tree.self_collision)
    for index, geom in enumerate(tree.fixtures):
        writer.geom(world, f"fixture_{index}", geom)
    if not tree.fixtures and any(loop.b is None for loop in tree.loops):
        # Without a geom of its own the engine drops the world link, to which the loop is tied.
        ET.SubElement(
            world, "geom", {"name": "world_mark", "size": "0.001", **_UNTOUCHED, "mass": "0", "rgba": "0 0 0 0"}
        )
    for link in tree.roots:
        writer.link(world, link)
    equality = ET.SubElement(root, "equality")
    for loop in tree.loops:
        if loop.kind == "gear" and loop.b is not None:
            # Coefficients of a polynomial: https://mujoco.readthedocs.io/en/stable/XMLreference.html#equality-joint
            terms = _row((0.0, loop.ratio, 0.0, 0.0, 0.0))
            ET.SubElement(equality, "joint", {"joint1": loop.a, "joint2": loop.b, "polycoef": terms, "solimp": _FIRM})
            continue
        attributes = {"body1": loop.a, "anchor": _row(loop.anchor)}
        ET.SubElement(equality, loop.kind, attributes | ({"body2": loop.b} if loop.b else {}))
    for section in (asset, equality):
        if len(section) == 0:
            root.remove(section)
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


class _Writer:
    """Writes links, joints and geoms, collecting the meshes that they need."""

    def __init__(self, asset: ET.Element, meshes: dict[str, str], *, self_collision: bool) -> None:
        self.asset = asset
        self.meshes = meshes
        self.masks = _MASKS[self_collision]
        self.apart = _APART[self_collision]
        self.known: set[str] = set()

    def link(self, parent: ET.Element, link: TreeLink) -> None:
        body = ET.SubElement(parent, "body", name=link.name)
        if any(link.pos):
            body.set("pos", _row(link.pos))
        if tuple(link.quat) != IDENTITY:
            body.set("quat", _row(link.quat))
        for name, joint in link.all_joints():
            if joint.kind == "free":
                ET.SubElement(body, "freejoint", name=name)
                continue
            attributes = {"name": name, "type": {"slider": "slide"}.get(joint.kind, joint.kind)}
            if joint.kind in ("hinge", "slider"):
                attributes["axis"] = _row(joint.axis)
            if any(joint.anchor) and joint.kind != "slider":
                attributes["pos"] = _row(joint.anchor)
            if joint.range is not None:
                attributes["range"] = _row(joint.range)
            for key, value in (
                ("damping", joint.damping),
                ("frictionloss", joint.friction),
                ("armature", joint.armature),
                ("stiffness", joint.spring),
            ):
                if value:
                    attributes[key] = number(value)
            ET.SubElement(body, "joint", attributes | (_FIRM_FRICTION if joint.friction else {}))
        if link.inertia is not None:
            own = link.inertia
            moments = " ".join(f"{x:.9g}" for x in own.inertia)  # even very small ones
            ET.SubElement(body, "inertial", mass=f"{own.mass:.9g}", pos=_row(own.center), fullinertia=moments)
        for index, geom in enumerate(link.geoms):
            # The recorder reads the part of a compound from the name.
            part = f"@{geom.piece.part}" if geom.piece.part else ""
            self.geom(body, f"{link.name}_{index}{part}", geom)
        for index, visual in enumerate(link.visuals):
            self.visual(body, f"{link.name}_look_{index}", visual)
        for child in link.children:
            self.link(body, child)

    def geom(self, body: ET.Element, name: str, geom: TreeGeom) -> None:
        piece = geom.piece
        attributes = {"name": name}
        if piece.kind == "hull":
            attributes |= {"type": "mesh", "mesh": name}
            ET.SubElement(self.asset, "mesh", name=name, vertex=_row(x for v in piece.vertices for x in v))
        elif piece.kind == "mesh":
            attributes |= {"type": "mesh", "mesh": name}
            inertia = "exact" if piece.enclosed else "convex"
            asset = {"name": name, "file": self.meshes[str(piece.file)], "inertia": inertia}
            if piece.size[0] != 1.0:
                asset["scale"] = _row(piece.size * 3)
            ET.SubElement(self.asset, "mesh", asset)
        else:
            attributes |= {"type": piece.kind, "size": _row(_half_sizes(piece.kind, piece.size))}
        if any(piece.pos):
            attributes["pos"] = _row(piece.pos)
        if tuple(piece.quat) != IDENTITY:
            attributes["quat"] = _row(piece.quat)
        attributes |= {"density": number(geom.density), "friction": number(geom.friction)}
        if any(geom.torques):
            attributes |= {"friction": _row((geom.friction, *geom.torques)), "condim": "6"}
        if geom.rgba is not None:
            attributes["rgba"] = _row(geom.rgba)
        if not geom.drawn:
            attributes["group"] = "3"
        masks = self.apart if piece.collision == "decompose" else self.masks
        ET.SubElement(body, "geom", attributes | (masks if geom.touches else _UNTOUCHED))

    def visual(self, body: ET.Element, name: str, visual: TreeVisual) -> None:
        file = self.meshes[visual.mesh.digest]
        if file not in self.known:
            self.known.add(file)
            ET.SubElement(self.asset, "mesh", name=file.removesuffix(".obj"), file=file, inertia="shell")
        attributes = {
            "name": name,
            "type": "mesh",
            "mesh": file.removesuffix(".obj"),
            **_UNTOUCHED,
            "mass": "0",
            "group": "2",
        }
        if visual.rgba is None and visual.mesh.picture is not None:
            attributes["material"] = self.material(visual.mesh.digest)
        elif visual.rgba is not None:
            attributes["rgba"] = _row(visual.rgba)
        ET.SubElement(body, "geom", attributes)

    def material(self, digest: str) -> str:
        """Return the name of the material with the picture of a mesh."""
        file = self.meshes[f"{digest}.png"]
        name = file.removesuffix(".png")
        if file not in self.known:
            self.known.add(file)
            ET.SubElement(self.asset, "texture", name=name, type="2d", file=file)
            ET.SubElement(self.asset, "material", name=name, texture=name)
        return name


def _half_sizes(kind: str, size: tuple[float, ...]) -> tuple[float, ...]:
    """Return MuJoCo's sizes: half lengths of boxes, half heights of cylinders and capsules."""
    if kind == "box":
        return tuple(s / 2 for s in size)
    if kind in ("cylinder", "capsule"):
        return (size[0], size[1] / 2)
    return size
