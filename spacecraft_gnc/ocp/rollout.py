"""One control sequence rolled out over a problem's horizon, with its derivatives."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.ocp import _adjoint_kernels, _stage_kernels, _track_kernels
from spacecraft_gnc.ocp.reference import Tracked, as_reference, unreachable
from spacecraft_gnc.types import Array, ArrayLike, as_rotation, as_vector3


class Problem(Protocol):
    """What is rolled out: an `AttitudeOcp`."""

    @property
    def horizon(self) -> int:
        """Steps N."""

    @property
    def time_step(self) -> float:
        """Step h [s]."""

    @property
    def body(self) -> RigidBody:
        """Inertia and integrator step."""

    @property
    def data(self) -> Array:
        """The numbers of the problem, as the kernels read them."""

    @property
    def zone_rows(self) -> Array:
        """The zones, likewise."""

    @property
    def control_axes(self) -> Array:
        """Axes (m, m) in which the kernels write the controls."""

    @property
    def n_controls(self) -> int:
        """Controls of one step."""

    def checked_controls(self, controls: ArrayLike, /) -> Array:
        """Return controls as an array (N, m)."""


class Horizon:
    """One control sequence rolled out, with the work arrays that the adjoint kernels share."""

    def __init__(
        self,
        ocp: Problem,
        controls: ArrayLike,
        attitude: ArrayLike,
        momentum: ArrayLike,
        reference: Tracked | None,
    ) -> None:
        n = ocp.horizon
        self.ocp = ocp
        controls = ocp.checked_controls(controls)
        self.attitudes = np.empty((n + 1, 3, 3))
        self.momenta = np.empty((n + 1, 3))
        self.attitudes[0] = as_rotation("attitude", attitude)
        self.momenta[0] = as_vector3("momentum", momentum)
        self.work = np.zeros((n, _stage_kernels.work_size(ocp.n_controls)))
        self.track = track_of(ocp, reference)
        turned = np.ascontiguousarray(controls @ ocp.control_axes)
        done = _adjoint_kernels.rollout(
            ocp.body.packed, ocp.data, self.attitudes, self.momenta, turned, self.work
        )
        if done != n:
            ocp.body.require_solvable(f"momentum at step {done}", self.momenta[done])

    def gradient(self) -> Array:
        """Gradient (N, m) of the cost; fills `costates` (N, 6)."""
        self.costates = np.empty((self.ocp.horizon, 6))
        gradient = np.empty((self.ocp.horizon, self.ocp.n_controls))
        _adjoint_kernels.adjoint_gradient(
            self.ocp.data,
            self.ocp.zone_rows,
            self.track,
            self.attitudes,
            self.momenta,
            self.costates,
            self.work,
            gradient,
        )
        return np.asarray(gradient @ self.ocp.control_axes.T)

    def hessian(self) -> Array:
        """Second derivative (mN, mN) of the cost."""
        n, m = self.ocp.horizon, self.ocp.n_controls
        self.gradient()
        hessian = np.zeros((m * n, m * n))
        _adjoint_kernels.reduced_hessian(
            self.ocp.body.packed,
            self.ocp.data,
            self.ocp.zone_rows,
            self.track,
            self.attitudes,
            self.momenta,
            self.costates,
            self.work,
            np.empty((n + 1, 6)),
            hessian,
        )
        axes = np.kron(np.eye(n), self.ocp.control_axes)
        return np.asarray(axes @ hessian @ axes.T)


def track_of(ocp: Problem, reference: Tracked | None) -> Array:
    """Return a reference as the kernels want it: `_track_kernels.set_track`."""
    track = np.empty(_track_kernels.track_size(ocp.horizon, ocp.n_controls))
    checked = as_reference(reference)
    rows = (tuple(np.ravel(value).tolist()) for value in checked)
    if not _track_kernels.set_track(ocp.body.packed, ocp.data, *rows, track):
        raise unreachable(checked, ocp.time_step)
    return track
