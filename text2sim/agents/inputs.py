"""Input files of a request: repaired, checked, registered in the case's manifest, and described to the agents."""

import re
from collections.abc import Sequence
from pathlib import Path

from text2sim.agents.journal import Emit
from text2sim.asset_intake.register import add
from text2sim.assets.manifest import Asset, Control, read_manifest, register
from text2sim.assets.safe_write import FOLDER
from text2sim.compiler.shapes.sketching import strokes
from text2sim.spec_schema.errors import AssetError, MachineError, RunError, SpecError
from text2sim.spec_schema.whole_files import write_atomically

LARGEST_INPUT = 100_000_000
"""Largest file that comes with a request [bytes]."""
ACTUATED = ("hinge", "slider")
MAX_PIECES, MAX_CORNERS, OUTLINE_TOLERANCE = 12, 24, 0.004
"""Largest numbers of pieces of a drawing and of corners of each, and tolerance of their outlines [image heights]."""


def copy_input(file: Path, folder: Path) -> Path:
    """Copy an input file of a request into a folder of the case under a safe name, and return its new path.

    Raises:
        RunError: If the file is too large, or another file has its name.
    """
    if file.stat().st_size > LARGEST_INPUT:
        raise RunError(f"{file}: larger than {LARGEST_INPUT / 1e6:g} MB")
    folder.mkdir(parents=True, exist_ok=True)
    target = folder / (re.sub(r"[^A-Za-z0-9_.-]+", "_", file.name).lstrip(".-") or "file")
    content = file.read_bytes()
    if target.exists() and target.read_bytes() != content:
        raise RunError(f"{target}: another file has this name")
    write_atomically(target, content)
    return target


def add_inputs(case: Path, files: Sequence[Path], licence: str) -> list[str]:
    """Add files to a case, and return their asset names.

    Args:
        case: The case folder.
        files: Meshes, mechanisms and pictures, which are copied.
        licence: Licence of the files.

    Raises:
        RunError: If a file cannot be used; the message says why.
    """
    names: list[str] = []
    for file in files:
        name = _name(file, [*names, *_existing_names(case)])
        try:
            add(case, file, name, licence=licence, source="user")
        except (AssetError, SpecError) as error:
            raise RunError(f"{file}: {' '.join(str(error).split())}") from None
        names.append(name)
    return names


def probe_joints(case: Path, names: Sequence[str], emit: Emit) -> None:
    """Drive each joint of the mechanisms a little in the engine and record its response, unless that is known.

    Args:
        case: The case folder.
        names: Names of assets in its manifest.
        emit: Callback for journal events.
    """
    from text2sim.asset_intake.probe import probe

    manifest = read_manifest(case)
    for name in names:
        asset = manifest.assets[name]
        joints = [one for one in asset.control.values() if one.kind in ACTUATED]
        if asset.kind not in ("mjcf", "urdf") or not joints or any(one.moved is not None for one in joints):
            continue
        emit("stage", live=True, name=f"probe {name}")
        try:
            found = probe(case / asset.file, case)
        except (AssetError, MachineError) as error:
            register(case, name, asset.model_copy(update={"notes": (*asset.notes, f"not probed: {error}")}))
            continue
        lent = tuple(f"`{joint}` has no motor; the actuator beside it is a proposal" for joint in found.given)
        stuck = tuple(f"`{joint}` did not answer the probe" for joint, one in found.joints.items() if not one.answers)
        notes = (*asset.notes, *lent, *stuck)
        register(case, name, asset.model_copy(update={"control": dict(found.control), "notes": notes}))


def describe_assets(case: Path, names: Sequence[str]) -> tuple[str, ...]:
    """Describe the assets: what they are, how to use them, and their controls."""
    assets = read_manifest(case).assets
    return tuple(_asset_in_words(assets[name]) + _describe_drawing(case, assets[name]) for name in names)


def _asset_in_words(asset: Asset) -> str:
    size = " x ".join(f"{side:.3g}" for side in asset.size) + " m" if asset.size else ""
    notes = f" Notes: {'; '.join(asset.notes)}." if asset.notes else ""
    licence = f" Licence: {asset.licence}." if asset.licence else ""
    if asset.kind == "texture":
        return f"`{asset.file}`: a picture, {'; '.join(asset.notes)}.{licence}"
    if asset.kind == "mesh":
        closed = (
            "closed: it can be rigid, static or soft"
            if asset.closed
            else "not closed: it can be rigid or static, or cloth, but not soft"
        )
        use = f"`shape: {{kind: mesh, file: {asset.file}}}`, whose `scale` makes it larger or smaller"
        return (
            f"`{asset.file}`: a mesh, {size}, {asset.triangles:,} triangles, {closed}; use it as {use}.{licence}{notes}"
        )
    joints = "; ".join(describe_joint(name, one) for name, one in asset.control.items()) or "none that moves"
    return (
        f"`{asset.file}`: a mechanism, {size}; use it as `kind: articulated, file: {asset.file}`. Joints: "
        f"{joints}.{licence}{notes}"
    )


def _describe_drawing(case: Path, asset: Asset) -> str:
    """Describe the outlines in a drawing; empty for a photograph or a drawing of many pieces."""
    if asset.kind != "texture":
        return ""
    try:
        forms = [stroke.form for stroke in strokes(asset.file, case)]
    except AssetError:
        return ""
    if len(forms) > MAX_PIECES:
        return ""
    rows = []
    for number, form in enumerate(forms):
        line, away = form.exterior, OUTLINE_TOLERANCE
        while len((line := form.exterior.simplify(away)).coords) > MAX_CORNERS + 1:
            away *= 1.5
        corners = ", ".join(f"({x:.3g}, {z:.3g})" for x, z in list(line.coords)[:-1])
        rows.append(f"part {number}: {corners}")
    wide = max(form.bounds[2] for form in forms)
    return (
        f" Of what is drawn in it, {wide:.3g} wide and 1 high, the outlines (x, z) from its lower left corner, to be "
        f"multiplied by a height: {'; '.join(rows)}. It is a solid as `shape: {{kind: sketch, file: {asset.file}}}`."
    )


def describe_joint(name: str, one: Control) -> str:
    """Describe a joint and its response when it was driven."""
    span = "" if one.range is None else f" {one.range[0]:.3g} to {one.range[1]:.3g} {one.unit}"
    motor = ""
    if one.actuator is not None:
        force = f", at most {one.actuator.max_force:g}" if one.actuator.max_force else ""
        motor = f", stiffness {one.actuator.stiffness:g}, damping {one.actuator.damping:g}{force}"
    moved = f", moved {one.moved:.3g} of {one.target:.3g} {one.unit}" if None not in (one.moved, one.target) else ""
    return f"`{name}` ({one.kind}{span}{motor}{moved})"


def _existing_names(case: Path) -> list[str]:
    """Return the names of the case's existing assets, which are never replaced."""
    folder = case / FOLDER
    lying = [path.stem for path in folder.iterdir()] if folder.is_dir() else []
    return [*read_manifest(case).assets, *lying]


def _name(file: Path, taken: Sequence[str]) -> str:
    """Return an asset name for a file: its stem in allowed characters, numbered if taken."""
    word = re.sub(r"\W+", "_", file.stem, flags=re.ASCII).strip("_") or "input"
    word = (word if word[0].isalpha() else f"input_{word}")[:40]
    names = [word, *(f"{word}_{k}" for k in range(2, len(taken) + 3))]
    return next(name for name in names if name not in taken)
