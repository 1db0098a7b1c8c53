"""The predicted loop of a controller is the loop that is flown."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import unit_vectors

from spacecraft_gnc import lie
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.governors.controller_loop import ControllerLoopPredictor, ShootingLoopPredictor
from spacecraft_gnc.governors.reference_set import ReferenceSet
from spacecraft_gnc.governors.settling import OneStep, settled_set
from spacecraft_gnc.loop import Command, Reference, Source, State
from spacecraft_gnc.ocp import (
    AttitudeOcp,
    NeighboringExtremal,
    PointingZone,
    ShootingSolver,
    Weights,
)
from spacecraft_gnc.scenario import load
from spacecraft_gnc.scenario.shipped import shipped
from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import (
    ShootingController,
    SolverController,
)
from spacecraft_gnc.vehicles.rigid_body.governors import predictors
from spacecraft_gnc.vehicles.rigid_body.governors.build import reference_set_of

INERTIA = np.diag([1.0, 0.8, 0.8])
BODY = RigidBody(INERTIA, 0.4)
X, Y, Z = np.eye(3)
ZERO = np.zeros(3)
EYE = np.eye(3)


def ocp_with(zones=(), **changes):
    return AttitudeOcp(INERTIA, 0.4, 5, zones=zones, **({"max_torque": 0.01} | changes))


def predictor_of(zones=(), kind=ShootingLoopPredictor, seen=True, **limits):
    """A predictor of the shooting loop; ``seen``: whether the solver knows the zones, too."""
    controller = ShootingController(ShootingSolver(ocp_with(zones if seen else ())))
    return kind(controller, BODY, 1, ReferenceSet(zones), EYE, **{"horizon": 900} | limits)


def at(rotation_vector, momentum=ZERO):
    return State(0, lie.exp(np.asarray(rotation_vector, dtype=float)), np.asarray(momentum))


def flown(controller, state, reference, n_steps):
    """Attitudes, momenta and torques of a flight under a constant reference."""
    controller.reset()
    tracked = Reference(reference, ZERO, ZERO)
    states, torques = [state], []
    for _ in range(n_steps):
        torques.append(controller.command(state, tracked).control)
        state = State(state.step + 1, *BODY.step(state.attitude, state.momentum, torques[-1]))
        states.append(state)
    return (
        np.array([s.attitude for s in states]),
        np.array([s.momentum for s in states]),
        np.array(torques),
    )


def star(angle_deg, half_angle_deg):
    """A cone for body x, in the xy plane."""
    axis = [math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg)), 0.0]
    return PointingZone("exclusion", X, axis, math.radians(half_angle_deg), 1000.0)


@pytest.fixture(scope="module")
def free():
    return predictor_of()


# --- where a loop has settled --------------------------------------------------------------


@pytest.mark.parametrize(("mass", "time"), [(1e-6, 1.0), (1e7, 1.0), (1.0, 1e4), (2.0**9, 2.0**-5)])
def test_the_settled_set_is_the_same_in_other_units(mass, time):
    torque, momentum = mass / time**2, mass / time
    sets = []
    for m, t, u, p in ((1.0, 1.0, 1.0, 1.0), (mass, time, torque, momentum)):
        weights = Weights(0.01 / t, 0.01 / t / p**2, 1.0 / t / u**2, 0.01, 0.01 / p**2)
        ocp = AttitudeOcp(m * INERTIA, 0.4 * t, 5, weights, 0.01 * u, 1e10 / t / u**4)
        step = OneStep(
            ShootingController(ShootingSolver(ocp)), RigidBody(m * INERTIA, 0.2 * t), 2, EYE
        )
        sets.append(settled_set(step, 0.01 * u, 0.02 * p))
    plain, found = sets
    units = np.repeat([1.0, momentum], 3)
    scale = np.sqrt(np.diag(plain.metric))
    metric = found.metric * np.outer(units, units) - plain.metric
    # Central differences of solves: a step of 1e-4 leaves 1e-12 or so.
    assert np.abs(metric / np.outer(scale, scale)).max() < 1e-8
    assert found.level == pytest.approx(plain.level, rel=1e-8)
    assert found.error_gain == pytest.approx(plain.error_gain, rel=1e-8)
    assert found.radius == pytest.approx(plain.radius, rel=1e-8)
    assert found.horizon == plain.horizon


@settings(max_examples=20, deadline=None)
@given(st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6).filter(any))
def test_no_flight_leaves_the_settled_set(direction):
    controller = ShootingController(ShootingSolver(ocp_with()))
    settled = settled_set(OneStep(controller, BODY, 1, EYE), max_torque=1e-4)
    x = np.array(direction)
    x *= math.sqrt(settled.level / (x @ settled.metric @ x))
    start = State(0, lie.exp(x[:3]), x[3:])
    attitudes, momenta, torques = flown(controller, start, EYE, 150)
    etas = np.array([lie.log(attitude) for attitude in attitudes])
    values = np.array([y @ settled.metric @ y for y in np.hstack([etas, momenta])])
    assert values.max() <= settled.level * (1.0 + 1e-3)
    assert values[-1] < 0.1 * settled.level
    bound = settled.error_gain * math.sqrt(settled.level)
    assert np.linalg.norm(etas, axis=1).max() <= bound * (1.0 + 1e-3)
    assert np.linalg.norm(torques, axis=1).max() <= 1e-4


def test_the_metric_is_the_sum_of_the_squared_attitude_errors_to_come(free):
    controller = ShootingController(ShootingSolver(ocp_with()))
    x = np.array([1e-3, -2e-3, 5e-4, 1e-4, 2e-4, -3e-4])
    attitudes, _, _ = flown(controller, State(0, lie.exp(x[:3]), x[3:]), EYE, 1500)
    total = sum(float(lie.log(attitude) @ lie.log(attitude)) for attitude in attitudes)
    assert math.isclose(x @ free.settled.metric @ x, total, rel_tol=1e-3)


def test_the_radius_is_that_of_the_linearised_solver(free):
    assert abs(free.settled.radius - 0.9884) < 1e-4  # PAPER_NOTES: of the loop at the target


class Torque:
    """A controller of one law and one source."""

    period, name, slow = 0.4, "torque", True

    def __init__(self, law, source=Source.OPTIMAL):
        self.law, self.source = law, source

    def warm_up(self):
        pass

    def reset(self):
        pass

    def command(self, state, reference):
        return Command(self.law(state, reference), self.source, None)


def damped(state, reference):
    return -0.2 * lie.vee(reference.attitude.T @ state.attitude) - 0.6 * state.momentum


def coasting(state, reference):
    del state, reference
    return ZERO


def kinked(state, reference):
    off = lie.vee(reference.attitude.T @ state.attitude)
    return damped(state, reference) - 0.2 * np.abs(off)


@pytest.mark.parametrize(
    ("law", "message"),
    [(coasting, r"spectral radius 1\b.*less than 1"), (kinked, "not smooth at rest")],
)
def test_a_loop_that_does_not_settle_is_refused(law, message):
    with pytest.raises(ParameterError, match=message):
        ControllerLoopPredictor(Torque(law), BODY, 1, ReferenceSet(), EYE)


# --- what is predicted is what is flown ------------------------------------------------------


@pytest.mark.parametrize("kind", [ShootingLoopPredictor, ControllerLoopPredictor])
def test_the_margin_predicted_is_that_of_the_flight(kind):
    zones = (star(-30.0, 12.0),)
    predictor = predictor_of(zones, kind)
    start = at(0.6 * Z, [0.0, 0.0, -0.01])
    found = predictor.predict(start, EYE)
    controller = ShootingController(ShootingSolver(ocp_with(zones)))
    attitudes, _, _ = flown(controller, start, EYE, 300)
    assert found.admissible
    assert found.violation_step == -1
    assert found.constraint == "zone 1"
    assert math.isclose(found.margin, zones[0].margin(attitudes).min(), abs_tol=1e-9)


@pytest.mark.parametrize("kind", [ShootingLoopPredictor, ControllerLoopPredictor])
def test_the_step_of_a_violation_is_that_of_the_flight(kind):
    zones = (star(17.0, 8.0),)
    start = at(0.8 * Z)
    found = predictor_of(zones, kind, seen=False).predict(start, EYE)
    controller = ShootingController(ShootingSolver(ocp_with()))
    attitudes, _, _ = flown(controller, start, EYE, 100)
    margins = zones[0].margin(attitudes)
    first = int(np.flatnonzero(margins < 0.0)[0])
    assert found == (False, pytest.approx(margins[first], abs=1e-9), "zone 1", first)


@settings(max_examples=15, deadline=None)
@given(unit_vectors(), st.floats(0.0, 2.5), unit_vectors(), st.floats(0.0, 0.04))
def test_compiled_and_generic_predictions_agree(axis, angle, spin, momentum):
    zones = (star(40.0, 10.0),)
    limits = {"max_momentum": 0.08, "max_torque": 0.0101}
    state = at(angle * axis, momentum * spin)
    compiled = predictor_of(zones, **limits).predict(state, EYE)
    generic = predictor_of(zones, ControllerLoopPredictor, **limits).predict(state, EYE)
    assert compiled == (
        generic.admissible,
        pytest.approx(generic.margin, abs=1e-8),
        generic.constraint,
        generic.violation_step,
    )


def test_the_limits_of_momentum_and_torque_are_seen():
    start = at(1.0 * Z)
    controller = ShootingController(ShootingSolver(ocp_with()))
    _, momenta, torques = flown(controller, start, EYE, 300)
    sizes = np.linalg.norm(momenta, axis=1)
    for limit, admissible in ((1.01 * sizes.max(), True), (0.9 * sizes.max(), False)):
        found = predictor_of(max_momentum=limit).predict(start, EYE)
        assert (found.admissible, found.constraint) == (admissible, "momentum limit")
    assert found.violation_step == int(np.flatnonzero(sizes > limit)[0])
    assert found.margin == pytest.approx(limit - sizes[found.violation_step], abs=1e-12)
    strongest = np.linalg.norm(torques, axis=1)
    found = predictor_of(max_torque=0.008).predict(start, EYE)
    assert (found.admissible, found.constraint) == (False, "torque limit")
    assert found.violation_step == int(np.flatnonzero(strongest > 0.008)[0])


def test_a_reserve_asks_for_more_than_the_limit():
    start = at(0.5 * Z)
    controller = ShootingController(ShootingSolver(ocp_with()))
    _, momenta, _ = flown(controller, start, EYE, 200)
    limit = 1.001 * float(np.linalg.norm(momenta, axis=1).max())
    predictor = predictor_of(max_momentum=limit)
    assert predictor.predict(start, EYE, 0.0).admissible
    assert predictor.predict(start, EYE, 5e-4).admissible
    assert not predictor.predict(start, EYE, 2e-3).admissible


def test_a_loop_with_a_memory_asks_for_a_reserve_of_its_own():
    start = at(0.5 * Z)
    solver = NeighboringExtremal(ocp_with())
    _, momenta, _ = flown(SolverController(solver), start, EYE, 200)
    limit = 1.0005 * float(np.linalg.norm(momenta, axis=1).max())
    predictor = ControllerLoopPredictor(
        SolverController(NeighboringExtremal(ocp_with())),
        BODY, 1, ReferenceSet(), EYE, max_momentum=limit, horizon=900,
    )  # fmt: skip
    assert predictor.predict(start, EYE).admissible
    assert not predictor.predict(start, EYE, 1e-9).admissible


# --- what else ends a prediction ---------------------------------------------------------------


@pytest.mark.parametrize("kind", [ShootingLoopPredictor, ControllerLoopPredictor])
def test_a_standstill_far_ahead_is_seen(kind):
    star_of_case_2 = PointingZone("exclusion", X, [0.9276, 0.3736, 0.0], 0.08731, 1000.0)
    controller = ShootingController(ShootingSolver(ocp_with((star_of_case_2,))))
    predictor = kind(controller, BODY, 1, ReferenceSet(), EYE, horizon=400)
    found = predictor.predict(at(0.5 * Z), EYE)
    assert (found.admissible, found.constraint) == (False, "convergence")
    assert found.violation_step == 400
    assert math.degrees(found.margin) == pytest.approx(-26.883, abs=0.01)  # where the loop parks


def test_commands_that_come_from_no_good_solve_are_refused():
    controller = Torque(damped)
    predictor = ControllerLoopPredictor(controller, BODY, 1, ReferenceSet(), EYE)
    assert predictor.predict(at(0.3 * Z), EYE).admissible
    for controller.source in Source:
        found = predictor.predict(at(0.3 * Z), EYE)
        refused = (found.admissible, found.constraint, found.violation_step) == (False, "solver", 0)
        stands_in = controller.source in (Source.SHIFTED_PLAN, Source.FEEDBACK, Source.ZERO)
        assert (refused, found.admissible) == (stands_in, not stands_in)


@pytest.mark.parametrize("kind", [ShootingLoopPredictor, ControllerLoopPredictor])
def test_a_momentum_beyond_the_integrator_is_named(kind):
    found = predictor_of(kind=kind).predict(at(0.1 * Z, [0.0, 0.0, 5.0]), EYE)
    assert (found.admissible, found.constraint) == (False, "momentum condition (4)")
    assert found.violation_step == 0
    allowed = 5.0 + found.margin
    assert BODY.is_solvable(np.array([0.0, 0.0, 0.9999 * allowed]))
    assert not BODY.is_solvable(np.array([0.0, 0.0, 1.0001 * allowed]))


def test_a_reference_without_room_is_refused():
    zones = (star(10.0, 10.0 - 0.01),)
    predictor = predictor_of(zones, seen=False)
    start = at(-1e-4 * Z)
    assert predictor.predict(start, EYE, 1e-9).admissible
    assert not predictor.predict(start, EYE, math.radians(0.011)).admissible


def test_bad_limits_and_controllers_are_refused():
    with pytest.raises(ParameterError, match=r"max_torque: received -1\.0; required a number >= 0"):
        predictor_of(max_torque=-1.0)
    with pytest.raises(ParameterError, match="without a ShootingSolver"):
        ShootingLoopPredictor(Torque(damped), BODY, 1, ReferenceSet(), EYE)


# --- the horizon -------------------------------------------------------------------------------


@pytest.mark.parametrize("changes", [{}, {"horizon": 15, "max_torque": 0.003}])
def test_the_horizon_suffices_from_rest_anywhere(changes):
    words = {f"nmpc_controller.{key}": value for key, value in changes.items()}
    scenario = load(shipped("gupta2015_case1"), words)
    predictor = predictors.predictor_of(scenario, reference_set_of(scenario))
    assert isinstance(predictor, ShootingLoopPredictor)
    rng = np.random.default_rng(4)
    for _ in range(25):
        axis = rng.normal(size=3)
        axis *= rng.uniform(0.3, math.pi - 1e-3) / np.linalg.norm(axis)
        found = predictor.predict(at(axis), EYE)
        assert found.admissible, axis


def test_where_no_half_turn_settles_smaller_turns_make_the_horizon():
    class Timid(Torque):
        slow = False

        def command(self, state, reference):
            far = lie.angle_between(state.attitude, reference.attitude) > 2.0
            source = Source.ZERO if far else Source.OPTIMAL
            return Command(np.clip(damped(state, reference), -0.01, 0.01), source, None)

    predictor = ControllerLoopPredictor(Timid(coasting), BODY, 1, ReferenceSet(), EYE)
    assert predictor.horizon > 1.2 * predictor.settled.horizon  # the torque limit decides here
    for axis in np.vstack([EYE, -EYE]):
        assert predictor.predict(at(1.5 * axis), EYE).admissible
        assert predictor.predict(at(2.5 * axis), EYE).constraint == "solver"


def test_the_horizon_of_the_scenario_is_taken_and_substeps_are_flown():
    words = {
        "reference_governor.governor": "attitude",
        "reference_governor.prediction_horizon": 432,
        "plant.time_step": 0.1,
        "nmpc_controller.method": "neighboring_extremal",
    }
    scenario = load(shipped("gupta2015_case1"), words)
    predictor = predictors.predictor_of(scenario, reference_set_of(scenario))
    assert type(predictor) is ControllerLoopPredictor
    predictor.warm_up()
    predictor.reset()
    assert predictor.horizon == 432
    assert predictor.slow
    assert predictor.predict(at(0.5 * Z), EYE).admissible
