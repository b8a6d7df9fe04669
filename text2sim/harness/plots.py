"""Plots of measures, and the contact sheet of a film.

Colours are those of Okabe and Ito, which people who confuse red and green can tell apart; every line of meaning also
has a dash pattern of its own.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from text2sim.harness.diagnostics import energy_series
from text2sim.harness.evidence import WrittenEvent, read_events
from text2sim.harness.expectations import Ending
from text2sim.harness.measures import Series, evaluate
from text2sim.harness.recording import Recording
from text2sim.harness.states import Array
from text2sim.harness.visibility import read_samples
from text2sim.spec_schema.actions import Expect
from text2sim.spec_schema.case import Case

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BLUE, ORANGE, GREEN, VERMILION, GREY = "#0072B2", "#E69F00", "#009E73", "#D55E00", "#666666"
