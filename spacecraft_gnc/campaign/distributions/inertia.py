"""Distribution of inertia matrices about that of the scenario."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.campaign.distributions.directions import Turn
from spacecraft_gnc.campaign.distributions.distribution import Target
from spacecraft_gnc.campaign.distributions.options import Options
from spacecraft_gnc.parameters.parameter import Kind, MatrixRule, ParameterSpec, Value
from spacecraft_gnc.types import Array, Matrix3, Vector3

_FLATTEST: Final = 1e-12  # share of the sum: below, rounding decides on the triangle inequality
_FACTOR: Final = ParameterSpec(
    kind=Kind.DOUBLE, default=0.0, description="", minimum=0.0, below=1.0
)
_ANGLE: Final = ParameterSpec(
    kind=Kind.DOUBLE, default=0.0, description="", unit="deg", minimum=0.0, maximum=180.0
)


@dataclass(frozen=True, slots=True)
class Inertia:
    """Inertia matrices of bodies like a nominal one.

    Each principal second moment, the integral of x_i^2 dm, is scaled by a factor of its own,
    uniform in 1 - factor ... 1 + factor, and the principal axes are turned by a rotation uniform up
    to an angle. Second moments stay positive, so the matrix is always that of a body: positive
    definite, with the triangle inequality of its principal moments.
    """

    axes: Matrix3
    """(3, 3) columns: principal axes, body frame."""
    second_moments: Vector3
    """(3,) about the center of mass, along these axes [kg m^2]."""
    factor: float
    turn: Turn

    @classmethod
    def about(cls, nominal: Matrix3, factor: float, angle: float) -> Inertia:
        """Return the distribution about a nominal matrix, axes turned by up to ``angle`` [rad]."""
        moments, axes = np.linalg.eigh(nominal)
        return cls(axes, 0.5 * moments.sum() - moments, factor, Turn(angle))

    @property
    def dimensions(self) -> int:
        """Three for the second moments, three for the axes, of what varies."""
        return 3 * (self.factor > 0.0) + 3 * (self.turn.angle > 0.0)

    @property
    def size(self) -> None:
        """A continuum."""
        return None

    def value(self, point: Array) -> Value:
        """Return the matrix at a point, row-major."""
        factors = np.ones(3)
        if self.factor > 0.0:
            factors += self.factor * (2.0 * point[:3] - 1.0)
        turn = self.turn.vector(point[-3:]) if self.turn.angle > 0.0 else np.zeros(3)
        return self._matrix(factors, turn)

    def extremes(self) -> Iterable[Value]:
        """Return the corners of the factors: between them lie all principal moments."""
        for signs in product((-1.0, 1.0), repeat=3):
            yield self._matrix(1.0 + self.factor * np.array(signs), np.zeros(3))

    def _matrix(self, factors: Vector3, turn: Vector3) -> list[float]:
        second = self.second_moments * factors
        axes = lie.exp(turn) @ self.axes
        inertia = (axes * (second.sum() - second)) @ axes.T
        numbers: list[float] = (0.5 * (inertia + inertia.T)).ravel().tolist()
        return numbers


def read_inertia(options: Options, target: Target) -> Inertia:
    """Return inertias within ``factor`` of ``about``, axes turned by up to ``axes_deg``.

    ``about`` is the scenario's where it is not given.
    """
    factor, angle = options.value("factor", _FACTOR), options.value("axes_deg", _ANGLE)
    about = options.value("about", target.spec) if options.has("about") else target.nominal
    nominal = np.eye(3)
    if target.spec.matrix is not MatrixRule.INERTIA:
        need = "a parameter that takes an inertia matrix"
        options.complain(
            "distribution", f"an inertia for {target.name}", need, "choose another one"
        )
    elif not about:
        need = f"{target.name} in the scenario, to vary about it"
        options.complain("distribution", "nothing", need, "add it there")
    elif options.is_valid:
        nominal = np.reshape(np.array(about, dtype=np.float64), (3, 3))
    if factor == 0.0 and angle == 0.0:
        options.complain("factor", "0.0, without axes_deg", "one of them > 0", "choose constant")
    if not options.is_valid:
        return Inertia.about(np.eye(3), 0.0, 0.0)
    inertia = Inertia.about(nominal, factor, math.radians(angle))
    smallest = float(inertia.second_moments.min()) * (1.0 - factor)
    if smallest < _FLATTEST * float(inertia.second_moments.sum()):
        need = f"a body whose second moments differ by less than a factor {1.0 / _FLATTEST:g}"
        received = f"a smallest second moment of {smallest:.3g} kg m^2"
        options.complain("", received, need, "choose choice, or a body with more volume")
    return inertia
