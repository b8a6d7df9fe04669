"""`assets/manifest.yaml`: what a case's files are, where they come from, and how they are moved."""

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, StringConstraints, ValidationError

from text2sim.assets.safe_write import FOLDER, digest, keep, only_me, place_in, read_kept
from text2sim.spec_schema.errors import AssetError, Problem, SpecError
from text2sim.spec_schema.models.base import Bool, Model, Name, NonNegative, Noun, Positive, Range
from text2sim.spec_schema.text.document import parse_document
from text2sim.spec_schema.text.source import Source, check_source, read_source
from text2sim.spec_schema.text.writing import block_lines, flow_text, key, scalar
from text2sim.spec_schema.vocabulary.diagnosis import diagnose

FILE = f"{FOLDER}/manifest.yaml"
VERSION = 1
MAX_ASSETS = 1000
HEAD = "# What lies in this folder. Written by `text2sim asset`: comments do not stay."
WIDTH = 110

Kind = Literal["mesh", "mjcf", "urdf", "texture", "mechanism", "shape"]
"""The last two are written in the language, as YAML."""
Origin = Literal["procedural", "imported", "meshy", "user"]
Text = Annotated[str, StringConstraints(max_length=2000)]
Place = Annotated[str, StringConstraints(min_length=1, max_length=300)]
Digest = Annotated[
    str, StringConstraints(pattern=r"^[0-9a-f]{64}$"), Noun("a SHA-256", "SHA-256 sums", "64 hexadecimal digits")
]
Whole = Annotated[int, Field(strict=True, ge=0)]
Extent = tuple[NonNegative, NonNegative, NonNegative]


class Motor(Model):
    """A motor on a joint, as `actuator` in a case."""

    stiffness: NonNegative = 0.0
    """[N/m or N m/rad]"""
    damping: NonNegative = 0.0
    """[N s/m or N m s/rad]"""
    max_force: Positive | None = None
    """[N or N m]; unlimited if left out."""


class Control(Model):
    """What a joint is, and what it does when it is driven."""

    kind: Literal["hinge", "slider", "ball"]
    """How it moves."""
    unit: Literal["rad", "m"]
    """Of its position."""
    range: Range | None = None
    """Lowest and highest position [rad or m]; unlimited if left out."""
    actuator: Motor | None = None
    """Its motor; a `drive` needs one."""
    target: float | None = None
    """Where the probe asked it to go [rad or m], counted from its start."""
    moved: float | None = None
    """How far it came [rad or m]."""


class Asset(Model):
    """One asset."""

    file: Place
    """Path inside the case's folder."""
    kind: Kind
    """What it is."""
    source: Origin
    """Where it comes from."""
    licence: Text = ""
    """On what terms it may be used."""
    sha256: Digest
    """Of the file."""
    bytes: Whole
    """Of the file."""
    size: Extent | None = None
    """Extent along x, y and z [m], as a case sees it."""
    triangles: Whole | None = None
    """Of a mesh."""
    closed: Bool | None = None
    """Whether a mesh encloses a volume."""
    prompt: Text = ""
    """From which words it was made."""
    notes: tuple[Text, ...] = ()
    """What was done to it, and what is doubtful."""
    parts: dict[Place, Digest] = Field(default_factory=dict, max_length=500)
    """SHA-256 of the other files that it needs, by path inside the case's folder."""
    control: dict[Annotated[str, StringConstraints(min_length=1, max_length=200)], Control] = Field(
        default_factory=dict, max_length=500
    )
    """Its joints, by name."""


class Manifest(Model):
    """All assets of a case."""

    text2sim_assets: Literal[1] = VERSION
    """Version of the format."""
    assets: dict[Name, Asset] = Field(default_factory=dict, max_length=MAX_ASSETS)
    """By name."""


def read_manifest(case: Path) -> Manifest:
    """Return the manifest of a case; an empty one if there is none.

    Args:
        case: The case's folder.

    Raises:
        SpecError: with all that is wrong with it, and where.
        AssetError: if it is a link.
    """
    path = place_in(case, FILE)
    return parse_manifest(read_source(path)) if path.exists() else Manifest()


def parse_manifest(source: Source) -> Manifest:
    """Return the manifest that a text says.

    Raises:
        SpecError: with all that is wrong with it, and where.
    """
    document = parse_document(source)
    if not isinstance(document.data, dict):
        message = "a manifest is a mapping with the keys text2sim_assets and assets"
        raise SpecError([document.problem((), message, rule="type")])
    try:
        manifest = Manifest.model_validate(document.data)
    except ValidationError as error:
        raise SpecError(diagnose(document, error, Manifest, document.data)) from None
    problems = []
    for name, asset in manifest.assets.items():
        for path in (("assets", name, "file"), *(("assets", name, "parts", part) for part in asset.parts)):
            try:
                place_in(Path("/"), str(path[-1]) if path[2] == "parts" else asset.file)
            except AssetError as error:
                problems.append(document.problem(path, str(error), rule="asset", key=path[2] == "parts"))
    if problems:
        raise SpecError(problems)
    return manifest


def register(case: Path, name: str, asset: Asset) -> Manifest:
    """Put an asset into the manifest of a case, in the place of one of that name, and return what it then says.

    Args:
        case: Folder of the case.
        name: Name of the asset.
        asset: Its row.

    Raises:
        SpecError: if the manifest that lies there, or what it would become, is not valid.
    """
    with only_me(case):
        manifest = read_manifest(case)
        manifest = Manifest(assets={**manifest.assets, name: asset})
        text = manifest_text(manifest)
        parse_manifest(check_source(Source(text, FILE)))
        keep(case, FILE, text.encode())
    return manifest


def verify_manifest(case: Path, manifest: Manifest | None = None) -> dict[str, list[str]]:
    """Return what is wrong with the files of the assets, by name of the asset: missing, or not what was registered."""
    manifest = read_manifest(case) if manifest is None else manifest
    return {name: _differences(case, asset) for name, asset in manifest.assets.items()}


def problems_of(case: Path, found: dict[str, list[str]]) -> list[Problem]:
    """Return what `verify_manifest` found as problems of the manifest's lines."""
    document = parse_document(read_source(place_in(case, FILE)))
    return [
        document.problem(("assets", name), message, key=True, rule="asset")
        for name, messages in found.items()
        for message in messages
    ]


def manifest_text(manifest: Manifest) -> str:
    """Return a manifest in its one form: a line for each value, in the order of the format."""
    lines = [HEAD, f"text2sim_assets: {manifest.text2sim_assets}", "assets:" + ("" if manifest.assets else " {}")]
    for name, asset in manifest.assets.items():
        lines.append(f"  {key(name)}:")
        for field, value in asset.model_dump(mode="json", exclude_defaults=True).items():
            lines += _entry(field, value, 4)
    return "\n".join(lines) + "\n"


def _entry(name: str, value: Any, indent: int) -> list[str]:
    margin = " " * indent
    if isinstance(value, dict):
        return [f"{margin}{key(name)}:", *(f"{margin}  {key(n)}: {flow_text(v)}" for n, v in value.items())]
    if isinstance(value, list) and value and isinstance(value[0], str):
        return [f"{margin}{key(name)}:", *(f"{margin}  - {scalar(item, flow=False)}" for item in value)]
    if isinstance(value, list):
        return [f"{margin}{key(name)}: {flow_text(value)}"]
    if isinstance(value, str) and len(value) > WIDTH and (rows := block_lines(value, WIDTH - indent)):
        return [f"{margin}{key(name)}: {rows[0]}", *(f"{margin}  {row}" if row else "" for row in rows[1:])]
    return [f"{margin}{key(name)}: {scalar(value, flow=False)}"]


def _differences(case: Path, asset: Asset) -> list[str]:
    found = []
    for file, wanted in ((asset.file, asset.sha256), *asset.parts.items()):
        try:
            if digest(read_kept(case, file)) != wanted:
                found.append(f"`{file}` is not what was registered; add it again")
        except AssetError as error:
            found.append(str(error))
    return found
