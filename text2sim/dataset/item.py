"""Items: files and rows of the tables, made from a recorded run and the film settings of a recipe."""

import io
import json
import zipfile
from dataclasses import dataclass, field, replace
from hashlib import sha256
from itertools import chain, pairwise
from pathlib import Path
from typing import Any

import numpy as np

from text2sim.assets.manifest import read_manifest
from text2sim.cluster.task import STOPPED
from text2sim.dataset.annotations import Annotator, PictureContacts
from text2sim.dataset.recipe import Film, Recipe
from text2sim.recording.film_record import FilmRecord, read_recording
from text2sim.recording.inventory import sha256_of
from text2sim.recording.record import RunRecord
from text2sim.recording.run_files import read_evidence, read_json
from text2sim.recording.states import RunStates
from text2sim.rendering.film import Filming
from text2sim.runtime.stop import Stop
from text2sim.spec_schema.errors import RunError
from text2sim.spec_schema.loaded import LoadedCase
from text2sim.templates.cadence import MAIN, Frame, frames, reels
from text2sim.templates.video import Video

STATES = ("time", "pos", "quat", "vel", "ang", "qpos", "dofs_velocity", "dofs_force")
"""Arrays of rigid states in an item, over all recorded frames."""
DIGITS = 10
"""Length of the simulation's digest in the name of a run folder."""


@dataclass
class Item:
    """An item of a dataset.

    Attributes:
        folder: Its files: `film.mp4`, `annotations.npz`, ….
        row: Its row in the table of items, without split and shard.
        frames: Its rows in the table of frames.
        questions: Candidates for the table of questions.
        glance: Mean colours of fields of some pictures, 0 to 255.
    """

    key: str
    folder: Path
    row: dict[str, Any]
    frames: list[dict[str, Any]] = field(default_factory=list)
    questions: list[dict[str, Any]] = field(default_factory=list)
    glance: list[list[int]] = field(default_factory=list)


def raise_if_stopped(stop: Stop | None) -> None:
    """Check whether the user asked to stop.

    Raises:
        RunError: if so.
    """
    if stop is not None and stop.count:
        raise RunError(STOPPED)


def film_of(recording: FilmRecord, film: Film) -> tuple[FilmRecord, list[Frame]]:
    """Return a recording with the film settings of a dataset, and the pictures of its main film.

    Pictures are sharp, without motion blur, depth of field or overlays, so that annotations fit every pixel.
    """
    cameras = {name: camera | {"f_stop": None} for name, camera in recording.film["cameras"].items()}
    settings = recording.film | {"resolution": film.size, "fps": film.fps, "motion_blur": 0.0, "cameras": cameras}
    pictures = frames(settings, reels(settings)[MAIN], recording.last)
    # Each shot is rounded to at least one picture, so that one reduction of the rate may not be enough.
    while len(pictures) > film.frames:
        before = len(pictures)
        settings["fps"] *= film.frames / before
        pictures = frames(settings, reels(settings)[MAIN], recording.last)
        if len(pictures) == before:  # one picture per shot
            pictures = pictures[: film.frames]
    return replace(recording, film=settings), pictures


def make_item(
    key: str, run: Path, plan: Any, loaded: LoadedCase, recipe: Recipe, out: Path, stop: Stop | None = None
) -> Item:
    """Film and annotate a run.

    Args:
        key: Name of the item.
        run: The run folder.
        plan: Plan with the film and the looks; None for those of the run folder.
        loaded: The case.
        recipe: The recipe.
        out: Folder for the files of the item.
        stop: Checked before each picture.

    Raises:
        RunError: if the run has no states that can be filmed or no evidence, or the user asked to stop.
    """
    record, evidence = RunRecord.read(run), read_evidence(run)
    if record is None or evidence is None:
        raise RunError(f"{run}: has no evidence")
    out.mkdir(parents=True, exist_ok=True)
    recording, pictures = film_of(read_recording(run, plan), recipe.film)
    annotator, states = Annotator(recording), RunStates.load(run)
    touches = PictureContacts(states) if evidence.get("contacts", {}).get("recorded", True) else None
    rows = _annotate(annotator, pictures, recipe, touches, out, stop)
    _film(recording, pictures, recipe.film, annotator, out / "film.mp4", stop)
    _copy_run(run, states, recording, pictures, out)
    (out / "case.yaml").write_bytes((run / "expanded.yaml").read_bytes())
    row = {"key": key, **_about_case(loaded, record), **_about_run(record, evidence)}
    row |= {"things": annotator.things, "parts": annotator.parts, "quality": recipe.film.quality}
    row |= {"energy_gain": _energy_gain(evidence.get("energy"), states, loaded.data)}
    row |= {"width": recipe.film.size[0], "height": recipe.film.size[1], "frames": len(pictures)}
    row |= {"fps": recording.film["fps"], "film_digest": sha256_of(out / "film.mp4")}
    row |= {"states_digest": sha256_of(out / "states.npz")}
    return Item(key, out, row, [{"key": key, **frame} for frame in rows])


def _annotate(
    annotator: Annotator,
    pictures: list[Frame],
    recipe: Recipe,
    touches: PictureContacts | None,
    out: Path,
    stop: Stop | None,
) -> list[dict[str, Any]]:
    """Write `annotations.npz` and return the rows of the frames."""
    wanted, rows = recipe.annotations, []
    # The filters and the questions need visibility, too.
    in_rows = list(dict.fromkeys([*wanted, "visibility"]))
    stacks = _Stacks(out / "annotations.npz", len(pictures))
    views = (annotator.seen(picture) for picture in pictures)
    for now, after in pairwise(chain(views, [None])):
        raise_if_stopped(stop)
        assert now is not None
        stacks.add(annotator.arrays(now, after, wanted, touches))
        rows.append(annotator.row(now, in_rows, touches))
    stacks.close()
    return rows


class _Stacks:
    """Arrays of pictures, stacked on disk because those of a long film do not fit into memory."""

    def __init__(self, path: Path, count: int):
        self._path, self._count, self._k = path, count, 0
        self._maps: dict[str, Any] = {}

    def add(self, arrays: dict[str, Any]) -> None:
        for name, array in arrays.items():
            if name not in self._maps:
                part = self._path.with_name(f".{name}.npy")
                shape = (self._count, *array.shape)
                self._maps[name] = np.lib.format.open_memmap(part, "w+", array.dtype, shape)
            self._maps[name][self._k] = array
        self._k += 1

    def close(self) -> None:
        if self._maps:
            np.savez_compressed(self._path, allow_pickle=False, **self._maps)
        names, self._maps = list(self._maps), {}
        for name in names:
            self._path.with_name(f".{name}.npy").unlink()


def _film(
    recording: FilmRecord, pictures: list[Frame], film: Film, annotator: Annotator, path: Path, stop: Stop | None
) -> None:
    video = Video(path, film.size, recording.film["fps"], crf=14)
    for image in _images(recording, pictures, film, annotator):
        video.write(image)
        raise_if_stopped(stop)
    video.close()


def _images(recording: FilmRecord, pictures: list[Frame], film: Film, annotator: Annotator) -> Any:
    if film.quality == "preview":
        yield from (annotator.preview(annotator.seen(frame)) for frame in pictures)
        return
    filming = Filming(recording, film.quality, size=film.size)
    yield from (filming.develop(filming.trace(frame)) for frame in pictures)


def _copy_run(run: Path, states: RunStates, recording: FilmRecord, pictures: list[Frame], out: Path) -> None:
    """Write states, layout, evidence and program of a run."""
    arrays = {name: getattr(states, name) for name in STATES}
    if (soft := recording.states.soft) is not None:
        around = [recording.states.around(frame.t) for frame in pictures]
        arrays["soft_time"] = np.array([frame.t for frame in pictures])
        arrays["soft_points"] = np.stack([soft.at("soft_points", moment) for moment in around]).astype(np.float32)
    np.savez_compressed(out / "states.npz", allow_pickle=False, **arrays)
    (out / "layout.json").write_text(json.dumps(states.layout))
    for name in ("evidence.json", "measures.csv", "events.jsonl"):
        if (run / name).is_file():
            (out / name).write_bytes((run / name).read_bytes())
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in sorted((run / "program").rglob("*")):
            if path.is_file() and "__pycache__" not in path.parts:
                info = zipfile.ZipInfo(path.relative_to(run / "program").as_posix())  # without a time of change
                archive.writestr(info, path.read_bytes(), zipfile.ZIP_DEFLATED)
    (out / "program.zip").write_bytes(buffer.getvalue())


def _about_case(loaded: LoadedCase, record: RunRecord) -> dict[str, Any]:
    data = loaded.case.model_dump(mode="json", by_alias=True)
    assets = [
        {
            "name": name,
            **{key: str(getattr(asset, key) or "") for key in ("file", "kind", "source", "licence", "sha256")},
        }
        for name, asset in read_manifest(loaded.folder).assets.items()
    ]
    return {
        "case": loaded.case.name,
        "prompt": data.get("prompt") or "",
        "params": json.dumps(data.get("params", {})),
        "controls": json.dumps(data["actions"]["controls"]),
        "assets": assets,
        "scores": _scores(loaded.folder, record.key.get("sim_digest", "")),
        "case_digest": sha256(loaded.source.text.encode()).hexdigest(),
        "sim_digest": record.key.get("sim_digest", ""),
        "versions": json.dumps({"text2sim": record.text2sim, **record.versions}),
    }


def _scores(case: Path, sim_digest: str) -> list[dict[str, Any]]:
    """Scores of the Critic for this simulation, if `generate` made the case: `by`, `score` of 100, `verdict`."""
    found = []
    for path in sorted((case / "generation" / "attempts").glob("*/attempt.json")):
        attempt = read_json(path) or {}
        critique = attempt.get("critique") or {}
        if "score" in critique and str(attempt.get("run")).endswith(f"-{sim_digest[:DIGITS] or None}"):
            found.append({"by": "critic", "score": float(critique["score"]), "verdict": critique.get("verdict")})
    return found


def _about_run(record: RunRecord, evidence: dict[str, Any]) -> dict[str, Any]:
    measures, events = evidence["measures"], evidence["events"]
    keys = ("unit", "first", "last", "min", "min_at", "max", "max_at")
    penetration = evidence.get("penetration") or {}
    return {
        "state": record.state,
        "duration": evidence["time"]["reached"],
        "verdict": evidence["verdict"],
        "expectations": [
            {"name": name, "wanted": row["wanted"], "ok": row["ok"], "why": row["why"]}
            for name, row in evidence["expect"].items()
        ],
        "measures": [{"name": name, **{key: row.get(key) for key in keys}} for name, row in measures.items()],
        "events": [
            {"name": n, **{key: row.get(key) for key in ("count", "first", "last")}} for n, row in events.items()
        ],
        "penetration": penetration.get("value"),
        "suspicions": [str(row) for row in evidence.get("suspicions", [])],
        "remarks": [str(row) for row in (evidence.get("legibility") or {}).get("remarks", [])],
    }


def _energy_gain(energy: dict[str, Any] | None, states: RunStates, case: dict[str, Any]) -> float | None:
    """The energy that a run gained beyond all work, as a part of its largest kinetic energy or of the work.

    None if the energy balance leaves something out, as it does with springs.
    """
    if not energy or energy.get("not_counted") or energy.get("change") is None or _has_spring(case.get("bodies")):
        return None
    mass = np.array([link.mass for link in states.links])
    turning = np.array([np.trace(link.inertia) / 3 for link in states.links])
    kinetic = 0.5 * ((states.vel.astype(float) ** 2).sum(axis=2) @ mass)
    kinetic += 0.5 * ((states.ang.astype(float) ** 2).sum(axis=2) @ turning)
    scale = max(float(kinetic.max(initial=0.0)), abs(energy.get("work_of_motors") or 0.0))
    return max(energy["change"], 0.0) / scale if scale else 0.0


def _has_spring(part: Any) -> bool:
    if isinstance(part, dict):
        return bool(part.get("spring")) or any(map(_has_spring, part.values()))
    return isinstance(part, list) and any(map(_has_spring, part))
