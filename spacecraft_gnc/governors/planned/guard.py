"""Bounds on torque and momentum, kept by clipping the command."""

from __future__ import annotations

import numpy as np

from spacecraft_gnc.arguments import require_kind
from spacecraft_gnc.arrays import as_shaped
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.errors import GncError
from spacecraft_gnc.types import Array, ArrayLike, Vector3, read_only


class BoundGuard:
    """Clip a torque, component by component, to the bounds and to what keeps the momentum in its.

    The momentum that a torque u leads to in one step is F^T Pi + h u, and F does not depend on u:
    the bounds on it are bounds on u. Where both cannot be kept, those on the torque are.

    Parameters
    ----------
    body : RigidBody
        Inertia that is believed; the step h is the control period.
    limits : (4, 3) array
        Lower and upper torque [N m], lower and upper momentum [N m s]; infinite: none.

    Raises
    ------
    ShapeError, ParameterError
        If an argument is refused.
    """

    def __init__(self, body: RigidBody, limits: ArrayLike) -> None:
        self._body = require_kind("body", body, RigidBody)
        self.limits: Array = read_only(np.array(as_shaped("limits", limits, (4, 3))))
        self._bounds_momentum = bool(np.isfinite(self.limits[2:]).any())

    def clip(self, momentum: Vector3, torque: Vector3) -> Vector3:
        """Return the torque (3,) nearest to ``torque`` [N m] at ``momentum`` (3,) [N m s]."""
        low, high, least, most = self.limits
        kept = np.asarray(torque)
        if self._bounds_momentum:
            try:
                _, free = self._body.step(np.eye(3), momentum, np.zeros(3))
            except GncError:  # a step that does not exist leads to no momentum
                free = momentum
            h = self._body.time_step
            kept = np.clip(kept, (least - free) / h, (most - free) / h)
        return read_only(np.clip(kept, low, high))
