"""Linear quadratic regulator of a periodic discrete system.

For x_k+1 = A_k x_k + B_k u_k, with A and B of period p, the law u_k = -K_k x_k minimizes the sum of
x^T Q x + u^T R u over k = 0, 1, ... from every start. With S = P_k+1,

    K_k = (R + B_k^T S B_k)^-1 B_k^T S A_k,   P_k = Q + A_k^T S (A_k - B_k K_k),   P_k+p = P_k.

The recursion over one period is one map of P, and so are two of them; doubling this map reaches the
periodic solution in a few steps, whatever the rate of the closed loop.

Source: Bittanti, Laub and Willems (eds.), The Riccati Equation (1991), ch. 6; Chu, Fan, Lin and
Wang, Int. J. Control 77 (2004), the doubling.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from spacecraft_gnc.arrays import as_finite, as_float, listed
from spacecraft_gnc.errors import ParameterError, ShapeError
from spacecraft_gnc.types import Array, ArrayLike, read_only

MOST_DOUBLINGS: Final = 60
_CONVERGED: Final = 1e-14  # of P, relative change of a doubling; the next would be rounding
_UNREACHED: Final = 1e-10  # a reachable mode has more than this share of the controls' effect
_SYMMETRY: Final = 1e-12


class PeriodicGains(NamedTuple):
    """Gains K_k and cost matrices P_k for k = 0 ... p - 1; the arrays are read-only."""

    gains: Array
    """(p, m, n) K_k."""
    costs: Array
    """(p, n, n) P_k: x^T P_k x is the least cost from x at step k on."""
    spectral_radius: float
    """Largest size of a multiplier of the closed loop over one period, less than 1."""


class _Map(NamedTuple):
    """P at the start of some steps from S at their end: P = H + A^T S (1 + G S)^-1 A."""

    A: Array
    G: Array
    H: Array

    def then(self, later: _Map) -> _Map:
        """Return the map over these steps and the later ones."""
        both = np.eye(len(self.A)) + self.G @ later.H
        from_a, from_g = np.split(np.linalg.solve(both, np.hstack([self.A, self.G])), 2, axis=1)
        G = later.G + later.A @ from_g @ later.A.T
        H = self.H + self.A.T @ later.H @ from_a
        return _Map(later.A @ from_a, _symmetric(G), _symmetric(H))


def periodic_lqr(A: ArrayLike, B: ArrayLike, Q: ArrayLike, R: ArrayLike) -> PeriodicGains:
    """Return the gains and cost matrices of the periodic regulator; p = 1 is the ordinary one.

    Parameters
    ----------
    A, B : (p, n, n), (p, n, m) arrays
        The system.
    Q, R : (n, n), (m, m) arrays
        Weights, symmetric; Q positive semi-definite, R positive definite.

    Returns
    -------
    PeriodicGains

    Raises
    ------
    ShapeError
        If the shapes do not fit together.
    ParameterError
        If a number is not finite, a weight is refused, a mode that does not decay is out of reach
        of the controls, or the weight Q does not see one.
    """
    A, B = _as_system(A, B)
    Q, R = _as_weight("Q", Q, A.shape[1]), _as_weight("R", R, B.shape[2])
    if np.linalg.eigvalsh(R)[0] <= 0.0:
        raise _refused("R", R, "a positive definite weight", "give each control a cost")
    if np.linalg.eigvalsh(Q)[0] < -_SYMMETRY * np.abs(Q).max():
        raise _refused("Q", Q, "a positive semi-definite weight", "use no negative eigenvalue")
    _require_stabilizable(A, B)
    P = _fixed_point(A, B, Q, R)
    for _ in range(2):  # the first sweep takes away the rounding of the doublings
        gains, costs = _sweep(A, B, Q, R, P)
        P = costs[0]
    radius = float(np.abs(np.linalg.eigvals(_monodromy(A - B @ gains))).max())
    if not radius < 1.0:
        raise ParameterError(
            f"Q: received a weight with which a closed-loop multiplier has size {radius:.6g}; "
            "required a weight that sees every mode that does not decay; weigh more of the state"
        )
    return PeriodicGains(read_only(gains), read_only(costs), radius)


def _as_system(A: ArrayLike, B: ArrayLike) -> tuple[Array, Array]:
    A, B = as_float("A", A, "an array (p, n, n)"), as_float("B", B, "an array (p, n, m)")
    if A.ndim != 3 or A.shape[1] != A.shape[2] or not A.size:
        raise ShapeError(
            f"A: received an array of shape {A.shape}; required (p, n, n); stack one matrix for "
            "each step of the period"
        )
    if B.ndim != 3 or B.shape[:2] != A.shape[:2] or not B.size:
        raise ShapeError(
            f"B: received an array of shape {B.shape}; required ({len(A)}, {A.shape[1]}, m) to go "
            "with A; stack one matrix for each step of the period"
        )
    return as_finite("A", A, A.shape, "numbers"), as_finite("B", B, B.shape, "numbers")


def _as_weight(name: str, value: ArrayLike, size: int) -> Array:
    weight = as_finite(name, value, (size, size), f"a matrix ({size}, {size})")
    if np.abs(weight - weight.T).max() > _SYMMETRY * np.abs(weight).max():
        raise _refused(name, weight, "a symmetric weight", "mirror the off-diagonal entries")
    return weight


def _refused(name: str, weight: Array, need: str, remedy: str) -> ParameterError:
    spectrum = listed(np.linalg.eigvalsh(_symmetric(weight)))
    return ParameterError(
        f"{name}: received a matrix with eigenvalues {spectrum} (of its symmetric part); required "
        f"{need}; {remedy}"
    )


def _require_stabilizable(A: Array, B: Array) -> None:
    """Raise ParameterError if the controls do not reach a mode that does not decay."""
    reach = np.zeros_like(A[0])
    for A_k, B_k in zip(A, B, strict=True):
        reach = A_k @ reach @ A_k.T + B_k @ B_k.T
    size = np.trace(reach)
    multipliers, rows = np.linalg.eig(_monodromy(A).T)
    for multiplier, row in zip(multipliers, rows.T, strict=True):
        reached = np.real(row.conj() @ reach @ row)
        if abs(multiplier) >= 1.0 - _SYMMETRY and reached <= _UNREACHED**2 * size:
            raise ParameterError(
                f"A, B: received a mode with multiplier {multiplier:.6g} over the period, which "
                "no control reaches; required a system that the controls can stabilize; add a "
                "control, or leave the mode out"
            )


def _fixed_point(A: Array, B: Array, Q: Array, R: Array) -> Array:
    """Return P_0 by doubling the map of one period."""
    G = B @ np.linalg.solve(R, B.transpose(0, 2, 1))
    over = _Map(A[0], _symmetric(G[0]), Q)
    for A_k, G_k in zip(A[1:], G[1:], strict=True):
        over = over.then(_Map(A_k, _symmetric(G_k), Q))
    for _ in range(MOST_DOUBLINGS):
        before, over = over, over.then(over)
        if np.abs(over.H - before.H).max() <= _CONVERGED * np.abs(over.H).max():
            break
    return over.H


def _sweep(A: Array, B: Array, Q: Array, R: Array, P: Array) -> tuple[Array, Array]:
    """Return gains and costs of one period that ends with the cost P."""
    gains, costs = np.empty(B.transpose(0, 2, 1).shape), np.empty(A.shape)
    for k in reversed(range(len(A))):
        K = np.linalg.solve(R + B[k].T @ P @ B[k], B[k].T @ P @ A[k])
        closed = A[k] - B[k] @ K  # Joseph's form keeps P symmetric and positive
        P = _symmetric(Q + K.T @ R @ K + closed.T @ P @ closed)
        gains[k], costs[k] = K, P
    return gains, costs


def _monodromy(A: Array) -> Array:
    """Return A_p-1 ... A_0."""
    over = np.eye(A.shape[1])
    for A_k in A:
        over = A_k @ over
    return over


def _symmetric(matrix: Array) -> Array:
    return np.asarray(0.5 * (matrix + matrix.T))
