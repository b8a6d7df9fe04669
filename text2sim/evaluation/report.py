"""Page of an evaluation: tables, bar charts by case, films side by side, requirements with evidence."""

import base64
import io
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from text2sim.compiler.shapes.pictures import picture_bytes
from text2sim.evaluation.film_frames import length_of, pictures_at
from text2sim.evaluation.judging import KINDS, Judgement, Kind
from text2sim.evaluation.scores import PHYSICAL_WEIGHTS, VISUAL_WEIGHTS
from text2sim.evaluation.statistics import case_scores
from text2sim.evaluation.suite import Prompt
from text2sim.evaluation.tables import PAPER_RESULTS, Tables
from text2sim.evidence.page import films_script, render_page
from text2sim.evidence.plots import BLUE, DPI, GREEN, GREY, ORANGE, VERMILION
from text2sim.spec_schema.errors import RunError
from text2sim.spec_schema.whole_files import write_atomically

REPORT = "report.html"
COLORS = (BLUE, ORANGE, GREEN, VERMILION, GREY)
"""Colours of methods, in their order; further methods repeat them with hatching."""
MOMENTS = 4
"""Number of times at which the films of a case are compared."""
THUMBNAIL = 300
"""Largest side of the thumbnails at these times [pixels]."""


def write_report(tables: Tables, out: Path) -> Path:
    """Write the page; films are linked, everything else is embedded."""
    families: dict[str, list[str]] = {}
    for name, prompt in _judged_prompts(tables):
        families.setdefault(prompt.family, []).append(name)
    contents = {
        "it": tables, "paper": PAPER_RESULTS, "parts": PHYSICAL_WEIGHTS, "visual": VISUAL_WEIGHTS, "kinds": KINDS,
        "families": families,
        "bars": [(family, kind, _bars(tables, kind, names)) for family, names in families.items() for kind in KINDS],
        "cases": [_case(tables, out, name, prompt) for name, prompt in _judged_prompts(tables)],
        **films_script(),
    }  # fmt: skip
    write_atomically(out / REPORT, render_page("evaluation", "report.html.j2", contents))
    return out / REPORT


def _judged_prompts(tables: Tables) -> list[tuple[str, Prompt]]:
    """Prompts with a judgement, sorted by family."""
    names = {row.turn.prompt for row in tables.judgements}
    found = [(name, prompt) for name, prompt in tables.suite.prompts.items() if name in names]
    families = list(dict.fromkeys(prompt.family for prompt in tables.suite.prompts.values()))
    return sorted(found, key=lambda row: families.index(row[1].family))


def _bars(tables: Tables, kind: Kind, names: Sequence[str]) -> str:
    """Bar chart of cases and methods, with the range of judgements, as a data URI of a PNG."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    scores = case_scores(tables.judgements, kind)
    methods = list(tables.methods)
    figure = Figure(figsize=(min(13.0, max(5.4, 0.7 * len(names) + 1.5)), 3.2), layout="constrained")
    axes = figure.add_subplot()
    width = 0.8 / max(1, len(methods))
    for k, method in enumerate(methods):
        rows = [row for row in tables.judgements if (row.turn.method, row.turn.kind) == (method, kind)]
        for x, name in enumerate(names):
            value = scores.get((method, name))
            place = x + (k - (len(methods) - 1) / 2) * width
            if value is None:
                axes.text(place, 1, "?", ha="center", color=GREY)
                continue
            totals = [row.total for row in rows if row.turn.prompt == name and row.total is not None]
            span = [[value - min(totals)], [max(totals) - value]]
            axes.bar(
                place, value, width, color=COLORS[k % len(COLORS)], yerr=span, error_kw={"lw": 0.8, "ecolor": "#333"},
                hatch="//" if k >= len(COLORS) else None, label=method if x == 0 else None,
            )  # fmt: skip
    axes.set(ylim=(0, 100), xlim=(-0.6, len(names) - 0.4), ylabel=f"{kind} score")
    axes.set_xticks(range(len(names)), [name.replace("_", " ") for name in names], rotation=40, ha="right", fontsize=8)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(*_handles(methods), fontsize=8, frameon=False, ncols=min(4, len(methods)), loc="lower left",
                bbox_to_anchor=(0, 1.0))  # fmt: skip
    stream = io.BytesIO()
    FigureCanvasAgg(figure).print_figure(stream, dpi=DPI)
    return _uri(stream.getvalue(), "png")


def _handles(methods: Sequence[str]) -> tuple[list[Any], Sequence[str]]:
    from matplotlib.patches import Patch

    hatches = ["//" if k >= len(COLORS) else None for k in range(len(methods))]
    return [Patch(facecolor=COLORS[k % len(COLORS)], hatch=hatch) for k, hatch in enumerate(hatches)], methods


def _case(tables: Tables, out: Path, name: str, prompt: Prompt) -> dict[str, Any]:
    """Template variables for one prompt."""
    rows = [row for row in tables.judgements if row.turn.prompt == name]
    films = {method: _film(tables, method, name) for method in tables.methods}
    times, strips = _strips(films)
    return {
        "name": name,
        "prompt": prompt,
        "times": times,
        "methods": [
            {
                "name": method,
                "film": os.path.relpath(film, out) if film is not None and method in strips else None,
                "strip": strips.get(method, []),
                "scores": {kind: case_scores(rows, kind).get((method, name)) for kind in KINDS},
                "judgements": [row for row in rows if row.turn.method == method],
                "notes": _notes([row for row in rows if row.turn.method == method]),
            }
            for method, film in films.items()
        ],
        "requirements": _requirements(tables, name),
    }


def _film(tables: Tables, method: str, prompt: str) -> Path | None:
    folder = tables.methods[method]
    result = folder.made.get(prompt) if folder is not None else None
    return result.path("film") if result is not None else None


def _strips(films: dict[str, Path | None]) -> tuple[list[float], dict[str, list[str]]]:
    """Shared film times [s], and thumbnails of each film at these."""
    lengths = {}
    for method, film in films.items():
        try:
            lengths[method] = length_of(film) if film is not None else 0.0
        except RunError:
            lengths[method] = 0.0
    longest = max(lengths.values(), default=0.0)
    times = [float(t) for t in np.linspace(0.0, longest, MOMENTS)]
    strips = {}
    for method, film in films.items():
        if film is not None and lengths[method]:
            strips[method] = [_thumbnail(picture) for picture in pictures_at(film, times)]
    return times if longest else [], strips


def _thumbnail(picture: Any) -> str:
    picture.thumbnail((THUMBNAIL, THUMBNAIL))
    return _uri(picture_bytes(picture, "jpeg", quality=82), "jpeg")


def _uri(data: bytes, kind: str) -> str:
    return f"data:image/{kind};base64,{base64.b64encode(data).decode()}"


def _notes(rows: Sequence[Judgement]) -> list[str]:
    """Notes on a result: facts, missing files, missing judgements."""
    found: list[str] = []
    for row in rows:
        shown = row.shown or {}
        found += [f"fact: {fact}" for fact in shown.get("facts", ())]
        found += [f"missing: {what}" for what in [*shown.get("missing", ()), *shown.get("notes", ())]]
        if row.state != "judged":
            found.append(f"{row.turn.kind}: {row.state.replace('_', ' ')}: {row.why}")
    return list(dict.fromkeys(found))


def _requirements(tables: Tables, prompt: str) -> list[dict[str, Any]]:
    """Requirements and prohibitions of a prompt, each with marks and evidence by method."""
    rows = [row for row in tables.tables["requirements"] if row["prompt"] == prompt]
    found: dict[str, dict[str, Any]] = {}
    for row in rows:
        head = {"name": row["requirement"], "what": row["what"], "weight": row["weight"], "cells": {}}
        cell = found.setdefault(row["requirement"], head)["cells"].setdefault(
            row["method"], {"marks": [], "evidence": []}
        )
        cell["marks"].append(row["mark"])
        if row["evidence"]:
            cell["evidence"].append(f"judge {row['judge']}, {row['repeat']}: {row['evidence']}")
    for requirement in found.values():
        for cell in requirement["cells"].values():
            cell["mean"] = float(np.mean(cell["marks"]))
    return list(found.values())
