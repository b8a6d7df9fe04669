"""Page of a comparison: one self-contained file."""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from text2sim.comparison.compare import RunComparison
from text2sim.comparison.runs import Run
from text2sim.evidence.page import MAX_EMBEDDED_SIZE, data_uri, films_script, read_films, render_page
from text2sim.evidence.plots import BLUE, GREEN, GREY, ORANGE, VERMILION, PlotLine, plot_series
from text2sim.recording.run_files import read_measures
from text2sim.recording.states import Array
from text2sim.spec_schema.whole_files import write_atomically

STYLES = [(color, dashes) for dashes in ("-", "--", ":", "-.") for color in (BLUE, VERMILION, GREEN, ORANGE, GREY)]
"""Colour and dashes of each run, the same in all plots."""


def write_comparison(comparison: RunComparison, path: Path) -> Path:
    """Write the page to a file, which is replaced."""
    page = render_page(
        "comparison",
        "page.html.j2",
        {
            "it": comparison,
            "case": " and ".join(dict.fromkeys(run.record.case for run in comparison.runs)),
            "films": _films(comparison.runs),
            "plots": _plots(comparison),
            **films_script(),
        },
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(path, page)
    return path


def _films(runs: list[Run]) -> list[dict[str, Any]]:
    rows = []
    for run in runs:
        films, linked = read_films(run.folder, MAX_EMBEDDED_SIZE // len(runs))
        uri = films[0][1] if films else None
        link = (run.folder / linked[0][1]).resolve().as_uri() if linked and not films else None
        rows.append({"label": run.label, "uri": uri, "link": link})
    return rows


def _plots(comparison: RunComparison) -> list[tuple[str, str]]:
    series = [read_measures(run.folder) for run in comparison.runs]
    found = []
    with TemporaryDirectory() as folder:
        for number, row in enumerate(comparison.measures):
            time, lines = _lines(comparison.runs, series, row["name"])
            if not lines:
                continue
            file = Path(folder) / f"{number}.png"
            plot_series(file, time, lines, title=row["name"], unit=row["unit"])
            found.append((row["name"], data_uri(file, "image/png") or ""))
    return found


def _lines(runs: list[Run], series: list[tuple[Array, dict[str, Array]]], name: str) -> tuple[Array, list[PlotLine]]:
    """Interpolate the series of one measure at the times of all runs; a run that ended early has NaN after its end."""
    times = [time for time, columns in series if name in columns]
    if not times:
        return np.zeros(0), []
    time = np.unique(np.concatenate(times))
    lines = []
    for run, (own, columns), (color, dashes) in zip(runs, series, STYLES * 2, strict=False):
        if name not in columns or not len(own):
            continue
        lines.append(PlotLine(run.label, np.interp(time, own, columns[name], right=np.nan), color, dashes))
    return time, lines
