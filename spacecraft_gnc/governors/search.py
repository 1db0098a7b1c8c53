"""Largest admissible step of the reference along a geodesic, by bisection.

Source: Kalabic et al. 2014, (11), (15) and Algorithm 1.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.arguments import as_real, require_kind, require_members
from spacecraft_gnc.governors._geodesic_kernels import along
from spacecraft_gnc.governors.prediction import Prediction, Predictor
from spacecraft_gnc.governors.reference_set import ReferenceSet
from spacecraft_gnc.types import Array, Matrix3, State, read_only

# Room that a new reference needs, relative to each limit; what is held needs none.
RESERVE = 1e-9
# Angle [rad] off half a turn within which a target counts as a cut point of the reference.
CUT_POINT = 1e-6


class Step(NamedTuple):
    """Outcome of a search."""

    alpha: float
    reference: Matrix3
    """(3, 3), the one held where alpha is 0."""
    kept: Prediction | None
    """Prediction under that reference; None where no new one is admissible."""
    refused: Prediction | None
    """Prediction under the smallest alpha refused; None where 1 is admissible."""
    evaluations: int
    """Candidates tried."""


class GeodesicSearch:
    """Find the largest alpha for which V = exp(alpha log(R V^T)) V is admissible.

    Parameters
    ----------
    predictor : Predictor
    reference_set : ReferenceSet
        Every new reference belongs to it.
    alpha_tolerance : float
        Interval of alpha at which the bisection ends, in (0, 1).
    cut_point_shift : float
        epsilon of (15), in (0, 1).

    Raises
    ------
    ParameterError
        If a number is outside its range.
    """

    def __init__(
        self,
        predictor: Predictor,
        reference_set: ReferenceSet,
        alpha_tolerance: float,
        cut_point_shift: float,
    ) -> None:
        self._tolerance, self._shift = (
            as_real(name, value, lambda x: 0.0 < x < 1.0, "a number in (0, 1)", "leave it out")
            for name, value in (
                ("alpha_tolerance", alpha_tolerance),
                ("cut_point_shift", cut_point_shift),
            )
        )
        members = ("slow", "warm_up", "reset", "predict")
        self._predictor = require_members("predictor", predictor, members, "Predictor")
        self._set = require_kind("reference_set", reference_set, ReferenceSet)
        self._axis = np.zeros((1, 3))

    def warm_up(self) -> None:
        """Load the kernels."""
        held = read_only(np.eye(3))  # as in flight: to a kernel this is a type of its own
        self._set.contains(self.at(0.0, held, np.zeros(3)))

    def step(self, state: State, held: Matrix3, aim: Matrix3) -> Step:
        """Move the reference from ``held`` toward ``aim`` (3, 3) as far as is admissible.

        The reference of alpha = 1 is ``aim`` itself, unless that is a cut point and moved by (15).
        """
        vector = lie.log(aim @ held.T)
        angle = float(np.linalg.norm(vector))
        end = aim
        if angle > math.pi - CUT_POINT:  # (15): exp(-epsilon pi hat(N)) R
            vector *= (1.0 - self._shift) * math.pi / angle
            end = self.at(1.0, held, vector)
        found = self._try(state, end)
        if found.admissible:
            return Step(1.0, end, found, None, 1)
        least, most, evaluations = 0.0, 1.0, 1
        best, kept, refused = held, None, found
        while most - least > self._tolerance:
            alpha = least + 0.5 * (most - least)
            candidate = self.at(alpha, held, vector)
            found = self._try(state, candidate)
            evaluations += 1
            if found.admissible:
                least, best, kept = alpha, candidate, found
            else:
                most, refused = alpha, found
        return Step(least, best, kept, refused, evaluations)

    def at(self, alpha: float, start: Matrix3, vector: Array) -> Matrix3:
        """Return exp(alpha hat(vector)) start (3, 3), ``vector`` (3,) in the inertial frame."""
        self._axis[0] = vector
        reference = np.empty((3, 3))
        along(self._axis, alpha, start, reference)
        return read_only(reference)

    def obstacle(self, start: Matrix3, end: Matrix3) -> Prediction:
        """Return the zone that the geodesic between two references runs deepest into, refused."""
        vector = lie.log(end @ start.T)
        turns = [self.at(s, start, vector) for s in np.linspace(0.0, 1.0, 65)]
        margin, zone = min(self._set.margin(turn) for turn in turns)
        return self._refusal(margin, zone)

    def _try(self, state: State, candidate: Matrix3) -> Prediction:
        margin, zone = self._set.margin(candidate)
        if not margin >= self._set.steady_margin:
            return self._refusal(margin, zone)
        return self._predictor.predict(state, candidate, RESERVE)

    def _refusal(self, margin: float, zone: str) -> Prediction:
        """Return a refusal at rest, beyond every predicted step."""
        room = margin - self._set.steady_margin
        return Prediction(False, room, zone, self._predictor.horizon)
