"""Predictor of the nominal loop, up to the step after which no constraint can be violated.

Source: Kalabic et al. 2014, (14). Where the horizon is computed, a prediction ends in the tail set
(see `tail`); where it is given, constraints are checked over that many steps, as printed, and
whatever comes later is not seen.
"""

from __future__ import annotations

import math

import numpy as np

from spacecraft_gnc.arguments import as_count, as_limit, as_real, require_kind, require_positive
from spacecraft_gnc.arrays import as_shaped
from spacecraft_gnc.governors import _prediction_kernels as kernels
from spacecraft_gnc.governors.feedback import AttitudeFeedback
from spacecraft_gnc.governors.prediction import Prediction
from spacecraft_gnc.governors.reference_set import ReferenceSet
from spacecraft_gnc.governors.tail import Limits, Loop, Tail, horizon_of, tail_of
from spacecraft_gnc.types import Matrix3, State, read_only

# Default level of the invariant set, as a share of the lowest unstable equilibrium's.
_LEVEL = 0.98
# Share of the steady margin that a new reference leaves at least, after its reserve.
_NEARLY = 0.999
_NAMES = (
    "torque limit", "momentum limit", "momentum condition (4)", "invariant set", "convergence",
)  # fmt: skip


class FeedbackPredictor:
    """Predict the loop of `AttitudeFeedback` and a rigid body, in one compiled call.

    Parameters
    ----------
    feedback : AttitudeFeedback
    time_step : float
        Step h of the integrator [s].
    substeps : int
        Steps in one control period, over which the torque is held.
    reference_set : ReferenceSet
        Its zones are the zones of the loop.
    max_torque, max_momentum : float
        Limits on the norms of T [N m] and Pi [N m s]; 0 means none.
    level : float
        Level [J] of the invariant set W; 0: 0.98 of the lowest unstable equilibrium's.
    horizon : int
        Steps of a prediction; 0: as many as suffice (see `tail`).

    Attributes
    ----------
    tail : Tail or None
        The set in which a prediction ends; None where the horizon is given.

    Raises
    ------
    ParameterError
        If the sampled loop is not stable, a limit is negative, or the level reaches that of an
        unstable equilibrium.

    Notes
    -----
    Constraints are checked at the start of every control period.
    """

    slow = False

    def __init__(
        self,
        feedback: AttitudeFeedback,
        time_step: float,
        substeps: int,
        reference_set: ReferenceSet,
        *,
        max_torque: float = 0.0,
        max_momentum: float = 0.0,
        level: float = 0.0,
        horizon: int = 0,
    ) -> None:
        self.feedback = require_kind("feedback", feedback, AttitudeFeedback)
        self.reference_set = require_kind("reference_set", reference_set, ReferenceSet)
        time_step = require_positive("time_step", time_step)
        substeps, horizon = as_count("substeps", substeps), as_count("horizon", horizon, least=0)
        level = _as_level(level, feedback.unstable_level)
        self.loop = Loop(feedback, time_step, substeps)
        self.limits = Limits(
            _limit("max_torque", max_torque),
            _limit("max_momentum", max_momentum),
            level or _LEVEL * feedback.unstable_level,
            2.0 * float(feedback.body[27]) / time_step,
        )
        self.tail: Tail | None = None
        self.horizon = horizon
        if horizon == 0:
            self.tail = tail_of(self.loop, self.limits)
            room = _NEARLY * reference_set.steady_margin if reference_set.zones else math.inf
            least = self.tail.level_within(room)
            self.horizon = horizon_of(self.loop, self.limits, self.tail, least)
        tail = np.zeros((7, 6)) if self.tail is None else self.tail.packed()
        if self.tail is None:
            tail[6, 1] = 1.0
        self._problem = (
            *self.loop.arguments, np.array(self.limits), reference_set.rows, read_only(tail)
        )  # fmt: skip
        self._states = np.zeros((7, 3))

    def warm_up(self) -> None:
        """Load the kernel."""
        self.predict(State(0, np.eye(3), np.zeros(3)), np.eye(3))

    def reset(self) -> None:
        """Nothing is remembered."""

    def memory(self) -> tuple[()]:
        """Return nothing."""
        return ()

    def recall(self, memory: tuple[()]) -> None:
        """Nothing is remembered."""

    def predict(self, state: State, reference: Matrix3, reserve: float = 0.0) -> Prediction:
        """Predict the loop from ``state`` under a constant ``reference`` (3, 3).

        Parameters
        ----------
        state : State
        reference : (3, 3) array
            Body to inertial.
        reserve : float
            Share of each limit, and angle to each zone [rad], that has to be left.

        Returns
        -------
        Prediction
            Of a refused one, the constraint violated first, and its margin there. "convergence"
            where the tail set is not reached; the margin is then minus the angle left [rad].
        """
        states = self._states
        states[:3] = as_shaped("state.attitude", state.attitude, (3, 3))
        states[3] = as_shaped("state.momentum", state.momentum, (3,))
        states[4:] = as_shaped("reference", reference, (3, 3))
        which, step, margin = kernels.predict(*self._problem, states, self.horizon, reserve)
        if which == kernels.NOTHING:
            return Prediction(True, math.inf, "", -1)
        name = _NAMES[which] if which < kernels.FIRST_ZONE else self._zone(which)
        return Prediction(step < 0, margin, name, step)

    def _zone(self, which: int) -> str:
        return self.reference_set.names[which - kernels.FIRST_ZONE]


def _limit(name: str, value: float) -> float:
    return as_limit(name, value) or math.inf


def _as_level(level: float, unstable: float) -> float:
    return as_real(
        "lyapunov_level", level,
        lambda x: 0.0 <= x < (1.0 - 1e-9) * unstable,  # eigenvalues have rounding
        f"a number less than {unstable:.6g} [J], the level of the lowest unstable equilibrium, "
        "twice the two smallest eigenvalues of the attitude gain", "give 0 for the default",
    )  # fmt: skip
