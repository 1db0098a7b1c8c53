"""Audit of the motion: integrated again under the recorded torques.

What drives the body is the torque that the plant applied and, where the scenario lists
disturbances, the sum of theirs, which the plant told as well.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.audit.evidence import Evidence
from spacecraft_gnc.audit.ledger import Ledger, as_absolute
from spacecraft_gnc.errors import GncError
from spacecraft_gnc.plant.disturbances.registry import not_installed
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.audit import _audit_kernels as kernels
from spacecraft_gnc.vehicles.rigid_body.audit.torques import given
from spacecraft_gnc.vehicles.rigid_body.plant import RigidBodyPlant
from spacecraft_gnc.vehicles.rigid_body.signals import INVARIANTS, STATE, TORQUE

if TYPE_CHECKING:
    from spacecraft_gnc.audit.evidence import Progress


ROUNDING: Final = 64.0 * 2.0**-53
"""Share of the largest magnitude that the sums of three products may be off."""
_ATTITUDE, _MOMENTUM = "attitude_state.attitude", "attitude_state.angular_momentum"
_ORIENTATION, _RATE = "attitude_state.orientation", "attitude_state.angular_velocity"
_ENERGY, _INERTIAL = "plant_invariants.kinetic_energy", "plant_invariants.inertial_momentum"
_DEFECT = "plant_invariants.orthogonality_error"
_EXTERNAL = "plant_invariants.external_torque"
_DISTURBED: Final = "external torque = sum of the disturbances"


class _Flyer(NamedTuple):
    """What flies the scenario again."""

    plant: Any
    """`Plant`; that of the rigid body tells ``external_torque``, too."""
    torques: Array
    """(n, 3) to step it by [N m]; NaN: not known."""
    driving: Array
    """(n, 3) torque that drives the integrator [N m], disturbances included."""
    has_disturbances: bool
    """Whether the plant has those of the scenario, if any, and tells their sum."""


def audit_motion(
    evidence: Evidence, ledger: Ledger, tolerance: float | None, progress: Progress | None
) -> None:
    """Integrate the flight again by the plant's own code: from each state, and from the start."""
    flyer = _flyer(evidence, ledger)
    _each_step(evidence, flyer.plant, flyer.driving, ledger, tolerance)
    _in_a_row(evidence, flyer, ledger, tolerance, progress)
    _momentum_balance(evidence, flyer.plant, flyer.driving, ledger)


def _flyer(evidence: Evidence, ledger: Ledger) -> _Flyer:
    """Return what flies again; where a disturbance is not installed, by the recorded sum."""
    scenario, applied = evidence.scenario, applied_torques(evidence)
    driving = applied
    if scenario.plant.disturbances:
        steps = np.arange(evidence.n)
        driving = applied + evidence.rows(INVARIANTS, "external_torque", steps + 1)
    absent = not_installed(scenario.plant)
    if absent:
        why = f"not installed: {', '.join(absent)}; the recorded sum is integrated"
        ledger.skip(_DISTURBED, why)
        plant = RigidBodyPlant.from_scenario(scenario, is_disturbed=False)
        return _Flyer(plant, driving, driving, has_disturbances=False)
    found = scenario.build_plant()
    tells = hasattr(found, "external_torque")
    ledger.check(_DISTURBED, "", "" if tells else "a plug-in's plant does not tell it")
    return _Flyer(found, applied, driving, has_disturbances=tells)


def warm_up(plant: RigidBodyPlant) -> None:
    """Compile or load the kernel."""
    still = (
        np.eye(3)[None],
        np.zeros((1, 3)),
        np.zeros((1, 3)),
        np.empty((1, 3, 3)),
        np.empty((1, 3)),
    )
    kernels.resume(plant.body.packed, plant.body.time_step, plant.substeps, *still)


def applied_torques(evidence: Evidence) -> Array:
    """Return (n, 3) torques [N m] of the steps, as the plant told, else as commanded within limits.

    NaN: neither is known.
    """
    steps = np.arange(evidence.n)
    commanded = np.full((evidence.n, 3), np.nan)
    if evidence.columns[TORQUE].steps.size:
        commanded = given(evidence.scenario.plant, evidence.rows(TORQUE, "torque", steps))
    if not evidence.columns[INVARIANTS].steps.size:
        return commanded
    applied = evidence.rows(INVARIANTS, "applied_torque", steps + 1)
    return np.where(np.isnan(applied), commanded, applied)


def _each_step(
    evidence: Evidence,
    plant: RigidBodyPlant,
    torques: Array,
    ledger: Ledger,
    tolerance: float | None,
) -> None:
    name = "integrator, from each state"
    if type(plant) is not RigidBodyPlant:
        ledger.skip(name, f"plant.vehicle {evidence.scenario.plant.vehicle} is a plug-in's")
        return
    states = evidence.columns[STATE]
    before = np.flatnonzero(np.diff(states.steps) == 1)
    before = before[states.steps[before] < evidence.n]
    before = before[np.isfinite(torques[states.steps[before]]).all(axis=1)]
    attitudes = states.fields["attitude"].reshape(-1, 3, 3)
    momenta = states.fields["angular_momentum"]
    m = before.size
    found = np.empty((m, 3, 3)), np.empty((m, 3))
    body, k = plant.body, states.steps[before]
    done = kernels.resume(
        body.packed, body.time_step, plant.substeps, attitudes[before], momenta[before],
        np.ascontiguousarray(torques[k]), *found,
    )  # fmt: skip
    if done < m:
        ledger.fail(name, "the step exists", int(k[done]), _MOMENTUM)
        m = done
    after = before[:m] + 1
    for where, recorded, again in (
        (_ATTITUDE, states.fields["attitude"], found[0].reshape(-1, 9)),
        (_MOMENTUM, momenta, found[1]),
    ):
        limit = as_absolute(tolerance, recorded)
        steps = states.steps[after]
        ledger.compare(name, steps, {where: recorded[after]}, {where: again[:m]}, limit)


def _in_a_row(
    evidence: Evidence,
    flyer: _Flyer,
    ledger: Ledger,
    tolerance: float | None,
    progress: Progress | None,
) -> None:
    """Fly the vehicle by the recorded torques from the scenario's start, as far as they go."""
    again = _flown_again(evidence, flyer, ledger, progress)
    flown = len(again[_MOMENTUM])
    for topic, names in (
        (_DISTURBED, (_EXTERNAL,)),
        ("integrator, from the start", (_ATTITUDE, _MOMENTUM)),
        ("quaternion = rotation matrix", (_ORIENTATION,)),
        ("rate = J^-1 momentum", (_RATE,)),
        ("energy and momentum told", (_ENERGY, _INERTIAL, _DEFECT)),
    ):
        source = INVARIANTS if names[0] in (_ENERGY, _EXTERNAL) else STATE
        steps = evidence.columns[source].steps
        steps = steps[steps < flown]
        if not steps.size:
            ledger.skip(topic, f"{source} was not recorded")
            continue
        for where in names if flyer.has_disturbances or topic != _DISTURBED else ():
            recorded = evidence.rows(source, where.partition(".")[2], steps)
            limit = as_absolute(tolerance, recorded)
            ledger.compare(topic, steps, {where: recorded}, {where: again[where][steps]}, limit)


def _flown_again(
    evidence: Evidence, flyer: _Flyer, ledger: Ledger, progress: Progress | None
) -> dict[str, Array]:
    """Return what the plant tells of each state it comes through."""
    n, plant, torques = evidence.n, flyer.plant, flyer.torques
    room = {name: np.empty((n + 1, size)) for name, size in _SIZES.items()}
    plant.reset()
    for k in range(n + 1):
        state, invariants = plant.state, plant.invariants()
        room[_ATTITUDE][k] = state.attitude.ravel()
        room[_MOMENTUM][k] = state.momentum
        room[_ORIENTATION][k] = lie.to_quaternion_xyzw(state.attitude)
        room[_RATE][k] = plant.angular_velocity()
        room[_ENERGY][k], room[_INERTIAL][k], room[_DEFECT][k] = invariants
        if flyer.has_disturbances:
            room[_EXTERNAL][k] = plant.external_torque
        if progress is not None and k % 1000 == 0:
            progress(k, n)
        if k == n or not np.isfinite(torques[k]).all():
            break
        try:
            plant.step(torques[k])
        except GncError:
            ledger.fail("integrator, from the start", "the step exists", k, _MOMENTUM)
            break
    return {name: values[: k + 1] for name, values in room.items()}


_SIZES: Final = {
    _ATTITUDE: 9,
    _MOMENTUM: 3,
    _ORIENTATION: 4,
    _RATE: 3,
    _ENERGY: 1,
    _INERTIAL: 3,
    _DEFECT: 1,
    _EXTERNAL: 3,
}


def _momentum_balance(
    evidence: Evidence, plant: RigidBodyPlant, torques: Array, ledger: Ledger
) -> None:
    """R' Pi' - R Pi = h R' u: a law of the integrator that no quantity of its own enters."""
    name = "inertial momentum = torque impulse"
    if type(plant) is not RigidBodyPlant or plant.substeps != 1:
        ledger.skip(name, "the control period has several integrator steps, or another vehicle's")
        return
    states = evidence.columns[STATE]
    at = np.flatnonzero(np.diff(states.steps) == 1)
    at = at[states.steps[at] < evidence.n]
    attitudes = states.fields["attitude"].reshape(-1, 3, 3)
    inertial = np.einsum("kij,kj->ki", attitudes, states.fields["angular_momentum"])
    u = torques[states.steps[at]]
    impulse = plant.period * np.einsum("kij,kj->ki", attitudes[at + 1], u)
    off = inertial[at + 1] - inertial[at] - impulse
    scale = float(np.abs(inertial).max() + np.abs(impulse).max(initial=0.0))
    limit = ROUNDING * max(scale, 1e-300)
    ledger.bound(name, states.steps[at] + 1, _MOMENTUM, off, limit, "N m s")
