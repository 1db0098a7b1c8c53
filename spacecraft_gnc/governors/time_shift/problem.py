"""Formation problem of the time shift governor: loop, natural motion, limits and cost."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.arguments import as_count, as_real
from spacecraft_gnc.arrays import as_finite, as_float
from spacecraft_gnc.errors import ParameterError, ShapeError
from spacecraft_gnc.types import Array, read_only

Integers = NDArray[np.int64]

_CLOSED: Final = 1e-6  # of the size of the motion, by which the natural motion may miss itself
_MOST: Final = 10_000_000  # combinations of shifts that one step may enumerate


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class TimeShiftProblem:
    """Craft that form up on one natural motion, each under x+ = A (x + [0; K (x - x_d)]).

    The commanded state of craft i at step k is x_d = natural[(k + phases[i] + shift_i) mod p].

    Attributes
    ----------
    state_map : (6, 6) array
        A of one sample: positions [m], velocities [m/s]. The impulse comes before the drift.
    gain : (3, 6) array
        K: delta-v = K (x - x_d) [m/s].
    natural : (p, 6) array
        Natural motion, one state a sample, of period p: natural[k + 1] = A natural[k].
    phases : (n,) array of int
        theta_i, place of each craft in the desired formation [samples].
    max_delta_v : float
        Largest length of a craft's delta-v [m/s]; infinity: no limit.
    min_separation : float
        Least distance of two craft [m]; 0: no limit.
    max_angle : float
        Largest angle between actual and commanded relative position of two craft [rad]; pi: no
        limit.
    state_weight, control_weight : (6, 6), (3, 3) arrays
        Q and R of the stage cost of Omega [1/m^2, (s/m)^2].
    shift_weight : float
        Factor of W [1/samples^2].
    horizon : int
        N, steps that are predicted.
    substeps : int
        Instants within a sample at which separation and angle are tested; 1: at samples only.

    Raises
    ------
    ShapeError
        If the arrays do not fit.
    ParameterError
        If a number is not allowed, the loop is unstable, the motion is not natural, or there are
        more combinations of shifts than can be enumerated.

    Source: report of AFRL (Kolmanovsky 2016), section 3.3, (14)-(20).
    """

    state_map: Array
    gain: Array
    natural: Array
    phases: Integers
    max_delta_v: float
    min_separation: float
    max_angle: float
    state_weight: Array
    control_weight: Array
    shift_weight: float = 1.0
    horizon: int = 100
    substeps: int = 1

    def __post_init__(self) -> None:
        for name, shape in (
            ("state_map", (6, 6)),
            ("gain", (3, 6)),
            ("state_weight", (6, 6)),
            ("control_weight", (3, 3)),
        ):
            self._set(name, as_finite(name, getattr(self, name), shape, f"{shape} numbers"))
        self._check_limits()
        self._check_motion()
        self._set("phases", self._as_phases())
        if self.samples**self.n_craft > _MOST:
            raise ParameterError(
                f"phases: received {self.n_craft} craft with {self.samples} shifts each, "
                f"{self.samples**self.n_craft:.3g} combinations; required at most {_MOST:.0e}; "
                "give fewer craft or fewer samples"
            )
        radius = float(np.abs(np.linalg.eigvals(self.loop_map)).max())
        if not radius < 1.0:
            raise ParameterError(
                f"gain: received one with spectral radius {radius:.6g} of the loop; required less "
                "than 1; compute the gain for this state map"
            )

    @property
    def n_craft(self) -> int:
        """Number of craft n."""
        return len(self.phases)

    @property
    def samples(self) -> int:
        """Number of samples p of a period, and of shifts of a craft."""
        return len(self.natural)

    @property
    def loop_map(self) -> Array:
        """A + B K (6, 6): maps the error x - x_d to the next one."""
        return np.asarray(self.state_map + self.state_map[:, 3:] @ self.gain)

    def commanded(self, step: int, shifts: Integers) -> Array:
        """Return the commanded states (n, 6) at a step."""
        return np.asarray(self.natural[(step + self.phases + shifts) % self.samples])

    def delta_v(self, step: int, states: Array, shifts: Integers) -> Array:
        """Return the delta-v (n, 3) that the craft's laws ask for [m/s]."""
        return np.asarray((states - self.commanded(step, shifts)) @ self.gain.T)

    def step(self, states: Array, delta_v: Array) -> Array:
        """Return the states (n, 6) one sample on."""
        return np.asarray(states @ self.state_map.T + delta_v @ self.state_map[:, 3:].T)

    def _check_limits(self) -> None:
        if self.max_delta_v != math.inf:
            self._set("max_delta_v", _positive("max_delta_v", self.max_delta_v, "infinity"))
        least = as_real(
            "min_separation", self.min_separation, lambda x: x >= 0.0, "at least 0", "give 0"
        )
        between = "a number from 0, excluded, to pi"
        angle = as_real(
            "max_angle", self.max_angle, lambda x: 0.0 < x <= math.pi, between, "give pi"
        )
        self._set("min_separation", least)
        self._set("max_angle", angle)
        self._set("shift_weight", _positive("shift_weight", self.shift_weight, "1"))
        as_count("horizon", self.horizon)
        as_count("substeps", self.substeps)

    def _check_motion(self) -> None:
        shape = as_float("natural", self.natural, "an array of shape (p, 6)").shape
        if len(shape) != 2 or shape[1] != 6 or shape[0] < 2:
            raise ShapeError(
                f"natural: received an array of shape {shape}; required (p, 6), p at least 2; "
                "give one state for each sample of the period"
            )
        self._set("natural", as_finite("natural", self.natural, shape, "an array (p, 6)"))
        missed = np.abs(self.natural @ self.state_map.T - np.roll(self.natural, -1, axis=0))
        share = float((missed.max(axis=0) / _sizes(self.natural)).max())
        if share > _CLOSED:
            raise ParameterError(
                f"natural: received a motion that misses its next sample by {share:.3g} of its "
                f"size; required natural[k + 1] = state_map natural[k], round the period, to "
                f"{_CLOSED:g}; compute it with this state map"
            )

    def _as_phases(self) -> Integers:
        numbers = as_float("phases", self.phases, "one whole number for each craft")
        if numbers.ndim != 1 or len(numbers) < 2:
            raise ShapeError(
                f"phases: received an array of shape {numbers.shape}; required (n,), at least 2 "
                "craft; give one whole number for each"
            )
        whole = np.round(as_finite("phases", numbers, numbers.shape, "whole numbers"))
        if (whole != numbers).any():
            raise ParameterError(
                f"phases: received {numbers.tolist()}; required whole numbers; round them"
            )
        phases = whole.astype(np.int64) % self.samples
        phases.setflags(write=False)
        return phases

    def _set(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)


def shift_distance(p: int) -> Array:
    """Return the distances (p, p) of two shifts on the circle [samples]."""
    ahead = np.abs(np.subtract.outer(np.arange(p), np.arange(p)))
    return read_only(np.minimum(ahead, p - ahead).astype(np.float64))


def _sizes(natural: Array) -> Array:
    """Return the size (6,) of each column: that of all positions, or of all velocities."""
    sizes = np.repeat([np.abs(natural[:, :3]).max(), np.abs(natural[:, 3:]).max()], 3)
    return np.asarray(np.maximum(sizes, 1e-300))


def _positive(name: str, value: object, example: str) -> float:
    return as_real(name, value, lambda x: x > 0.0, "a positive number", f"give {example}")
