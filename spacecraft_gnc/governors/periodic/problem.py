"""Periodic linear closed loop and its constraints.

x_{k+1} = A_k x_k + B_k v and C_k x_k + D_k v <= c_k, where every matrix has period p. The loop is
closed: v is the reference, constant in the prediction (report of AFRL, (6)-(11)).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from spacecraft_gnc.arguments import as_tuple
from spacecraft_gnc.arrays import as_finite, as_float
from spacecraft_gnc.errors import ParameterError, ShapeError
from spacecraft_gnc.types import Array, read_only


@dataclass(frozen=True, slots=True, eq=False)
class PeriodicLoop:
    """Stable closed loop x_{k+1} = A_k x_k + B_k v of period p.

    Attributes
    ----------
    state_map : (p, n, n) array
        A_k.
    reference_map : (p, n, q) array
        B_k.

    Raises
    ------
    ShapeError
        If the arrays do not fit.
    ParameterError
        If a number is not finite, or the loop is not asymptotically stable.
    """

    state_map: Array
    reference_map: Array

    def __post_init__(self) -> None:
        p, n, columns = _stack("state_map", self.state_map)
        _, _, q = _stack("reference_map", self.reference_map)
        if n != columns:
            raise ShapeError(
                f"state_map: received matrices of shape ({n}, {columns}); required square ones; "
                "give the matrices of the closed loop"
            )
        _set(self, "state_map", self.state_map, (p, n, n))
        _set(self, "reference_map", self.reference_map, (p, n, q))
        if not self.spectral_radius < 1.0:
            raise ParameterError(
                f"state_map: received a loop whose map over a period has spectral radius "
                f"{self.spectral_radius:.6g}; required less than 1; stabilize the loop first"
            )

    @property
    def period(self) -> int:
        """Number of steps p of a period."""
        return len(self.state_map)

    @property
    def n_states(self) -> int:
        """Number of states n."""
        return int(self.state_map.shape[1])

    @property
    def n_references(self) -> int:
        """Number of references q."""
        return int(self.reference_map.shape[2])

    @property
    def spectral_radius(self) -> float:
        """Spectral radius of the map over one period, A_{p-1} ... A_0."""
        return float(np.abs(np.linalg.eigvals(self._over_a_period()[0])).max())

    def steady_maps(self) -> Array:
        """Return the maps (p, n, q) from a constant reference to the periodic steady state.

        S_0 = (I - A_{p-1} ... A_0)^-1 (what v adds over a period), S_{k+1} = A_k S_k + B_k.
        """
        around, pushed = self._over_a_period()
        steady = np.empty_like(self.reference_map)
        steady[0] = np.linalg.solve(np.eye(self.n_states) - around, pushed)
        for k in range(self.period - 1):
            steady[k + 1] = self.state_map[k] @ steady[k] + self.reference_map[k]
        return steady

    def step(self, k: int, state: Array, reference: Array) -> Array:
        """Return the state (n,) after step k."""
        k %= self.period
        return np.asarray(self.state_map[k] @ state + self.reference_map[k] @ reference)

    def _over_a_period(self) -> tuple[Array, Array]:
        around, pushed = np.eye(self.n_states), np.zeros(self.reference_map.shape[1:])
        for a, b in zip(self.state_map, self.reference_map, strict=True):
            around, pushed = a @ around, a @ pushed + b
        return around, pushed


@dataclass(frozen=True, slots=True, eq=False)
class PeriodicConstraints:
    """Constraint rows C_k x + D_k v <= c_k of period p.

    Attributes
    ----------
    state_rows : (p, m, n) array
        C_k, in the units of c_k.
    reference_rows : (p, m, q) array
        D_k.
    bounds : (p, m) array
        c_k; infinity where a row does not apply at a step.
    names : tuple of str, (m,)
        For messages and telemetry, for example "force x <= 1 N".

    Raises
    ------
    ShapeError
        If the arrays do not fit.
    ParameterError
        If a number of a row is not finite, or a bound is NaN or minus infinity.
    """

    state_rows: Array
    reference_rows: Array
    bounds: Array
    names: tuple[str, ...]

    def __post_init__(self) -> None:
        p, m, n = _stack("state_rows", self.state_rows)
        _, _, q = _stack("reference_rows", self.reference_rows)
        _set(self, "state_rows", self.state_rows, (p, m, n))
        _set(self, "reference_rows", self.reference_rows, (p, m, q))
        bounds = as_float("bounds", self.bounds, f"an array of shape {(p, m)}")
        if bounds.shape != (p, m):
            raise ShapeError(
                f"bounds: received an array of shape {bounds.shape}; required {(p, m)}; "
                "give one bound for each row and step"
            )
        if not (bounds > -np.inf).all():
            raise ParameterError(
                "bounds: received NaN or minus infinity; required numbers, or infinity for a row "
                "that does not apply; correct the bound"
            )
        object.__setattr__(self, "bounds", read_only(bounds))
        object.__setattr__(self, "names", as_tuple("names", self.names, "str"))
        if len(self.names) != m:
            raise ShapeError(
                f"names: received {len(self.names)}; required {m}, one for each row; name them all"
            )

    def require_fit(self, loop: PeriodicLoop) -> None:
        """Refuse constraints of another period, state or reference than the loop's.

        Raises
        ------
        ShapeError
        """
        p, _, n = self.state_rows.shape
        found = (p, n, self.reference_rows.shape[2])
        required = (loop.period, loop.n_states, loop.n_references)
        if found != required:
            raise ShapeError(
                f"constraints: received rows of period, states and references {found}; required "
                f"{required} as the loop has; give rows of the same loop"
            )


def _stack(name: str, value: object) -> tuple[int, int, int]:
    shape = as_float(name, value, "one matrix for each step of a period").shape
    if len(shape) != 3 or 0 in shape:
        raise ShapeError(
            f"{name}: received an array of shape {shape}; required one matrix for each step of a "
            "period, (p, rows, columns); stack the matrices"
        )
    return shape


def _set(owner: object, name: str, value: object, shape: tuple[int, ...]) -> None:
    checked = as_finite(name, value, shape, f"finite numbers of shape {shape}")
    object.__setattr__(owner, name, checked)
