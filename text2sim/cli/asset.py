"""The commands `text2sim asset`: meshes, mechanisms and pictures of a case."""

import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from text2sim.assets.mechanism import KIND_BY_SUFFIX
from text2sim.cli.options import AsJson, with_options
from text2sim.cli.output import say, say_json, say_problems
from text2sim.service import exits
from text2sim.spec_schema.errors import AssetError
from text2sim.spec_schema.whole_files import write_atomically

if TYPE_CHECKING:
    from text2sim.asset_intake.register import AddedAsset
    from text2sim.assets.mesh_repair import RepairGoal

asset = typer.Typer(
    help="Meshes, mechanisms and pictures of a case: checked, repaired, made, tried.",
    no_args_is_help=True,
)


class Axis(StrEnum):
    """Up axis of a file."""

    x = "x"
    y = "y"
    z = "z"


class Middle(StrEnum):
    """Position of the origin of a mesh."""

    base = "base"
    mass = "mass"
    keep = "keep"


_File = Annotated[
    Path,
    typer.Argument(metavar="FILE", help="A mesh, an MJCF or URDF file (or genesis:PATH), or a picture."),
]
_Case = Annotated[Path, typer.Argument(metavar="CASE", help="A case folder or case.yaml file.")]
_Name = Annotated[str, typer.Option("--name", metavar="NAME", help="Name of the asset and of its file.")]
_OwnName = Annotated[str, typer.Option("--name", metavar="NAME", help="Name of the asset; that of FILE if left out.")]
_Up = Annotated[
    Axis | None, typer.Option("--up", help="Axis of the file that points up; by default y in glTF, else z.")
]
_MISSING_FILE = re.compile(r"refers to `[^`]*`, which (?:does not exist|leads out|is in no folder)")
"""Words of an error that another folder may cure."""
_Root = Annotated[Path | None, typer.Option("--root", help="Folder with all its files; that of FILE if left out.")]


@dataclass(frozen=True)
class MeshOptions:
    """Options of commands that repair a mesh."""

    size: Annotated[str, typer.Option("--size", metavar="M", help="Largest extent [m]; or the height, as z=0.3.")] = ""
    origin: Annotated[Middle, typer.Option("--origin", help="Position of the origin.")] = Middle.base
    triangles: Annotated[int, typer.Option("--triangles", min=4, max=200_000, help="Largest number of triangles.")] = (
        20_000
    )
    close: Annotated[bool, typer.Option("--close", help="Close wide openings, too, as of a bowl.")] = False
    wrap: Annotated[
        bool, typer.Option("--wrap", help="Wrap a closed skin around a mesh that cannot be closed otherwise.")
    ] = False
    as_json: AsJson = False

    def goal(self, up: Axis | None = None) -> "RepairGoal":
        """Return the goal of the repair."""
        from text2sim.assets.mesh_repair import RepairGoal, parse_size

        length, along = parse_size(self.size) if self.size else (None, None)
        axis, origin = up.value if up is not None else None, self.origin.value
        return RepairGoal(length, along, axis, origin, self.triangles, openings=self.close, wrap=self.wrap)


@contextmanager
def _pointing_to_root(root: Path | None) -> Iterator[None]:
    """Add a hint about `--root` to errors about missing referenced files."""
    try:
        yield
    except AssetError as error:
        if root is not None or not _MISSING_FILE.search(str(error)):
            raise
        raise AssetError(f"{error}; use `--root DIR` if its files are in different folders of DIR") from None


@asset.command("check")
def check(
    file: _File,
    up: _Up = None,
    root: _Root = None,
    png: Annotated[Path | None, typer.Option("--png", help="Draw a picture of a mechanism to this file.")] = None,
    engine: Annotated[bool, typer.Option("--engine", help="Also run a mesh in the engine for five steps.")] = False,
    as_json: AsJson = False,
) -> None:
    """Report the properties and problems of a mesh or mechanism. Nothing is changed."""
    document: dict[str, Any]
    if file.suffix.lower() in KIND_BY_SUFFIX:
        from text2sim.asset_intake.mechanism_check import check_mechanism, draw_preview

        with _pointing_to_root(root):
            report = check_mechanism(file, root)
            if png is not None:
                write_atomically(png, draw_preview(file, root))
        document = {"ok": True, "file": str(file), **report.as_dict()}
        lines = _mechanism_lines(document)
    else:
        from text2sim.assets.meshes import check_mesh

        found = check_mesh(file, up.value if up else None)
        document = {"ok": not found.problems, "path": str(file), **found.as_dict()}
        lines = _mesh_lines(document)
        if engine:
            from text2sim.asset_intake.tiny_case import import_into_engine

            tried = import_into_engine(file)
            document |= {"engine": asdict(tried), "ok": document["ok"] and tried.ok}
            lines.append(f"engine: {'ok' if tried.ok else tried.message} ({tried.wall:.0f} s)")
    if as_json:
        say_json(document)
    for text in () if as_json else lines:
        say(text)
    raise typer.Exit(exits.OK if document["ok"] else exits.INPUT)


@asset.command("add")
@with_options(MeshOptions)
def add(
    case: _Case,
    file: _File,
    name: _OwnName = "",
    up: _Up = None,
    licence: Annotated[str, typer.Option("--licence", help="Terms of use.")] = "",
    root: _Root = None,
    *,
    options: MeshOptions,
) -> None:
    """Add a mesh, mechanism or picture to a case's folder and manifest; meshes are repaired."""
    from text2sim.asset_intake.register import add

    goal = options.goal(up)
    with _pointing_to_root(root):
        added = add(case, file, name or file.stem, goal=goal, licence=licence, root=root)
    _say_added(added, options.as_json)


@asset.command("generate")
@with_options(MeshOptions)
def generate(
    case: _Case,
    prompt: Annotated[str, typer.Argument(metavar="PROMPT", help="Description of the object.")],
    name: _Name,
    no_texture: Annotated[bool, typer.Option("--no-texture", help="Make only the shape, which costs less.")] = False,
    model: Annotated[str, typer.Option("--model", help="Meshy's model.")] = "latest",
    budget: Annotated[int, typer.Option("--budget", min=0, help="Credits that the case may cost in total.")] = 100,
    timeout: Annotated[float, typer.Option("--timeout", min=1.0, help="Time limit in seconds.")] = 900.0,
    *,
    options: MeshOptions,
) -> None:
    """Generate a mesh from text with Meshy, repair it, and add it to a case. Needs MESHY_API_KEY.

    Repeat an interrupted call with the same arguments: it resumes the same task, and nothing is paid for twice.
    """
    from text2sim.asset_intake.register import check_name, generate
    from text2sim.assets.meshy import BASE_URL, Meshy, Order3D
    from text2sim.assets.safe_write import case_folder

    check_name(name)
    goal = options.goal()
    order = Order3D(prompt, refine=not no_texture, model=model)
    base = os.environ.get("TEXT2SIM_MESHY_URL", BASE_URL)
    meshy = Meshy(
        case_folder(case), base=base, budget=budget, timeout=timeout, say=lambda text: say(text, to=sys.stderr)
    )
    _say_added(generate(case, name, order, meshy, goal=goal), options.as_json)


@asset.command("probe")
def probe(file: _File, root: _Root = None, as_json: AsJson = False) -> None:
    """Drive each joint of a mechanism a little in the engine, and report which of them respond."""
    from text2sim.asset_intake.probe import probe

    with _pointing_to_root(root):
        found = probe(file, root)
    if as_json:
        say_json(
            {
                "ok": found.ok,
                "state": found.state,
                "message": found.message,
                "joints": {name: asdict(answer) for name, answer in found.joints.items()},
                "given": found.given,
                "left_out": found.left_out,
                "control": {name: one.model_dump(mode="json") for name, one in found.control.items()},
                "wall": round(found.wall, 2),
            }
        )
    else:
        for name, answer in found.joints.items():
            unit = found.control[name].unit
            word = "responds" if answer.answers else "does not respond"
            motor = ", with a motor that the probe added" if name in found.given else ""
            say(f"{name}: {word}: {answer.moved:.3g} of {answer.target:.3g} {unit}{motor}")
        for name in found.left_out:
            say(f"{name}: not driven")
        say(f"{file.name}: {found.state}{f': {found.message}' if found.message else ''} ({found.wall:.0f} s)")
    raise typer.Exit(exits.OK if found.ok else exits.PHYSICS)


@asset.command("list")
def list_assets(case: _Case, as_json: AsJson = False) -> None:
    """List a case's assets, and check that their files match the manifest."""
    from text2sim.assets.manifest import problems_of, read_manifest, verify_manifest
    from text2sim.assets.safe_write import case_folder

    folder = case_folder(case)
    manifest = read_manifest(folder)
    found = verify_manifest(folder, manifest)
    wrong = any(found.values())
    if as_json:
        rows = {n: a.model_dump(mode="json") | {"problems": found[n]} for n, a in manifest.assets.items()}
        say_json({"ok": not wrong, "assets": rows})
    else:
        for name, one in manifest.assets.items():
            size = " x ".join(f"{length:.3g}" for length in one.size) + " m" if one.size else ""
            facts = [one.kind, one.file, size, f"{one.triangles:,} triangles" if one.triangles else "", one.source]
            say(f"{name}: {', '.join(filter(None, facts))}{'' if one.licence else '; no licence'}")
        if wrong:
            say_problems(problems_of(folder, found), {})
    raise typer.Exit(exits.INPUT if wrong else exits.OK)


def _say_added(added: "AddedAsset", as_json: bool) -> None:
    if as_json:
        say_json({"ok": True, "name": added.name, "remains": added.remains, **added.asset.model_dump(mode="json")})
        return
    say(f"{added.name}: {added.asset.file}")
    for note in added.asset.notes:
        say(f"    {note}")


def _mesh_lines(found: dict[str, Any]) -> list[str]:
    x, y, z = found["extent"]
    volume = f", {found['volume']:.3g} m3" if found["volume"] is not None else ""
    closed = "closed" if found["watertight"] else "not closed"
    return [
        f"{found['file']}: {found['triangles']:,} triangles, {x:.3g} x {y:.3g} x {z:.3g} m, {closed}{volume}",
        *(f"    wrong: {text}" for text in found["problems"]),
        *(f"    {text}" for text in found["notes"]),
    ]


def _mechanism_lines(found: dict[str, Any]) -> list[str]:
    lines = [f"{found['file']}: {found['kind']}, {len(found['links'])} links, {found['mass']:.3g} kg"]
    for name, one in found["control"].items():
        span = f" from {one['range'][0]:.3g} to {one['range'][1]:.3g} {one['unit']}" if one["range"] else ""
        lines.append(f"    {name}: {one['kind']}{span}{', with a motor' if one['actuator'] else ''}")
    return [*lines, *(f"    {text}" for text in found["notes"])]
