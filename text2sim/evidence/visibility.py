"""Visibility and legibility of bodies in the film of each camera."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from text2sim.evidence.events import EventLog
from text2sim.spec_schema.errors import Text2SimError
from text2sim.spec_schema.models.case import Case
from text2sim.spec_schema.names.selectors import body_of

if TYPE_CHECKING:
    from text2sim.legibility.film import Painted


def read_samples(run_dir: Path) -> dict[str, list[tuple[float, dict[str, float]]]]:
    """Return the sampled frames of each camera in order: time [s], and fraction of the picture by copy.

    Empty without a film.
    """
    try:
        data = json.loads((run_dir / "visibility.json").read_text("utf-8"))
        return {
            str(camera): [(float(row["t"]), {str(k): float(v) for k, v in row["shares"].items()}) for row in rows]
            for camera, rows in data.items()
        }
    except (OSError, ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return {}


def summarise_visibility(run_dir: Path, bodies: Sequence[str]) -> dict[str, Any] | None:
    """Return for each camera the visibility of each body (all copies together); None without a film.

    Args:
        run_dir: The run folder.
        bodies: Names of the bodies.
    """
    samples = read_samples(run_dir)
    if not samples:
        return None
    return {camera: _camera(rows, bodies) for camera, rows in samples.items()}


def _camera(rows: list[tuple[float, dict[str, float]]], bodies: Sequence[str]) -> dict[str, Any]:
    seen: dict[str, dict[str, Any]] = {}
    for time, shares in rows:
        total: dict[str, float] = {}
        for copy, share in shares.items():
            total[body_of(copy)] = total.get(body_of(copy), 0.0) + share
        for body, share in total.items():
            if body in bodies and share > 0:
                row = seen.setdefault(body, {"largest": 0.0, "at": time, "pictures": 0})
                row["pictures"] += 1
                if share > row["largest"]:
                    row["largest"], row["at"] = share, time
    return {
        "pictures": len(rows),
        "bodies": seen,
        "never_seen": [body for body in bodies if body not in seen],
    }


def summarise_legibility(run_dir: Path, case: Case, events: EventLog) -> dict[str, Any] | None:
    """Return the legibility of bodies in the film that `program/render.py` describes, whether or not it was rendered.

    Args:
        run_dir: The run folder.
        case: The case, which says which bodies its events concern.
        events: The events that occurred.

    Returns:
        The result of `legibility.summary`; None if nothing recorded can be filmed.
    """
    from text2sim.legibility.film import Watcher
    from text2sim.legibility.summary import summarise
    from text2sim.recording.film_record import read_recording

    try:
        recording = read_recording(run_dir)
        if not recording.parts and not recording.soft:
            return None
        return summarise(Watcher(recording, _previewed(run_dir)), _moments(case, events))
    except (Text2SimError, OSError, ValueError, KeyError, IndexError, TypeError):
        return None  # a recording made by hand, or by an older version


def _moments(case: Case, events: EventLog) -> list[Any]:
    """Return the first time of each event, in the order of the case, and the bodies that it concerns."""
    from text2sim.legibility.summary import Moment

    found = []
    for name, rows in events.occurrences.items():
        if not rows:
            continue
        model = case.actions.events.get(name)
        one = [rows[0]["of"]] if "of" in rows[0] else getattr(model, "subjects", ())
        named = rows[0].get("between") or one
        bodies = dict.fromkeys(body_of(str(label)) for label in named)
        found.append(Moment(name, float(rows[0]["time"]), tuple(bodies)))
    return found


def _previewed(run_dir: Path) -> "Painted | None":
    """Return a reader of the frames that the preview has stored; None without a preview."""
    kept = {
        (camera, round(t, 6)): run_dir / "frames" / f"{camera}_{k}.png"
        for camera, rows in read_samples(run_dir).items()
        for k, (t, _) in enumerate(rows)
    }
    if not any(path.is_file() for path in kept.values()):
        return None

    def painted(frame: Any, size: tuple[int, int]) -> Any:
        from text2sim.legibility.film import read_picture

        path = kept.get((frame.camera, round(frame.t, 6)))
        return None if path is None or not path.is_file() else read_picture(path, size)

    return painted
