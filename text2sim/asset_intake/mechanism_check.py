"""Checks of mechanisms without the engine: structure, joints, a picture."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from text2sim.asset_intake.tiny_case import BODY, first_of, tiny_case
from text2sim.assets.engine_files import locate_in_root
from text2sim.assets.manifest import Control, Motor
from text2sim.assets.mechanism import KIND_BY_SUFFIX
from text2sim.spec_schema.errors import AssetError, SpecError

if TYPE_CHECKING:
    from text2sim.compiler.build import Resolution

SCENE = {"duration": 1.0}
PREVIEW_SIZE = (640, 480)
"""Width and height [pixels]."""


@dataclass(frozen=True)
class MechanismReport:
    """Properties of a mechanism."""

    kind: str
    """mjcf, urdf, or `body` if it is written in the language."""
    links: tuple[str, ...]
    control: Mapping[str, Control]
    """Movable joints by name."""
    loops: int
    """Number of constraints that close loops."""
    mass: float
    """Mass [kg]."""
    size: tuple[float, float, float]
    """Extent [m] at the start."""
    files: tuple[str, ...]
    """Paths of its files inside its folder."""
    notes: tuple[str, ...]
    """Omissions, additions and doubts, in words."""

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain data."""
        return asdict(self) | {"control": {n: c.model_dump(mode="json") for n, c in self.control.items()}}


@dataclass(frozen=True)
class Subject:
    """A mechanism as a body of a case."""

    folder: Path
    """Folder of its files."""
    body: Mapping[str, Any]

    @classmethod
    def of(cls, what: Path | Mapping[str, Any], folder: Path | None = None) -> "Subject":
        """Return a subject.

        Args:
            what: An MJCF or URDF file, or the data of an `articulated` body.
            folder: The folder with all of its files; that of the file if None.

        Raises:
            AssetError: if it is neither.
        """
        if not isinstance(what, Path):
            if what.get("kind") != "articulated":
                raise AssetError("a mechanism is a body of kind `articulated`, or an MJCF or URDF file")
            return cls(folder or Path("."), dict(what))
        if what.suffix.lower() not in KIND_BY_SUFFIX:
            raise AssetError(f"`{what.name}` is not a mechanism; it must end in one of {', '.join(KIND_BY_SUFFIX)}")
        root, file = locate_in_root(what, folder)
        return cls(root, {"kind": "articulated", "file": file, "base": "fixed"})


def check_mechanism(what: Path | Mapping[str, Any], folder: Path | None = None) -> MechanismReport:
    """Return a report on a mechanism; see `Subject.of`.

    MuJoCo and a URDF reader check its structure, the compiler its use in a case.

    Raises:
        AssetError: if it cannot be used, with the reasons.
    """
    return report_of(resolve_subject(Subject.of(what, folder)))


def draw_preview(what: Path | Mapping[str, Any], folder: Path | None = None) -> bytes:
    """Return a picture of a mechanism at its start, as a PNG.

    Args:
        what: An MJCF or URDF file, or the data of an `articulated` body.
        folder: The folder with all of its files; that of the file if None.

    Raises:
        AssetError: if it cannot be used.
    """
    from text2sim.drawing.portrait import portrait

    return portrait(resolve_subject(Subject.of(what, folder)), PREVIEW_SIZE)


def resolve_subject(subject: Subject) -> "Resolution":
    """Return a resolved case with only this mechanism.

    Raises:
        AssetError: if it cannot be used.
    """
    from text2sim.compiler.build import resolve_case

    loaded = tiny_case(subject.folder, subject.body, SCENE)
    try:
        return resolve_case(loaded)
    except SpecError as error:
        raise AssetError(first_of(error)) from None


def report_of(resolution: "Resolution") -> MechanismReport:
    """Return a report on the mechanism of a resolved case."""
    from text2sim.compiler.masses import masses
    from text2sim.compiler.trees.tree import tree_bounds

    body: Any = resolution.loaded.case.bodies[BODY]
    mechanism = resolution.lowering.mechanisms.get((body.file, body.base)) if body.file else None
    tree = resolution.lowering.trees[BODY]
    motors = {motor.joint: motor for motor in resolution.lowering.motors}
    control: dict[str, Control] = {}
    notes: list[str] = []
    for link in tree.links():
        for name, joint in link.all_joints():
            if joint.kind not in ("hinge", "slider", "ball"):
                continue
            motor = _motor(motors.get(name), None if mechanism is None else _file_motor(mechanism, name))
            span = None if joint.range is None else (min(joint.range), max(joint.range))
            unit = "m" if joint.kind == "slider" else "rad"
            control[name] = Control(kind=joint.kind, unit=unit, range=span, actuator=motor)
            if not name.isidentifier() or not name.isascii():
                notes.append(f"joint `{name}` has a name that a case cannot use; only use letters, digits and _")
    if not control:
        notes.append("has no movable joint")
    elif not any(joint.actuator for joint in control.values()):
        notes.append("has no motor: give its joints actuators (`joints`), or let them swing")
    low, high = tree_bounds(tree, (1.0, 0.0, 0.0, 0.0))
    return MechanismReport(
        kind=mechanism.kind if mechanism else "body",
        links=mechanism.link_names if mechanism else tuple(link.name for link in tree.links()),
        control=control,
        loops=mechanism.loops if mechanism else len(body.loops),
        mass=masses(resolution).get(BODY, 0.0),
        size=(high[0] - low[0], high[1] - low[1], high[2] - low[2]),
        files=mechanism.sources if mechanism else (),
        notes=(*(mechanism.notes if mechanism else ()), *notes),
    )


def _file_motor(mechanism: Any, name: str) -> Any:
    return next((joint.motor for joint in mechanism.joints if joint.name == name), None)


def _motor(written: Any, of_file: Any) -> Motor | None:
    if written is not None:
        return Motor(stiffness=written.stiffness, damping=written.damping, max_force=written.max_force)
    if of_file is None:
        return None
    limit = of_file.limit if of_file.limit and of_file.limit > 0 else None
    return Motor(stiffness=max(of_file.stiffness, 0.0), damping=max(of_file.damping, 0.0), max_force=limit)
