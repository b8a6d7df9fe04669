"""Manifest of a case's assets, `assets/manifest.yaml`: their kinds, origins, licences, digests and joints."""

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, StringConstraints

from text2sim.assets.safe_write import FOLDER, digest, only_me, parts_of, place_in, read_kept, write_asset
from text2sim.spec_schema.errors import AssetError, Problem, SpecError
from text2sim.spec_schema.models.base import Bool, Model, Name, NonNegative, Noun, Positive, Range
from text2sim.spec_schema.text.document import parse_document
from text2sim.spec_schema.text.source import Source, check_source, read_source
from text2sim.spec_schema.text.writing import block_lines, flow_text, key, scalar
from text2sim.spec_schema.vocabulary.typed_document import model_of

FILE = f"{FOLDER}/manifest.yaml"
VERSION = 1
MAX_ASSETS = 1000
MAX_JOINTS, MAX_JOINT_NAME = 500, 200
"""Most joints of an asset, and most characters of the name of one."""
HEADER_COMMENT = "# Contents of this folder. `text2sim asset` rewrites this file, without comments."
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
    """A joint, and its response when it is driven."""

    kind: Literal["hinge", "slider", "ball"]
    """Kind of motion."""
    unit: Literal["rad", "m"]
    """Unit of its position."""
    range: Range | None = None
    """Lowest and highest position [rad or m]; unlimited if left out."""
    actuator: Motor | None = None
    """Its motor; a `drive` needs one."""
    target: float | None = None
    """Target of the probe [rad or m], relative to its start."""
    moved: float | None = None
    """Distance that it moved [rad or m]."""


class Asset(Model):
    """One asset."""

    file: Place
    """Path inside the case's folder."""
    kind: Kind
    """Kind of the file."""
    source: Origin
    """Origin of the file."""
    licence: Text = ""
    """Terms of use."""
    sha256: Digest
    """SHA-256 of the file."""
    bytes: Whole
    """Size of the file."""
    size: Extent | None = None
    """Extent along x, y and z [m], in a case."""
    triangles: Whole | None = None
    """Triangles of a mesh."""
    closed: Bool | None = None
    """Whether a mesh encloses a volume."""
    prompt: Text = ""
    """Prompt that it was made from."""
    notes: tuple[Text, ...] = ()
    """Repairs and doubts."""
    parts: dict[Place, Digest] = Field(default_factory=dict, max_length=500)
    """SHA-256 of the other files that it needs, by path inside the case's folder."""
    control: dict[Annotated[str, StringConstraints(min_length=1, max_length=MAX_JOINT_NAME)], Control] = Field(
        default_factory=dict, max_length=MAX_JOINTS
    )
    """Its joints, by name."""


class Manifest(Model):
    """All assets of a case."""

    text2sim_assets: Literal[1] = VERSION
    """Version of the format."""
    assets: dict[Name, Asset] = Field(default_factory=dict, max_length=MAX_ASSETS)
    """Assets by name."""


def read_manifest(case: Path) -> Manifest:
    """Return the manifest of a case; an empty one if there is none.

    Raises:
        SpecError: with all problems and their places.
        AssetError: if it is a link.
    """
    path = place_in(case, FILE)
    return parse_manifest(read_source(path)) if path.exists() else Manifest()


def parse_manifest(source: Source) -> Manifest:
    """Parse a manifest.

    Raises:
        SpecError: with all problems and their places.
    """
    document = parse_document(source)
    manifest = model_of(document, Manifest, "a manifest is a mapping with the keys text2sim_assets and assets")
    problems = []
    for name, asset in manifest.assets.items():
        for path in (("assets", name, "file"), *(("assets", name, "parts", part) for part in asset.parts)):
            try:
                parts_of(str(path[-1]) if path[2] == "parts" else asset.file)
            except AssetError as error:
                problems.append(document.problem(path, str(error), rule="asset", key=path[2] == "parts"))
    if problems:
        raise SpecError(problems)
    return manifest


def register(case: Path, name: str, asset: Asset) -> Manifest:
    """Add an asset to the manifest of a case, or replace the one of that name, and return the new manifest.

    Args:
        case: Folder of the case.
        name: Name of the asset.
        asset: Its row.

    Raises:
        SpecError: if the old or the new manifest is not valid.
        AssetError: if there are too many assets.
    """
    with only_me(case):
        manifest = read_manifest(case)
        if name not in manifest.assets and len(manifest.assets) >= MAX_ASSETS:
            raise AssetError(f"`{FILE}` has {MAX_ASSETS:,} assets, and more are not possible; remove some from it")
        manifest = Manifest(assets={**manifest.assets, name: asset})
        text = manifest_text(manifest)
        parse_manifest(check_source(Source(text, FILE)))
        write_asset(case, FILE, text.encode())
    return manifest


def verify_manifest(case: Path, manifest: Manifest | None = None) -> dict[str, list[str]]:
    """Return problems of asset files by name of the asset: missing, or different from what was registered."""
    manifest = read_manifest(case) if manifest is None else manifest
    return {name: _differences(case, asset) for name, asset in manifest.assets.items()}


def problems_of(case: Path, found: dict[str, list[str]]) -> list[Problem]:
    """Return the findings of `verify_manifest` as problems at lines of the manifest."""
    document = parse_document(read_source(place_in(case, FILE)))
    return [
        document.problem(("assets", name), message, key=True, rule="asset")
        for name, messages in found.items()
        for message in messages
    ]


def manifest_text(manifest: Manifest) -> str:
    """Return the canonical text of a manifest: a line for each value, in the order of the format."""
    lines = [
        HEADER_COMMENT,
        f"text2sim_assets: {manifest.text2sim_assets}",
        "assets:" + ("" if manifest.assets else " {}"),
    ]
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
                found.append(f"`{file}` has changed since it was registered; add it again")
        except AssetError as error:
            found.append(str(error))
    return found
