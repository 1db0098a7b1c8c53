"""Time series shared by metrics and figures.

Rows k = 0..n-1 of a trajectory are its control steps; series of states have n + 1 rows, the last
one for the state after the last step. A row that a recording lost is NaN.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc import lie
from spacecraft_gnc.drawing.zones import pointing_margin_deg
from spacecraft_gnc.status import Status
from spacecraft_gnc.types import Array

if TYPE_CHECKING:
    from spacecraft_gnc.loop.flight import Flight
    from spacecraft_gnc.vehicles.rigid_body.controllers.methods import (
        ControllerParameters,
        WeightParameters,
    )
    from spacecraft_gnc.vehicles.rigid_body.parameters.zones import ZoneParameters
    from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario


def state_times(trajectory: Flight) -> Array:
    """Return (n + 1,) times of the states [s]."""
    end = trajectory.time[-1] + trajectory.period
    return np.append(trajectory.time, end)


def attitudes(trajectory: Flight) -> Array:
    """Return (n + 1, 3, 3) attitudes, body to inertial."""
    return np.concatenate([trajectory.attitude, trajectory.final_attitude[None]])


def momenta(trajectory: Flight) -> Array:
    """Return (n + 1, 3) angular momenta, body frame [N m s]."""
    return np.concatenate([trajectory.momentum, trajectory.final_momentum[None]])


def references(trajectory: Flight) -> Array:
    """Return (n + 1, 3, 3) reference attitudes, body to inertial."""
    return np.concatenate([trajectory.reference, trajectory.final_reference[None]])


def attitude_error_deg(trajectory: Flight) -> Array:
    """Return (n + 1,) angles from reference to attitude [deg]."""
    return np.degrees(lie.angles_between(references(trajectory), attitudes(trajectory)))


def is_disturbed(trajectory: Flight) -> bool:
    """Tell whether a disturbance acted, as far as it is known."""
    return bool((np.nan_to_num(trajectory.external_torque) != 0.0).any())


def is_moving(trajectory: Flight) -> bool:
    """Tell whether the reference moved by itself, with a rate of its own."""
    return bool((np.nan_to_num(trajectory.reference_rate) != 0.0).any())


def is_governed(trajectory: Flight) -> bool:
    """Tell whether a governor predicted, or held the reference back."""
    predicted = np.isfinite(trajectory.governor_margin).any()
    return bool(predicted or (trajectory.alpha < 1.0).any())


def targets(trajectory: Flight) -> Array | None:
    """Return (n + 1, 3, 3) attitudes that a governed flight was meant for, body to inertial.

    None where no governor shaped the reference, or what it was asked for is not known.
    """
    follows_plan = is_moving(trajectory) and (trajectory.plan >= 0).any()
    if not (is_governed(trajectory) or follows_plan) or not np.isfinite(trajectory.target).all():
        return None
    return np.concatenate([trajectory.target, trajectory.target[-1:]])


def settling_error_deg(trajectory: Flight) -> Array:
    """Return (n + 1,) angles [deg] by which a flight is judged.

    To the target of each step where a governor moves the reference there, else to the reference.
    """
    aims = targets(trajectory)
    if aims is None:
        return attitude_error_deg(trajectory)
    return np.degrees(lie.angles_between(aims, attitudes(trajectory)))


def torque_limit(trajectory: Flight, scenario: Scenario | None) -> float:
    """Return the limit on the norm of the torque [N m]; 0: none, or not known.

    The controller's; where it has none, that of the governor in front of it.
    """
    if scenario is None:
        return 0.0
    governors = scenario.governor.max_torque if is_governed(trajectory) else 0.0
    return scenario.controller.max_torque or governors


def torque_norm(trajectory: Flight) -> Array:
    """Return (n,) norms of the torque [N m]."""
    return np.asarray(np.linalg.norm(trajectory.torque, axis=1))


def unconverged(trajectory: Flight) -> NDArray[np.bool_]:
    """Tell of the (n,) steps whether their solve failed; at a standstill it did not."""
    status = trajectory.status
    return np.asarray((status > 0) & (status != Status.STALLED) & (status != Status.ESCAPING))


def solve_deadline(scenario: Scenario | None) -> tuple[float, str]:
    """Return the wall time that a solve may take [s], and what it is; 0 where it is not known.

    In lockstep there is no deadline; the control period takes its place.
    """
    if scenario is None:
        return 0.0, ""
    if scenario.plant.mode == "free_run":
        deadline = scenario.period / scenario.plant.real_time_factor
        return deadline, f"deadline {1e3 * deadline:.4g} ms"
    return scenario.period, f"control period {1e3 * scenario.period:.4g} ms"


def zone_margin_deg(trajectory: Flight, zone: ZoneParameters) -> Array:
    """Return (n + 1,) angles left to the border of a pointing zone, negative inside it [deg].

    For an inclusion zone the admissible side is the inside, and the margin is negative outside.
    """
    return pointing_margin_deg(attitudes(trajectory), zone)


def stage_costs(
    trajectory: Flight,
    weights: WeightParameters,
    actuators: Array | None = None,
    inertia: Array | None = None,
) -> Array:
    """Return (n,) stage costs of the control steps, with the reference in place of rest at I.

    C_k = h/2 (|Q1^(1/2) (R_k - R_ref)|_F^2 + |Q2^(1/2) hat(Pi_k - J w)|_F^2
               + |Q3^(1/2) hat(u_k - u_ref)|_F^2)

    w is the rate of the reference and J the (3, 3) ``inertia``, which a fixed reference does not
    need. u_k are the least controls that make the torque by the (3, m) matrix ``actuators``, and
    the torque itself where that is absent or empty; u_ref those of the torque of the reference.

    **Source**: Gupta et al. (2015), equation (28).
    """
    deviation = trajectory.attitude - trajectory.reference
    controls = trajectory.torque - trajectory.reference_torque
    weight, momentum = weights.stage_torque, trajectory.momentum
    if inertia is not None:
        momentum = momentum - trajectory.reference_rate @ inertia
    if actuators is not None and actuators.size:
        controls = controls @ np.linalg.pinv(actuators).T
    if controls.shape[1] == 3:
        torque_term = _hat_norm_squared(controls, weight)
    else:  # one number then: the weight of |u|^2
        torque_term = 2.0 * weight[0, 0] * np.einsum("ni,ni->n", controls, controls)
    attitude_term = _frobenius(weights.stage_attitude, deviation)
    momentum_term = _hat_norm_squared(momentum, weights.stage_momentum)
    return np.asarray(0.5 * trajectory.period * (attitude_term + momentum_term + torque_term))


def terminal_set_stage_costs(trajectory: Flight, controller: ControllerParameters) -> Array:
    """Return (n,) stage costs of ``method: terminal_set``, to the reference attitude.

    lambda L_k = lambda (tr(Q1 (I - C_k)) + tr(Q2 (I - F_k)) / h^2 + T_k . M T_k / 2)

    with C = R_ref^T R and F_k the turn of one step. tr(Q (I - A)) = |Q^(1/2) (I - A)|_F^2 / 2.

    **Source**: Kalabic et al. (2014), equations (24) and (25).
    """
    weights, eye = controller.weights, np.eye(3)
    before, after = attitudes(trajectory)[:-1], attitudes(trajectory)[1:]
    error = eye - np.swapaxes(trajectory.reference, 1, 2) @ before
    turn = eye - np.swapaxes(before, 1, 2) @ after
    cost = _frobenius(weights.stage_attitude, error)
    cost += _frobenius(weights.stage_rate, turn) / trajectory.period**2
    cost += np.einsum("ni,ij,nj->n", trajectory.torque, weights.stage_torque, trajectory.torque)
    return np.asarray(0.5 * controller.stage_cost_scale * cost)


def _frobenius(weight: Array, matrices: Array) -> Array:
    """Return |W^(1/2) A|_F^2 of (n, 3, 3) matrices."""
    return np.asarray(np.einsum("nji,jk,nki->n", matrices, weight, matrices))


def _hat_norm_squared(vectors: Array, weight: Array) -> Array:
    """Return |W^(1/2) hat(v)|_F^2 = v^T (tr(W) I - W) v for (n, 3) vectors."""
    form = np.trace(weight) * np.eye(3) - weight
    return np.asarray(np.einsum("ni,ij,nj->n", vectors, form, vectors))
