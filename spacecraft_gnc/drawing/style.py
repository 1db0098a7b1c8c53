"""Look of the figures: colors, fonts and units.

**Source** of the palette: Okabe and Ito (2008), distinguishable with every common color-vision
deficiency.
"""

from __future__ import annotations

import math
from contextlib import AbstractContextManager
from typing import Any, Final, NamedTuple

import numpy as np

from spacecraft_gnc.types import Array

AXIS_COLORS: Final = ("#0072B2", "#D55E00", "#009E73")
"""Body axes x, y, z: blue, vermilion, bluish green."""
AXIS_STYLES: Final = ("-", (0, (5, 1.2)), (0, (1.2, 1.0)))
"""Line styles of x, y, z, so that a gray print can be read too."""
COMPONENT_COLORS: Final = (*AXIS_COLORS, "#CC79A7")
COMPONENT_STYLES: Final = (*AXIS_STYLES, (0, (5, 1, 1, 1)))
"""Of x, y, z, w."""
RUN_COLORS: Final = (*AXIS_COLORS, "#CC79A7", "#E69F00", "#56B4E9", "#000000")
"""Runs beside each other, in this order."""
SOURCE_COLORS: Final = ("#009E73", "#56B4E9", "#E69F00", "#D55E00", "#000000", "#0072B2")
"""By number of `loop.Source`."""
PASSED_COLOR, FAILED_COLOR = AXIS_COLORS[0], AXIS_COLORS[1]
DENSITY_COLORS: Final = ("#E3EEF7", "#8FBFE0", "#3C86BE", "#08427A", "#041F3D")
"""Few to many."""
RATE_COLORS: Final = ("#A33C00", "#D55E00", "#F2C6A5", "#F1F1EE", "#9CC7E3", "#0072B2")
"""Success rate 0 to 1."""
ZONE_COLORS: Final = {"exclusion": "#C4457E", "inclusion": "#56B4E9"}
INK: Final = "#222222"
LIMIT_COLOR: Final = "#B0282E"
MUTED: Final = "#6E6E6E"
GRID_COLOR: Final = "#DDDDDD"

_RC_PARAMS: Final[dict[Any, Any]] = {
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "axes.titlesize": 10.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 9.0,
    "axes.labelcolor": INK,
    "axes.edgecolor": MUTED,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": GRID_COLOR,
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.4,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "text.color": INK,
    "figure.dpi": 100.0,
    "figure.constrained_layout.h_pad": 0.08,  # [inch]
    "figure.constrained_layout.w_pad": 0.08,  # [inch]
    "savefig.dpi": 200.0,
    "svg.fonttype": "path",  # the same glyphs on every machine
    "svg.hashsalt": "spacecraft_gnc",  # the same file for the same data
    "pdf.fonttype": 42,
}


def applied() -> AbstractContextManager[None]:
    """Return a context in which figures are drawn and saved in this style."""
    import matplotlib as mpl  # here: a page of the report has the colors without it

    return mpl.rc_context(_RC_PARAMS)


class Unit(NamedTuple):
    """A unit with an SI prefix, and the factor that takes SI values to it."""

    label: str
    factor: float


def prefixed(unit: str, *values: Array) -> Unit:
    """Return ``unit`` with the prefix that keeps the largest of ``values`` between 0.2 and 200.

    ``prefixed("N m", torque)`` is millinewton meters for torques around 0.01.
    """
    finite = [np.abs(array[np.isfinite(array)]).max(initial=0.0) for array in values]
    largest = float(max(finite, default=0.0))
    if largest == 0.0:
        return Unit(unit, 1.0)
    thousands = min(max(math.floor((math.log10(largest) + 0.7) / 3.0), -3), 1)
    prefix = {-3: "n", -2: "µ", -1: "m", 0: "", 1: "k"}[thousands]
    return Unit(prefix + unit, 1000.0**-thousands)
