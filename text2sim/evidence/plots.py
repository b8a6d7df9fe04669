"""Plots: one for each measure, and one of the energy.

Colours are those of Okabe and Ito, which are safe for red-green colour blindness; every kind of line also has its own
dash pattern.
"""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from text2sim.recording.states import Array
from text2sim.spec_schema.plain import plain_line
from text2sim.spec_schema.whole_files import naming

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BLUE, ORANGE, GREEN, VERMILION, GREY = "#0072B2", "#E69F00", "#009E73", "#D55E00", "#5A5A5A"
SIZE, DPI = (5.4, 2.9), 160
"""Inches, and pixels per inch: letters stay legible when a phone shows the picture 360 pixels wide."""
MAX_LABELLED_EVENTS = 8
"""Largest number of events that a plot names; all get a tick."""
MAX_TICKS = 300
"""Largest number of ticks for events in a plot."""


@dataclass(frozen=True)
class PlotBound:
    """Bounds that an expectation puts on a measure, over a span of time [s]."""

    name: str
    start: float
    end: float
    low: float | None
    """The measure must be above this."""
    high: float | None
    """The measure must be below this."""
    ok: bool | None
    every: bool = True
    """It holds for every value in the span; otherwise some value has to meet it, and nothing is forbidden."""


@dataclass(frozen=True)
class PlotLine:
    """A series to draw."""

    label: str
    values: Array
    color: str = BLUE
    dashes: str = "-"


def plot_series(
    path: Path,
    time: Array,
    lines: Sequence[PlotLine],
    *,
    title: str,
    unit: str,
    bounds: Sequence[PlotBound] = (),
    events: Sequence[Mapping[str, Any]] = (),
) -> None:
    """Draw series over time into a PNG.

    Args:
        path: The file, overwritten.
        time: Times [s], shape (F,).
        lines: Series of shape (F,) in one unit.
        title: Title of the plot.
        unit: Unit of the vertical axis.
        bounds: Bounds to draw: forbidden values are shaded.
        events: Occurrences with `name` and `time`, drawn as ticks.
    """
    # Not pyplot: no global state, no display, any thread.
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=SIZE, dpi=DPI, facecolor="white")
    FigureCanvasAgg(figure)
    # Fixed margins: fitting them to the labels takes longer than drawing all the rest.
    axes = figure.add_axes((0.145, 0.15, 0.83, 0.75))
    several = len(lines) > 1
    for line in lines:
        finite = np.where(np.isfinite(line.values), line.values, np.nan)
        marker = "o" if len(time) == 1 else None
        label = plain_line(line.label) if several else None
        axes.plot(time, finite, line.dashes, color=line.color, linewidth=1.6, label=label, marker=marker)
    low, high = _data_range(lines)
    shown = [_draw_bound(axes, bound, low, high, time) for bound in bounds]
    _draw_events(axes, events)
    _frame(axes, low, high, shown, time)
    axes.set_title(plain_line(title), fontsize=9, loc="left", parse_math=False, wrap=True)
    axes.set_xlabel("time [s]", fontsize=8)
    axes.set_ylabel(f"[{unit}]" if unit else "number", fontsize=8)
    axes.yaxis.set_label_coords(-0.125, 0.5)
    if several or bounds:
        for text in axes.legend(fontsize=7, loc="best", framealpha=0.85).get_texts():
            text.set_parse_math(False)  # names may contain `$`
    path.parent.mkdir(exist_ok=True)
    with naming(path), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph")  # a missing glyph is drawn as a box
        figure.savefig(path, metadata={"Software": None})


def _data_range(lines: Sequence[PlotLine]) -> tuple[float, float]:
    finite = np.concatenate([line.values[np.isfinite(line.values)] for line in lines] or [np.zeros(0)])
    return (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 1.0)


def _frame(axes: "Axes", low: float, high: float, shown: Sequence[list[float]], time: Array) -> None:
    edges = [low, high, *(edge for row in shown for edge in row)]
    span = max(edges) - min(edges)
    # A constant gets a range of its own magnitude, or rounding noise would look like a signal.
    margin = 0.08 * span if span > 1e-9 * max(abs(low), abs(high), 1e-12) else 0.5 * max(abs(high), 1e-3)
    axes.set_ylim(min(edges) - margin, max(edges) + margin)
    if len(time) > 1:
        axes.set_xlim(float(time[0]), float(time[-1]))
    axes.tick_params(labelsize=8)
    axes.grid(color="#dddddd", linewidth=0.5)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def _draw_bound(axes: "Axes", bound: PlotBound, low: float, high: float, time: Array) -> list[float]:
    """Shade what an expectation forbids; return the bounds that must be in view."""
    color = {True: GREEN, False: VERMILION, None: GREY}[bound.ok]
    sign = {True: "✓", False: "✗", None: "?"}[bound.ok]
    width = float(time[-1] - time[0]) if len(time) else 1.0
    start, end = bound.start, bound.end
    if end - start < 0.02 * width:  # a moment is drawn as a narrow gate
        start, end = start - 0.01 * width, end + 0.01 * width
    span = max(high - low, 1e-3 * max(abs(low), abs(high)), 1e-12)
    edges = [e for e in (bound.low, bound.high) if e is not None]
    near = [e for e in edges if low - 2 * span <= e <= high + 2 * span]
    label = f"{sign} {bound.name}" + ("" if len(near) == len(edges) else " (beyond the frame)")
    for edge in near:
        axes.plot([start, end], [edge, edge], "--", color=color, linewidth=1.3, label=label)
        label = ""  # named once
        if not bound.every:
            continue
        below = edge == bound.low
        far = min(low, *near) - span if below else max(high, *near) + span
        axes.fill_between([start, end], edge, far, color=color, alpha=0.12, linewidth=0, hatch="///")
    if label:
        axes.plot([], [], "--", color=color, linewidth=1.3, label=label)
    return near


def _draw_events(axes: "Axes", events: Sequence[Mapping[str, Any]]) -> None:
    named: dict[str, float] = {}
    for event in events:
        named.setdefault(str(event["name"]), float(event["time"]))
    height = axes.get_xaxis_transform()
    for event in list(events)[:MAX_TICKS]:
        axes.plot([event["time"]] * 2, [0.0, 0.03], color=GREY, linewidth=0.8, transform=height)
    for number, (name, time) in enumerate(list(named.items())[:MAX_LABELLED_EVENTS]):
        axes.axvline(time, color=GREY, linewidth=0.8, linestyle=":")
        y = 0.98 - 0.085 * (number % 4)
        axes.text(time, y, f" {name}", fontsize=6.5, color="#333333", transform=height, va="top", clip_on=True)
