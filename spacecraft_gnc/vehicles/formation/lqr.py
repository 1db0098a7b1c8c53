"""Gain of the linear quadratic feedback that takes each craft to its commanded state."""

from __future__ import annotations

import numpy as np

from spacecraft_gnc.arguments import as_limit, require_positive
from spacecraft_gnc.ocp.periodic_lqr import periodic_lqr
from spacecraft_gnc.types import Array, read_only
from spacecraft_gnc.vehicles.formation.hill import impulse_input


def formation_gain(
    over_step: Array, position: float = 1e-6, velocity: float = 1e-9, delta_v: float = 100.0
) -> Array:
    """Return K of the law dv = K (x - x_d), for which A + B K is stable.

    It minimizes the sum over all steps of the weighted squares of position error, velocity error
    and delta-v, where x_k+1 = A x_k + B dv_k, with B of an impulse at the start of the step.

    Parameters
    ----------
    over_step : (6, 6) array
        A, the transition matrix of one control step.
    position, velocity, delta_v : float, optional
        Weights [1/m^2], [s^2/m^2], [s^2/m^2]. The defaults are the report's, which are 1, 1e-3 and
        1e8 for km and km/s; the gain depends on their ratios alone, and so is the report's too.

    Returns
    -------
    (3, 6) array
        K [1/s], [1]; read-only. Its sign is the report's, the opposite of that of `periodic_lqr`.

    Raises
    ------
    ShapeError, ParameterError
        If an argument is refused.

    Notes
    -----
    Source: Kolmanovsky et al., AFRL final report (2016), (16) and Table 1.
    """
    through = impulse_input(over_step)
    weights = [require_positive("position", position), as_limit("velocity", velocity)]
    effort = require_positive("delta_v", delta_v) * np.eye(3)
    law = periodic_lqr(over_step[None], through[None], np.diag(np.repeat(weights, 3)), effort)
    return read_only(0.0 - law.gains[0])  # without -0.0
