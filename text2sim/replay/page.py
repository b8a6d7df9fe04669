"""Pages in 3D: the self-contained `RUN/replay.html`, and the page of a watched case."""

import base64
import json
import math
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from text2sim.evidence.page import render_page, sentence
from text2sim.evidence.report import REPLAY, bound_of
from text2sim.exchange.scenery import Scenery
from text2sim.recording.record import RunRecord
from text2sim.recording.run_files import read_events, read_evidence, read_measures
from text2sim.replay.motion import pack_cameras, pack_contacts, pack_figures, pack_links
from text2sim.replay.packing import Blob
from text2sim.replay.pictures import Pictures
from text2sim.replay.shapes import pack_shapes
from text2sim.spec_schema.models.case import Case
from text2sim.spec_schema.models.expectations import Expect
from text2sim.spec_schema.whole_files import write_atomically

NAME = REPLAY
VIEWER = ("arrays.js", "stage.js", "view_control.js", "plots.js", "live.js", "page.js")
"""Parts of our script, in order."""
LIBRARY = "vendor/three.min.js"
BOUNDS_TIMES = 40
"""Number of times at which bounds are computed."""
MAX_STATES_SIZE = 200_000_000
"""Size of states [bytes] above which a replay is not written with the report."""
MAX_ROWS = 1500
"""Largest number of values of a measure."""
MAX_MEASURES = 60
MAX_EVENTS = 600
"""Largest number of declared events."""


def is_quick(folder: Path) -> bool:
    """Whether writing the replay of a run takes about a second."""
    return sum(path.stat().st_size for path in (folder / "states").glob("*.npz")) <= MAX_STATES_SIZE


def write_replay(folder: Path, case: Case) -> Path:
    """Write the replay of a judged run; return its path.

    Raises:
        RunError: if nothing is recorded, or the recording is damaged.
    """
    contents, blob = pack_scene(folder, case)
    evidence, record = read_evidence(folder) or {}, RunRecord.read(folder)
    why = evidence.get("why") or (record.message if record else "") or "there is nothing to judge"
    values = {
        "case": case,
        "verdict": evidence.get("verdict") or "incomplete",
        "why": sentence(str(why)),
        # Digests of our scripts, the only ones that the browser may run.
        "allowed": [base64.b64encode(sha256(text.encode()).digest()).decode() for text in scripts()],
        "contents": _mark_safe(contents),
        "blob": blob,
    }
    path = folder / NAME
    write_atomically(path, _page(values))
    return path


def live_page(nonce: str) -> str:
    """Return the page of a watched case, which loads its data from its server; its scripts have a nonce."""
    return _page({"nonce": nonce})


def pack_scene(folder: Path, case: Case) -> tuple[str, str]:
    """Pack the recording of a run, which may be in progress, and its evidence.

    Returns:
        Data for the viewer, as JSON that cannot end an HTML element; the arrays, deflated, in base64.

    Raises:
        RunError: if nothing is recorded, or the recording is damaged.
    """
    scenery = Scenery(folder, detailed=False)
    blob, notes = Blob(), list[str]()
    pictures = Pictures(notes)
    links, rows, frames = pack_links(scenery, blob, notes)
    center, radius = _moving_space(scenery)
    contents: dict[str, Any] = {
        "center": center,
        "radius": radius,
        "aspect": scenery.recording.film["resolution"][0] / scenery.recording.film["resolution"][1],
        "background": [float(x) for x in scenery.recording.film["background"]],
        "light": _light(scenery.recording.film["lights"]),
        "links": links,
        **pack_shapes(scenery, blob, pictures, rows, notes),
        "figures": pack_figures(scenery, blob, pictures, notes),
        "contacts": pack_contacts(folder, scenery, frames, blob, notes),
        "cameras": pack_cameras(scenery, blob),
        **pack_findings(folder, case, blob, notes),
        "pictures": pictures.uris,
        "notes": notes,
    }
    return _json(contents), blob.text()


def scripts() -> tuple[str, str]:
    """Return the library and our script."""
    here = Path(__file__).parent / "viewer"
    parts = [(here / name).read_text("utf-8") for name in VIEWER]
    return (here / LIBRARY).read_text("utf-8"), '(() => {\n"use strict";\n' + "\n".join(parts) + "\n})();"


def _page(values: dict[str, Any]) -> str:
    return render_page(
        "replay", "replay.html.j2", {"nonce": "", "scripts": [_mark_safe(text) for text in scripts()], **values}
    )


def _json(contents: dict[str, Any]) -> str:
    """JSON that cannot end the HTML element around it, even if a name in the case has its end tag."""
    text = json.dumps(_finite(contents), separators=(",", ":"), ensure_ascii=True, allow_nan=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(row) for key, row in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(row) for row in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value


def _mark_safe(text: str) -> Any:
    from markupsafe import Markup

    return Markup(text)


def _moving_space(scenery: Scenery) -> tuple[list[float], float]:
    """Centre and radius [m] of the space of moving bodies, or of all bodies if none moves."""
    recording = scenery.recording
    moving = [body for body in recording.bodies if body not in recording.statics] or recording.bodies
    times = scenery.times[:: max(1, len(scenery.times) // BOUNDS_TIMES)]
    points = np.concatenate([recording.states.bounds(moving, float(t)) for t in times]) if moving else np.zeros((1, 3))
    points = points[np.isfinite(points).all(axis=1)]
    if not len(points):
        return [0.0, 0.0, 0.0], 1.0
    # Percentiles, so that bodies that fly far away do not make the others small.
    low, high = np.percentile(points, (3, 97), axis=0)
    return ((low + high) / 2).tolist(), max(float(np.linalg.norm(high - low)) / 2, 0.05)


def _light(lights: dict[str, dict[str, Any]]) -> list[float]:
    """Direction of the strongest light that has one."""
    directed = [light for light in lights.values() if "direction" in light]
    if not directed:
        return [0.4, 0.5, -1.0]
    return [float(x) for x in max(directed, key=lambda light: light["strength"])["direction"]]


def pack_findings(folder: Path, case: Case, blob: Blob, notes: list[str]) -> dict[str, Any]:
    """Pack measures, events and expectations, as far as there is evidence.

    Args:
        folder: The run folder.
        case: The case.
        blob: Collects the arrays.
        notes: Collects notes about omissions.
    """
    evidence = read_evidence(folder) or {}
    time, columns = read_measures(folder)
    every = math.ceil(max(len(time), 1) / MAX_ROWS)
    measures = []
    for name, values in list(columns.items())[:MAX_MEASURES]:
        summary = evidence.get("measures", {}).get(name) or {}
        bounds = [b for key, row in case.actions.expect.items() if (b := bound_of(key, row, name, evidence, time))]
        measures.append(
            {
                "name": name, "unit": summary.get("unit") or "", "values": blob.add(values[::every].astype(np.float32)),
                "bounds": [
                    {
                        "name": b.name, "from": b.start, "to": b.end, "low": b.low, "high": b.high, "ok": b.ok,
                        "every": b.every,
                    }
                    for b in bounds
                ],
            }
        )  # fmt: skip
    if every > 1:
        notes.append(f"plots have every {every}th value")
    declared = [row for row in read_events(folder) if row["name"]]
    if len(declared) > MAX_EVENTS:
        notes.append(f"the first {MAX_EVENTS} of {len(declared)} events are listed")
    events = [
        {"name": str(row["name"]), "time": float(row["time"]), "of": ", ".join(map(str, _participants(row)))}
        for row in sorted(declared, key=lambda row: row["time"])[:MAX_EVENTS]
    ]
    return {
        "measure_times": blob.add(time[::every].astype(np.float32)),
        "measures": measures,
        "events": events,
        "expect": [
            _expectation(name, row, case.actions.expect[name])
            for name in case.actions.expect
            if (row := evidence.get("expect", {}).get(name)) is not None
        ],
    }


def _expectation(name: str, row: dict[str, Any], expect: Expect) -> dict[str, Any]:
    found = {"name": name, "ok": row.get("ok"), "wanted": row.get("wanted", ""), "why": row.get("why", "")}
    found |= {"event": expect.event} if expect.event is not None else {}
    return found | ({"measure": expect.measure} if expect.measure is not None else {})


def _participants(row: dict[str, Any]) -> list[Any]:
    return row.get("between") or [row.get("of") or row.get("measure") or ""]
