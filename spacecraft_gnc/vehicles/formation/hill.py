"""Hill's equations of motion relative to a circular orbit, and their closed trajectories.

Hill's frame: x radial and outward, y along the track, z along the orbit normal; it turns with the
orbit at the mean motion n. Free motion near its origin follows, to first order in the distance,

    x'' = 3 n^2 x + 2 n y',   y'' = -2 n x',   z'' = -n^2 z.

A state is a row (x, y, z, x', y', z') [m], [m/s]. It does not drift along the track where
y' = -2 n x; in the orbital plane it then goes around a 2x1 ellipse in one orbital period:

    x = a cos(phi),   y = y0 - 2 a sin(phi),   phi' = n.

Source: Clohessy and Wiltshire, J. Aerospace Sci. 27 (1960).
"""

from __future__ import annotations

import math

import numpy as np

from spacecraft_gnc.arguments import as_count, as_real, require_positive
from spacecraft_gnc.arrays import as_finite
from spacecraft_gnc.types import Array, ArrayLike, read_only


def transition(mean_motion: float, time: float) -> Array:
    """Return the transition matrix A: state(t + time) = A state(t).

    Parameters
    ----------
    mean_motion : float
        n [rad/s].
    time : float
        Of either sign [s].

    Returns
    -------
    (6, 6) array
        Exact; read-only.

    Raises
    ------
    ParameterError
        If the mean motion is not positive, or the time not finite.
    """
    n = require_positive("mean_motion", mean_motion)
    angle = n * as_real("time", time, math.isfinite, "a finite time [s]", "give for example 60.0")
    s, c, d = math.sin(angle), math.cos(angle), 2.0 * math.sin(0.5 * angle) ** 2  # d = 1 - c
    return read_only(np.array([
        [1.0 + 3.0 * d, 0.0, 0.0, s / n, 2.0 * d / n, 0.0],
        [6.0 * (s - angle), 1.0, 0.0, -2.0 * d / n, (4.0 * s - 3.0 * angle) / n, 0.0],
        [0.0, 0.0, c, 0.0, 0.0, s / n],
        [3.0 * n * s, 0.0, 0.0, c, 2.0 * s, 0.0],
        [-6.0 * n * d, 0.0, 0.0, -2.0 * s, 1.0 - 4.0 * d, 0.0],
        [0.0, 0.0, -n * s, 0.0, 0.0, c],
    ]))  # fmt: skip


def impulse_input(over_step: Array) -> Array:
    """Return B (6, 3) of x_k+1 = A x_k + B dv_k: an impulse at the start of the step, then drift.

    ``over_step``: the transition matrix A (6, 6) of one control step.
    """
    matrix = as_finite("over_step", over_step, (6, 6), "a matrix (6, 6)")
    return read_only(matrix[:, 3:].copy())


def drift_rate(mean_motion: float, states: Array) -> Array:
    """Return the mean velocity along the track [m/s], -3 (2 n x + y') (...), of states (..., 6)."""
    return np.asarray(-3.0 * (2.0 * mean_motion * states[..., 0] + states[..., 4]))


def natural_states(mean_motion: float, radial_semi_axis: float, samples: int) -> Array:
    """Return the states on the 2x1 ellipse around the origin, at the samples of one orbit.

    Parameters
    ----------
    mean_motion : float
        n [rad/s].
    radial_semi_axis : float
        a, along x [m]; the semi-axis along y is twice as long.
    samples : int
        Number p of samples, equally spaced in time.

    Returns
    -------
    (p, 6) array
        Row k is at the angle phi = 2 pi k / p from the highest point (a, 0, 0). The transition over
        a sample takes row k to row (k + 1) mod p. Read-only.

    Raises
    ------
    ParameterError
        If mean motion or semi-axis is not positive, or there are fewer than 3 samples.
    """
    count = as_count("samples", samples, 3)
    return read_only(_on_ellipse(mean_motion, radial_semi_axis, count, np.arange(float(count))))


def start_states(
    mean_motion: float,
    radial_semi_axis: float,
    samples: int,
    phase: ArrayLike,
    along_track_offset: ArrayLike,
    amplitude: ArrayLike,
) -> Array:
    """Return states of craft that each move on an ellipse of their own, and so do not drift.

    Parameters
    ----------
    mean_motion, radial_semi_axis, samples
        Of the nominal ellipse, as in `natural_states`.
    phase : (n,) array
        Where each craft is on its ellipse [samples]; need not be whole.
    along_track_offset : (n,) array
        Center of each ellipse along y [m].
    amplitude : (n,) array
        Size of each as a share of the nominal one.

    Returns
    -------
    (n, 6) array
        Read-only.

    Raises
    ------
    ShapeError, ParameterError
        If there are not n finite numbers of each, or the nominal ellipse is refused.
    """
    n, count = np.size(phase), as_count("samples", samples, 3)
    phases = as_finite("phase", phase, (n,), "one number for each craft [samples]")
    states = _on_ellipse(mean_motion, radial_semi_axis, count, phases)
    need = f"{n} numbers, one for each phase"
    states *= as_finite("amplitude", amplitude, (n,), need)[:, None]
    states[:, 1] += as_finite("along_track_offset", along_track_offset, (n,), need)
    return read_only(states)


def _on_ellipse(mean_motion: float, semi_axis: float, samples: int, phase: Array) -> Array:
    """Return states (m, 6) at phases (m,)."""
    n = require_positive("mean_motion", mean_motion)
    a = require_positive("radial_semi_axis", semi_axis)
    angle = 2.0 * math.pi / samples * phase
    x, lead, still = a * np.cos(angle), a * np.sin(angle), np.zeros_like(angle)
    return np.stack([x, -2.0 * lead, still, -n * lead, -2.0 * n * x, still], axis=1)
