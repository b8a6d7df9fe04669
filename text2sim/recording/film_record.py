"""A recorded run for its film: cameras, meshes and looks, from the run folder."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from text2sim.recording.chunks import DAMAGED
from text2sim.recording.inventory import first_fault
from text2sim.recording.record import RunRecord
from text2sim.spec_schema.errors import RunError, SpecError
from text2sim.templates.cadence import read_film
from text2sim.templates.directing import directed
from text2sim.templates.patterns import Decoration, decoration_in
from text2sim.templates.playback import States

if TYPE_CHECKING:
    from text2sim.compiler.plan import Plan

Rgb = tuple[float, float, float]


class Cut(NamedTuple):
    """Where a fragment was cut from a body."""

    place: tuple[float, float, float]
    """The origin of its link in the body's frame [m]."""
    low: tuple[float, float, float]
    high: tuple[float, float, float]
    """Lowest and highest corner of the body in its frame [m]."""


@dataclass(frozen=True)
class SurfaceLook:
    """How a surface looks."""

    color: Rgb
    """sRGB, 0 to 1."""
    opacity: float = 1.0
    finish: str = "plastic"
    visible: bool = True
    picture: Path | None = None
    """Picture in place of its colour."""
    decoration: Decoration | None = None
    """Pattern and writing over its colour."""
    alike: bool = False
    """Whether copies have exactly this colour."""
    cut: Cut | None = None
    """Of a fragment of a body."""

    @property
    def drawn(self) -> bool:
        """Whether a film shows anything of it."""
        return self.visible and self.opacity > 0


@dataclass(frozen=True)
class WornMesh:
    """A mesh that is drawn with a link."""

    body: str
    """Name of the copy."""
    link: int
    """Row of its poses."""
    mesh: Path
    pos: tuple[float, ...]
    """In the link's frame [m]."""
    quat: tuple[float, ...]
    look: SurfaceLook
    surface_velocity: tuple[float, ...] | None = None
    """In the link's frame [m/s]; None if its surface does not move over it."""


@dataclass(frozen=True)
class SoftPart:
    """A deformable body."""

    body: str
    kind: str
    """soft, cloth, granular, liquid or snow."""
    row: dict[str, Any]
    """Its row in the layout."""
    geometry: Path
    look: SurfaceLook
    regions: Path | None = None
    """File of the regions in which parts have looks of their own."""
    parts: tuple[SurfaceLook | None, ...] = ()
    """Looks by number of the part; None where a part has the look of the body."""


@dataclass(frozen=True)
class FilmRecord:
    """A recorded run, ready to be filmed."""

    folder: Path
    film: dict[str, Any]
    """See `templates/cadence.py`."""
    states: States
    parts: list[WornMesh]
    soft: list[SoftPart]
    statics: frozenset[str]
    """Copies that never move."""

    @property
    def last(self) -> float:
        """Last recorded time [s]."""
        return float(self.states.time[-1])

    @property
    def bodies(self) -> list[str]:
        """Names of all copies, statics included."""
        return list(dict.fromkeys([*(part.body for part in self.parts), *(part.body for part in self.soft)]))


def read_recording(folder: Path, plan: "Plan | None" = None) -> FilmRecord:
    """Read a run's folder.

    Args:
        folder: The run folder.
        plan: Gives the film and the looks; if left out, those in the folder are used.

    Raises:
        RunError: if nothing was recorded in it.
    """
    record = RunRecord.read_whole(folder)
    if record and (damage := first_fault(folder, record.recorded)):
        raise RunError(f"{folder}: {damage}; run the case again")
    film, looks = _program(folder, plan)
    try:
        states = States(folder)
        film = directed(film, states)
        index = json.loads((folder / "geometry" / "index.json").read_text("utf-8"))
        rows = states.layout["links"]
        parts = []
        for link, pieces in index.items():
            row = rows[int(link)]
            velocity = tuple(row["surface_velocity"]) if "surface_velocity" in row else None
            worn = _looks_of_pieces(looks.get(row["body"]), row["link"], len(pieces))
            parts += [
                WornMesh(
                    row["body"], int(link), folder / "geometry" / piece["mesh"], tuple(piece["pos"]),
                    tuple(piece["quat"]), _look(folder, look, piece), velocity,
                )
                for piece, look in zip(pieces, worn, strict=True)
            ]  # fmt: skip
        soft = _soft(folder, states, looks)
    except OSError as error:
        raise RunError(f"{folder}: nothing was recorded ({error.strerror}: {error.filename})") from error
    except (*DAMAGED, AttributeError) as error:
        raise RunError(f"{folder}: not the recording of a run ({error!r})") from error
    held = (
        {row["body"] for row in rows if row["fixed"]}
        - {row["body"] for row in rows if not row["fixed"]}
        - {*states.removed}
    )
    return FilmRecord(folder, film, states, parts, soft, frozenset(held))


def _program(folder: Path, plan: "Plan | None") -> tuple[dict[str, Any], dict[str, Any]]:
    """Return how the run is filmed, and its looks by copy."""
    program = folder / "program"
    if not (folder / "states" / "layout.json").is_file():
        raise RunError(f"{folder}: nothing was recorded there")
    if plan is None:
        try:
            film = read_film((program / "render.py").read_text("utf-8"))
            looks = json.loads((program / "looks.json").read_text("utf-8"))
            if not any(isinstance(look, list) for look in looks.values()):  # lists are of an older version
                return film, looks
        except (OSError, ValueError):
            pass
        plan = _plan_anew(folder)
    from text2sim.compiler.emit import emit

    return plan.render, json.loads(emit(plan)["looks.json"])


def _plan_anew(folder: Path) -> "Plan":
    """Plan the case of a run again that an older version recorded."""
    from text2sim.compiler.build import plan_case
    from text2sim.spec_schema.load import load_case

    try:
        return plan_case(load_case(folder / "expanded.yaml"))
    except SpecError as error:
        raise RunError(
            f"{folder}: an older version recorded it, and its expanded.yaml no longer compiles; name its case instead "
            f"of the run ({error.problems[0].message})"
        ) from error


def _looks_of_pieces(looks: dict[str, Any] | None, link: str, count: int) -> list[dict[str, Any] | None]:
    """Return the looks of what is drawn of a link, in the order in which it was recorded; None for recorded colours.

    Args:
        looks: Looks of its copy, as in `looks.json`.
        link: Name of the link.
        count: Number of recorded pieces.
    """
    if looks is None or "looks" not in looks:
        return [looks] * count
    numbers = looks["links"].get(link, [])
    return [looks["looks"][k] for k in numbers] if len(numbers) == count else [None] * count


def _look(folder: Path, look: dict[str, Any] | None, painted: dict[str, Any]) -> SurfaceLook:
    *color, opacity = painted["color"]
    picture = folder / "geometry" / painted["texture"] if "texture" in painted else None
    if look is None:
        return SurfaceLook((color[0], color[1], color[2]), opacity, picture=picture)
    if look.get("picture"):
        picture = folder / "program" / look["picture"]
        picture = picture if picture.is_file() else None
    red, green, blue = look["color"]
    color, alike = (red, green, blue), look.get("alike", False)
    rows = [(x, y, z) for x, y, z in (look["cut"]["place"], *look["cut"]["bounds"])] if "cut" in look else None
    cut = Cut(*rows) if rows else None
    return SurfaceLook(
        color, look["opacity"], look["finish"], look["visible"], picture, decoration_in(look), alike, cut
    )


def _soft(folder: Path, states: States, looks: dict[str, Any]) -> list[SoftPart]:
    rows = states.layout.get("deformables") or []
    if not rows:
        return []
    painted = json.loads((folder / "geometry" / "soft_index.json").read_text("utf-8"))
    made = []
    for k, (row, paint) in enumerate(zip(rows, painted, strict=True)):
        look = looks.get(row["body"])
        regions, parts = None, ()
        if look is not None and look.get("regions"):
            regions = folder / "program" / look["regions"]
            parts = tuple(part and _look(folder, part, paint) for part in look["parts"])
        geometry = folder / "geometry" / f"soft_{k}.npz"
        own = _look(folder, look, paint)
        made.append(SoftPart(row["body"], row["kind"], row, geometry, own, regions, parts))
    return made
