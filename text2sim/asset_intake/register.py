"""Registration of assets in a case: repaired, checked, copied into its folder, listed in its manifest."""

import re
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

from text2sim.assets.engine_files import PREFIX, locate_in_root
from text2sim.assets.foreign_files import printable_line
from text2sim.assets.manifest import MAX_JOINT_NAME, MAX_JOINTS, Asset, Extent, Origin, register
from text2sim.assets.mechanism import KIND_BY_SUFFIX, load_mechanism
from text2sim.assets.mesh_intake import SUFFIXES as MESHES
from text2sim.assets.mesh_repair import RepairGoal
from text2sim.assets.meshes import RepairedFile, repair_mesh
from text2sim.assets.meshy import Meshy, Order3D
from text2sim.assets.safe_write import FOLDER, NAME, case_folder, digest, read_file, write_asset
from text2sim.spec_schema.errors import AssetError

PICTURES = (".png", ".jpg", ".jpeg")
MAX_PIXELS = 8192
MESHY_LICENCE = "terms of the Meshy account's plan"


@dataclass(frozen=True)
class AddedAsset:
    """An asset that was added to a case."""

    name: str
    asset: Asset
    remains: tuple[str, ...] = ()
    """Remaining problems, in words."""


def add(
    case: Path,
    file: Path,
    name: str,
    *,
    goal: RepairGoal | None = None,
    licence: str = "",
    source: Origin = "imported",
    root: Path | None = None,
) -> AddedAsset:
    """Add a file to a case: a mesh, a mechanism with all of its files, or a picture.

    Args:
        case: The case's folder, or the file in it.
        file: The file, in any folder; it is not changed.
        name: Name of the asset.
        goal: Goal of the repair of a mesh.
        licence: Terms of use.
        source: Origin of the file.
        root: The folder with all files of a mechanism; that of the file if None.

    Raises:
        AssetError: if it cannot be used.
        SpecError: if the manifest is not valid.
    """
    check_name(name)
    folder = case_folder(case)
    suffix = file.suffix.lower()
    if suffix in MESHES:
        return _add_mesh(folder, name, repair_mesh(file, goal), source, licence)
    if suffix in KIND_BY_SUFFIX:
        return _add_mechanism(folder, locate_in_root(file, root), name, licence, source)
    if suffix in PICTURES:
        return _add_picture(folder, file, name, licence, source)
    known = ", ".join((*MESHES, *KIND_BY_SUFFIX, *PICTURES))
    raise AssetError(f"`{file.name}` must end in one of {known}")


def generate(case: Path, name: str, order: Order3D, meshy: Meshy, *, goal: RepairGoal | None = None) -> AddedAsset:
    """Generate a mesh from text with Meshy, repair it, and add it to a case.

    Args:
        case: The case's folder, or the file in it.
        name: Name of the asset.
        order: Specification of the mesh.
        meshy: The client.
        goal: Goal of the repair.

    Raises:
        AssetError: if the result cannot be used.
        RunError: if Meshy refuses or fails, or the budget is too small.
        MachineError: if there is no answer in time; the same call continues with the same task.
    """
    check_name(name)
    folder = case_folder(case)
    content = meshy.make(order)
    with tempfile.TemporaryDirectory(prefix="text2sim-") as place:
        raw = Path(place) / f"{name}.glb"
        raw.write_bytes(content)
        repaired = repair_mesh(raw, goal)
    return _add_mesh(folder, name, repaired, "meshy", MESHY_LICENCE, order.prompt)


def check_name(name: str) -> None:
    """Check that a case can use a name.

    Raises:
        AssetError: if it cannot.
    """
    if not re.fullmatch(NAME, name):
        raise AssetError(f"`{name[:60]}` is not a name: a letter, then letters, digits or underscores (48 at most)")


def _add_mesh(
    folder: Path, name: str, repaired: RepairedFile, source: Origin, licence: str, prompt: str = ""
) -> AddedAsset:
    file, report = f"{FOLDER}/{name}{repaired.suffix}", repaired.report
    write_asset(folder, file, repaired.content)
    asset = _row(
        file, repaired.content, source, licence, (*repaired.done, *report.problems, *report.notes), kind="mesh",
        size=_rounded(report.extent), triangles=report.triangles, closed=report.watertight,
        prompt=printable_line(prompt),
    )  # fmt: skip
    register(folder, name, asset)
    return AddedAsset(name, asset, report.problems)


def _add_mechanism(folder: Path, location: tuple[Path, str], name: str, licence: str, source: Origin) -> AddedAsset:
    from text2sim.asset_intake.mechanism_check import check_mechanism

    root, file = location
    if not file.startswith(PREFIX):
        read_file(root / file)
    mechanism = load_mechanism(root, file)
    home = f"{FOLDER}/{name}"
    parts = {f"{home}/{part}": content for part, content in mechanism.files}
    document = mechanism.text.encode()
    path = f"{home}/{name}{'.urdf' if mechanism.kind == 'urdf' else '.xml'}"
    for part, content in parts.items():
        write_asset(folder, part, content)
    written = write_asset(folder, path, document)
    # The report is about the document that the case will read, not about the original.
    report = check_mechanism(written, folder)
    control = dict([row for row in report.control.items() if len(row[0]) <= MAX_JOINT_NAME][:MAX_JOINTS])
    missing = len(report.control) - len(control)
    limits = f"the manifest has no more than {MAX_JOINTS} joints with names of {MAX_JOINT_NAME} characters or fewer"
    notes = [*mechanism.notes, *report.notes, *([f"{limits}; {missing} are not listed"] if missing else [])]
    asset = _row(
        path, document, source, licence, dict.fromkeys(notes), kind=mechanism.kind, size=_rounded(report.size),
        parts={part: digest(content) for part, content in parts.items()}, control=control,
    )  # fmt: skip
    register(folder, name, asset)
    return AddedAsset(name, asset)


def _add_picture(folder: Path, file: Path, name: str, licence: str, source: Origin) -> AddedAsset:
    from PIL import Image

    content = read_file(file)
    try:
        with Image.open(BytesIO(content), formats=("PNG", "JPEG")) as picture:
            width, height = picture.size
            if max(width, height) > MAX_PIXELS:
                raise AssetError(f"`{file.name}` has {width} x {height} pixels; at most {MAX_PIXELS} along a side")
            picture.load()
            suffix = ".png" if picture.format == "PNG" else ".jpg"
    except AssetError:
        raise
    except Exception as error:  # readers of untrusted files can raise anything
        raise AssetError(f"`{file.name}` is not a readable picture ({type(error).__name__})") from None
    path = f"{FOLDER}/{name}{suffix}"
    write_asset(folder, path, content)
    asset = _row(path, content, source, licence, (f"{width} x {height} pixels",), kind="texture")
    register(folder, name, asset)
    return AddedAsset(name, asset)


def _row(file: str, content: bytes, source: Origin, licence: str, notes: Iterable[str], **more: Any) -> Asset:
    """The row of the manifest for a file with this content."""
    return Asset(
        file=file, source=source, licence=printable_line(licence), sha256=digest(content), bytes=len(content),
        notes=tuple(map(printable_line, notes)), **more,
    )  # fmt: skip


def _rounded(size: Extent) -> Extent:
    x, y, z = (float(f"{length:.6g}") for length in size)
    return (x, y, z)
