"""Neighboring extremals: the gains, the on-line method, and the study along a nominal run."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from ocp_cases import random_problem

from spacecraft_gnc import lie
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.ocp import (
    AttitudeOcp,
    NeighboringExtremal,
    NeighboringOptions,
    PointingZone,
    ShootingOptions,
    ShootingSolver,
    Status,
    Weights,
    fly_nominal,
    linearize,
)
from spacecraft_gnc.ocp._neighboring_kernels import SEEN, error_bound

INERTIA = np.diag([1.0, 0.8, 0.8])
REST = np.zeros(3)
LIMIT = 0.01
STATES = [
    (lie.exp(np.array([0.25, 0.5, 0.5])), REST),  # saturated
    (lie.exp(np.array([0.1, -0.2, 0.05])), np.array([0.01, 0.0, -0.02])),
]


def radius(solution):
    return np.abs(np.linalg.eigvals(linearize(solution).closed_loop)).max()


@pytest.mark.parametrize("state", STATES, ids=["saturated", "free"])
def test_gains_are_the_derivative_of_the_exact_optimum(case_1, state):
    ocp, solver = case_1[0], ShootingSolver(case_1[0])
    attitude, momentum = state
    around = linearize(solver.solve(attitude, momentum))
    step, slopes = 1e-6, []
    for e in step * np.eye(6):
        ahead = solver.solve(attitude @ lie.exp(e[:3]), momentum + e[3:]).torques
        behind = solver.solve(attitude @ lie.exp(-e[:3]), momentum - e[3:]).torques
        slopes.append((ahead - behind) / (2.0 * step))
    slopes = np.array(slopes).transpose(1, 2, 0)
    carried = np.eye(6)
    for k in range(ocp.horizon):  # later torques by way of the states that the earlier ones make
        change = around.gains[k] @ carried
        # Differences: solves exact to 1e-16 over 2e-6, and step^2 times a third derivative.
        assert np.abs(change - slopes[k]).max() < 1e-9
        carried = around.transitions[k] @ carried
        carried[3:] += ocp.time_step * change


def test_one_closed_loop_step_is_linearized(case_1):
    ocp, solver = case_1[0], ShootingSolver(case_1[0])
    attitude, momentum = STATES[1]
    solution = solver.solve(attitude, momentum)
    loop, step = linearize(solution).closed_loop, 1e-6

    def one_step(e):
        R, Pi = attitude @ lie.exp(e[:3]), momentum + e[3:]
        R, Pi = ocp.body.step(R, Pi, solver.solve(R, Pi).torques[0])
        return np.concatenate([lie.log(solution.attitudes[1].T @ R), Pi])

    columns = [(one_step(e) - one_step(-e)) / (2.0 * step) for e in step * np.eye(6)]
    assert np.abs(loop - np.array(columns).T).max() < 1e-9


def test_radii_of_the_closed_loop_are_those_of_the_notes(case_1):
    solver = ShootingSolver(case_1[0])
    assert radius(solver.solve(np.eye(3), REST)) == pytest.approx(0.9884, abs=5e-5)
    antipode = lie.exp(np.array([math.pi, 0.0, 0.0]))
    assert radius(solver.solve(antipode, REST)) == pytest.approx(1.068, abs=5e-4)


def test_the_parking_place_of_case_2_is_an_unstable_equilibrium():
    zone = PointingZone("exclusion", [1, 0, 0], [0.9276, 0.3736, 0.0], math.radians(4.9965), 1e3)
    ocp = AttitudeOcp(INERTIA, 0.4, 5, Weights(), LIMIT, 1e10, (zone,))
    solver, warm = ShootingSolver(ocp), None
    R, Pi = lie.exp(np.array([0.0, 0.0, 0.5])), REST
    for _ in range(300):
        solution = solver.solve(R, Pi, None, warm)
        warm = solution.warm_start
        R, Pi = ocp.body.step(R, Pi, solution.torques[0])
    assert np.degrees(lie.angle_between(R, np.eye(3))) == pytest.approx(26.88, abs=0.01)
    assert solution.converged  # at a strict minimum of its horizon
    assert radius(solution) == pytest.approx(1.2214, abs=5e-4)


def flight(solver, ocp, n_steps, start=STATES[0][0]):
    R, Pi, warm = start, REST, None
    for _ in range(n_steps):
        solution = solver.solve(R, Pi, None, warm)
        yield R, Pi, solution
        warm = solution.warm_start
        R, Pi = ocp.body.step(R, Pi, solution.torques[0])


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4])
def test_a_whole_flight_stays_within_the_tolerance(case_1, tolerance):
    """All planned torques together, so that each of them does; test/benchmarks has many flights."""
    ocp, exact = case_1[0], ShootingSolver(case_1[0])
    online = NeighboringExtremal(ocp, NeighboringOptions(tolerance=tolerance))
    answered = 0
    for R, Pi, solution in flight(online, ocp, 375):
        assert solution.converged
        if solution.formulation != "neighboring_extremal":
            assert online.error_bound == 0.0
            continue
        answered += 1
        assert solution.iterations == 0
        assert online.error_bound <= online.largest_error == tolerance * LIMIT
        # Not the exact solver's penalty: the limit itself, but for one rounding.
        assert np.linalg.norm(solution.torques[0]) <= LIMIT * (1.0 + 4e-16)
        truth = exact.solve(R, Pi)
        cut = np.linalg.norm(truth.torques[0]) - LIMIT  # 2.7e-9 N m of it beyond the limit
        error = np.linalg.norm(truth.torques - solution.torques) - max(cut, 0.0)
        assert error <= online.error_bound + truth.residual
        assert solution.min_curvature > 0.0
    assert answered == online.corrected
    assert online.corrected + online.solved == 375
    assert online.hit_rate == answered / 375
    assert online.hit_rate > (0.85 if tolerance >= 1e-3 else 0.8)
    end = np.degrees(lie.angle_between(solution.attitudes[1], np.eye(3)))
    assert end == pytest.approx(0.2136, abs=0.002)  # PAPER_NOTES


@pytest.mark.parametrize("seed", range(12))
def test_the_bound_holds_for_random_problems(seed):
    """Full matrices, zones, with a limit and without, noise."""
    rng = np.random.default_rng(seed)
    ocp, R, Pi = random_problem(rng, 40)
    online, exact, warm = NeighboringExtremal(ocp), ShootingSolver(ocp), None
    for _ in range(60):
        R, Pi = R @ lie.exp(1e-4 * rng.normal(size=3)), Pi + 1e-5 * rng.normal(size=3)
        solution = online.solve(R, Pi, None, warm)
        if solution.formulation == "neighboring_extremal":
            truth = exact.solve(R, Pi, None, warm)
            plan = truth.torques.copy()
            plan[0] = ocp.realizable(plan[0])
            error = np.linalg.norm(plan - solution.torques)
            assert error <= online.error_bound + 10.0 * truth.residual  # weights from 0.1 on
            assert online.error_bound <= online.largest_error
        warm = solution.warm_start
        R, Pi = ocp.body.step(R, Pi, ocp.realizable(solution.torques[0]))
    assert online.corrected >= 10


@pytest.mark.parametrize("limit", [0.0, LIMIT])
def test_the_tolerance_has_no_unit(limit):
    """A body a million times as heavy flies the same with a million times the torque."""

    def hits(mass):
        weights = Weights(
            stage_momentum=np.eye(3) / mass**2, stage_torque=np.eye(3) / mass**2,
            terminal_momentum=np.eye(3) / mass**2,
        )  # fmt: skip
        penalty = 1e10 / mass**4
        ocp = AttitudeOcp(mass * INERTIA, 0.4, 8, weights, mass * limit, penalty)
        online = NeighboringExtremal(ocp)
        return [s.formulation for _, _, s in flight(online, ocp, 60)], online.largest_error / mass

    light, heavy = hits(1.0), hits(2.0**20)
    assert 0.5 < light[0].count("neighboring_extremal") / 60 < 1.0
    assert heavy[0] == light[0]
    assert heavy[1] == pytest.approx(light[1], rel=1e-4)  # of the solver's tolerance
    if limit == 0.0:  # a share of the last exact plan's largest torque, which falls with the error
        assert light[1] < 1e-3 * 0.01


@pytest.mark.parametrize(
    ("change", "contraction", "bound"),
    [(0.0, math.inf, 0.0), (1.0, 1.0, math.inf), (1.0, 2.0, math.inf), (1.0, math.nan, math.inf),
     (1.0, math.inf, math.inf), (1.0, 0.5, 4.0), (0.1, 0.1, 0.2 / 0.9), (1.0, 0.0, 2.0)],
)  # fmt: skip
def test_the_bound_is_twice_the_sum_of_the_changes_to_come(change, contraction, bound):
    assert error_bound(change, contraction) == pytest.approx(bound, rel=1e-15)


def test_a_second_correction_is_made_where_no_contraction_was_seen(case_1):
    """After an exact solve always; then only where the first one is not good enough."""
    sequence = Sequence(case_1[0])
    residuals = []
    for _ in range(4):
        sequence.step()
        residuals.append(sequence.last.residual)
    contraction, age, _ = sequence.online._rows[SEEN]
    assert age == 3
    assert 0.0 < contraction < 0.1
    assert 100.0 * residuals[1] < residuals[2] < residuals[3]


class Sequence:
    """A quiet stretch of Case I, on which neighboring extremals answer."""

    def __init__(self, ocp, **options):
        self.online = NeighboringExtremal(ocp, NeighboringOptions(tolerance=0.1, **options))
        self.R, self.Pi = lie.exp(np.array([0.02, 0.03, -0.01])), np.zeros(3)
        self.ocp = ocp

    def step(self, reference=None):
        solution = self.online.solve(self.R, self.Pi, reference)
        self.R, self.Pi = self.ocp.body.step(self.R, self.Pi, solution.torques[0])
        self.last = solution
        return solution.formulation


def test_it_solves_anew_when_it_has_become_too_old(case_1):
    sequence = Sequence(case_1[0], max_age=3)
    found = [sequence.step() == "backward_sweep" for _ in range(9)]
    assert found == [True, False, False, False] * 2 + [True]


def test_it_solves_anew_when_the_reference_changes(case_1):
    sequence = Sequence(case_1[0])
    turned = lie.exp(np.array([0.0, 0.0, 1e-6]))
    forms = [sequence.step(r) for r in (None, None, np.eye(3), turned, turned.copy(), np.eye(3))]
    assert [form == "backward_sweep" for form in forms] == [True, False, False, True, False, True]


def test_it_solves_anew_when_other_limits_act(case_1):
    ocp = case_1[0]
    online = NeighboringExtremal(ocp, NeighboringOptions(tolerance=1e3, max_age=1000))
    exact, patterns = ShootingSolver(ocp), []
    for R, Pi, solution in flight(online, ocp, 120):
        u = exact.solve(R, Pi).torques
        patterns.append(tuple(np.linalg.norm(u, axis=1) > LIMIT))
        if solution.formulation == "backward_sweep":
            continue
        assert patterns[-1] == patterns[-2]  # what it answers has the active set of the last step
    changes = sum(one != other for one, other in itertools.pairwise(patterns))
    assert changes >= 2
    assert online.solved >= 1 + changes
    assert online.corrected > 50


def test_it_solves_anew_after_a_failure_and_after_a_reset(case_1):
    sequence = Sequence(case_1[0])
    online = sequence.online
    assert [sequence.step(), sequence.step()] == ["backward_sweep", "neighboring_extremal"]
    failed = online.solve(sequence.R, np.array([0.0, 3.0, 0.0]))
    assert failed.status is Status.UNSOLVABLE_STEP
    fresh = ShootingSolver(case_1[0]).solve(sequence.R, sequence.Pi)
    after = online.solve(sequence.R, sequence.Pi)
    assert after.formulation == "backward_sweep"
    assert np.array_equal(after.torques, fresh.torques)
    assert sequence.step() == "neighboring_extremal"
    online.reset()
    assert (online.corrected, online.solved, online.hit_rate) == (0, 0, 0.0)
    assert sequence.step() == "backward_sweep"


def test_a_state_far_away_is_solved_exactly(case_1):
    sequence = Sequence(case_1[0])
    sequence.step()
    far = lie.exp(np.array([1.0, -0.5, 0.3]))
    solution = sequence.online.solve(far, REST)
    assert solution.formulation == "backward_sweep"
    assert np.array_equal(solution.torques, ShootingSolver(case_1[0]).solve(far, REST).torques)


def test_a_state_that_is_none_is_refused_as_by_the_solver(case_1):
    sequence = Sequence(case_1[0])
    sequence.step()
    for attitude, momentum in ((np.full((3, 3), np.nan), REST), (np.eye(3), np.full(3, np.inf))):
        with pytest.raises(ParameterError, match=r"attitude|momentum"):
            sequence.online.solve(attitude, momentum)
    # The sequence goes on: what was refused has left nothing behind.
    R, Pi = sequence.R, sequence.Pi
    solution = sequence.online.solve(R, Pi)
    exact = ShootingSolver(case_1[0]).solve(R, Pi)
    assert np.abs(solution.torques - exact.torques).max() < 0.1 * LIMIT


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda _: NeighboringOptions(tolerance=0.0), "tolerance"),
        (lambda _: NeighboringOptions(max_age=0), "max_age"),
        (
            lambda ocp: NeighboringExtremal(
                ocp, options=ShootingOptions(formulation="single_shooting")
            ),
            "formulation.*backward sweep",
        ),
        (lambda ocp: fly_nominal(ShootingSolver(ocp), np.eye(3), [0.0, 3.0, 0.0], 5), "step 0"),
    ],
)
def test_what_cannot_be_is_refused(case_1, make, words):
    with pytest.raises(ParameterError, match=words):
        make(case_1[0])


@pytest.fixture(scope="module")
def nominal(case_1):
    return fly_nominal(ShootingSolver(case_1[0]), *case_1[1:], 375)


@pytest.mark.parametrize("clipped", [False, True], ids=["raw", "clipped"])
@pytest.mark.parametrize(
    ("second", "raw", "cut"),
    [  # largest and last error [deg] of PAPER_NOTES, one unit of its last place more
        ([math.radians(5), 0, 0], (0.21, 0.005), (0.08, 0.002)),
        ([math.radians(10), 0, 0], (0.89, 0.017), (0.29, 0.005)),
        (np.radians(10) * np.ones(3) / math.sqrt(3), (2.71, 0.034), (0.26, 0.004)),
    ],
    ids=["x5", "x10", "111"],
)
def test_the_study_along_a_nominal_run(case_1, nominal, second, raw, cut, clipped):
    ocp, attitude, _ = case_1
    assert len(nominal) == 375
    R, Pi = attitude @ lie.exp(np.array(second)), REST
    errors, largest = [], 0.0
    for k, (exact, _, _) in enumerate(flight(ShootingSolver(ocp), ocp, 375, R)):
        errors.append(np.degrees(lie.angle_between(R, exact)))
        torque = nominal.torque(k, R, Pi)
        torque = ocp.realizable(torque) if clipped else torque
        largest = max(largest, np.linalg.norm(torque))
        R, Pi = ocp.body.step(R, Pi, torque)
    bound = cut if clipped else raw
    assert 0.5 * bound[0] < max(errors) < bound[0]
    assert errors[-1] < bound[1]
    # Raw, a neighboring extremal does not know the limit.
    assert largest <= LIMIT * (1.0 + 4e-16) if clipped else largest > 1.03 * LIMIT
