"""Default that follows from other values: the inertia of a cuboid of constant density.

The formula stands in words beside its parameter; docs/scenario.md prints it.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from spacecraft_gnc.parameters.checked import Checked
from spacecraft_gnc.parameters.formulas import Formula, Missing
from spacecraft_gnc.parameters.parameter import Value

_PLANT = "plant"


def formulas(checked: Checked) -> Iterator[Formula]:
    """Yield the formula of each default, in the order of their dependence."""
    yield Formula(_PLANT, "inertia", partial(_inertia, checked))


def _inertia(checked: Checked) -> Value:
    mass, size = checked.get(_PLANT, "mass"), checked.get(_PLANT, "deputy_size")
    if not isinstance(mass, float) or not isinstance(size, list) or len(size) != 3:
        raise Missing
    squares = np.square(size)
    diagonal = mass / 12.0 * (squares.sum() - squares)
    return [float(f"{value:.12g}") for value in np.diag(diagonal).ravel()]
