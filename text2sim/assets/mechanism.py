"""Articulated bodies from MJCF and URDF files, checked and prepared for a program."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from text2sim.assets.engine_files import PREFIX, asset_folder
from text2sim.spec_schema.errors import AssetError

Vec = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

KIND_BY_SUFFIX = {".xml": "mjcf", ".mjcf": "mjcf", ".urdf": "urdf"}
ROOT_TAGS = {"mjcf": "mujoco", "urdf": "robot"}


@dataclass(frozen=True)
class MechanismMotor:
    """The motor of a joint in the file."""

    stiffness: float
    damping: float
    limit: float | None
    """Largest force [N or N m]."""


@dataclass(frozen=True)
class MechanismJoint:
    """A joint between a link and its parent."""

    name: str
    link: str
    kind: str
    """hinge, slider, ball or free."""
    axis: Vec
    anchor: Vec
    """Position in the link's frame [m]."""
    range: tuple[float, float] | None
    """Limits of the position [rad or m]."""
    damping: float
    friction: float
    armature: float
    spring: float
    motor: MechanismMotor | None
    limit: float | None
    """Largest force [N or N m] of any motor on it."""


@dataclass(frozen=True)
class MechanismGeom:
    """A shape of a link."""

    kind: str
    """sphere, capsule, ellipsoid, cylinder, box or mesh."""
    pos: Vec
    quat: Quaternion
    size: Vec
    """Radius and half lengths [m]."""
    touches: bool
    corners: tuple[Vec, ...]
    """Corners of a mesh [m], in the geom's frame."""


@dataclass(frozen=True)
class MechanismLink:
    """A link; the first of a mechanism is the world."""

    name: str
    parent: int
    """Index of its parent."""
    pos: Vec
    quat: Quaternion
    mass: float
    """Mass [kg]."""
    geoms: tuple[MechanismGeom, ...]


@dataclass(frozen=True)
class Mechanism:
    """The articulated body of a file, with everything that a program needs."""

    kind: str
    """mjcf or urdf."""
    links: tuple[MechanismLink, ...]
    """Parents before children."""
    joints: tuple[MechanismJoint, ...]
    loops: int
    """Number of equality constraints."""
    text: str
    """The document, reduced to what the engine reads, with names for all links and joints."""
    files: tuple[tuple[str, bytes], ...]
    """Meshes and pictures, by their names in the document."""
    sources: tuple[str, ...]
    """Paths of these files and of the document in the case's folder; those of the engine begin with `genesis:`."""
    inertialess: bool
    """Whether the mass of some link follows from its shape and density."""
    notes: tuple[str, ...]
    """Omissions and additions, in words."""

    @property
    def link_names(self) -> tuple[str, ...]:
        """Names of the links, without the world."""
        return tuple(link.name for link in self.links[1:])

    @property
    def mass(self) -> float:
        """Mass [kg] of the links whose mass is in the file."""
        return sum(link.mass for link in self.links)


Mechanisms = dict[tuple[str, str | None], Mechanism]
"""By file and base."""


def load_mechanism(folder: Path, file: str, *, base: str | None = None) -> Mechanism:
    """Read an articulated body from the case's folder, or from the engine's assets.

    No file outside of that folder is opened. MuJoCo parses in a child process, from bytes that are read here.

    Args:
        folder: The case's folder.
        file: Path inside it, or `genesis:` and a path inside the assets, ending in .xml (MJCF) or .urdf.
        base: `fixed` or `free`; that of the file if None.

    Raises:
        AssetError: if it cannot be used, with the reason and advice.
    """
    try:
        try:
            return _load(folder, file, base)
        except (OSError, RuntimeError) as error:  # no permission, a long name, a cycle of links
            raise AssetError(f"cannot be read: {getattr(error, 'strerror', None) or error}") from None
        except (ValueError, LookupError, TypeError, ArithmeticError, AttributeError) as error:
            # An untrusted document can break the readers in many ways; the message blames the document.
            raise AssetError(f"cannot be read ({type(error).__name__}: {str(error)[:120]})") from error
    except AssetError as error:
        message = str(error)
        if not message.startswith(f"`{file}`"):
            # A problem of another file is reported as one of this file, which refers to it.
            message = f"`{file}` " + re.sub(r"^(`[^`]*`) ", r"refers to \1, which ", message)
        raise AssetError(message) from None


def _load(folder: Path, file: str, base: str | None) -> Mechanism:
    # Imported here, because most cases have no such file.
    from text2sim.assets.bundle import Bundle, path_inside
    from text2sim.assets.inspection import inspect_model
    from text2sim.assets.markup import parse_markup
    from text2sim.assets.mjcf import read_mjcf
    from text2sim.assets.urdf import mesh_names, read_urdf

    if not file or file.startswith(("/", "~")) or "\\" in file or "\0" in file or "://" in file:
        raise AssetError("must be a path inside the case's folder, with forward slashes")
    source = asset_folder(folder, file)
    root = source.root
    path = path_inside(source, root / source.file, file)
    kind = KIND_BY_SUFFIX.get(path.suffix.lower())
    if kind is None:
        raise AssetError(f"must end in {', '.join(KIND_BY_SUFFIX)} (got {path.suffix or 'no suffix'})")
    if not path.is_file():
        raise AssetError("does not exist in the case's folder")
    document = parse_markup(path)
    if document.tag != ROOT_TAGS[kind]:
        raise AssetError(f"begins with <{document.tag}>; {kind.upper()} begins with <{ROOT_TAGS[kind]}>")
    bundle = Bundle(source, path.parent)
    draft = (read_mjcf if kind == "mjcf" else read_urdf)(document, bundle, base)
    files = tuple(bundle.files.items())
    read = {name for name, _ in files} if kind == "mjcf" else mesh_names(draft.text)
    model = inspect_model(kind, draft.text, tuple((name, content) for name, content in files if name in read))
    prefix = "" if source.own else PREFIX
    sources = (file, *(f"{prefix}{source.relative_to(root).as_posix()}" for source in bundle.sources))
    return Mechanism(
        kind=kind,
        links=_links(model),
        joints=tuple(_joint(joint, model, draft.limits) for joint in model["joints"]),
        loops=model["loops"] + draft.text.count("<mimic "),
        text=draft.text,
        files=files,
        sources=sources,
        inertialess=draft.inertialess,
        notes=tuple(draft.notes),
    )


def _links(model: dict[str, Any]) -> tuple[MechanismLink, ...]:
    geoms: list[list[MechanismGeom]] = [[] for _ in model["bodies"]]
    for geom in model["geoms"]:
        pos, quat, size = _vec(geom["pos"]), _quat(geom["quat"]), _vec(geom["size"])
        corners = tuple(map(_vec, geom["corners"]))
        geoms[geom["body"]].append(MechanismGeom(geom["kind"], pos, quat, size, geom["touches"], corners))
    return tuple(
        MechanismLink(body["name"], body["parent"], _vec(body["pos"]), _quat(body["quat"]), body["mass"], tuple(own))
        for body, own in zip(model["bodies"], geoms, strict=True)
    )


def _joint(joint: dict[str, Any], model: dict[str, Any], limits: dict[str, float]) -> MechanismJoint:
    motor = joint["motor"]
    return MechanismJoint(
        name=joint["name"],
        link=model["bodies"][joint["body"]]["name"],
        kind=joint["kind"],
        axis=_vec(joint["axis"]),
        anchor=_vec(joint["pos"]),
        range=None if joint["range"] is None else (joint["range"][0], joint["range"][1]),
        damping=joint["damping"],
        friction=joint["friction"],
        armature=joint["armature"],
        spring=joint["spring"],
        motor=None if motor is None else MechanismMotor(**motor),
        limit=limits.get(joint["name"], motor["limit"] if motor else None),
    )


def _vec(values: list[float]) -> Vec:
    return (values[0], values[1], values[2])


def _quat(values: list[float]) -> Quaternion:
    return (values[0], values[1], values[2], values[3])
