"""What a notebook shows of the objects that a user holds: one line with what matters."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.ocp import ShootingOptions, ShootingSolver, TerminalSetOcp
from spacecraft_gnc.scenario import from_sections, load
from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import problem_of

CASE1 = Path(__file__).parents[1] / "config" / "gupta2015_case1.yaml"
SCENARIO = load(CASE1, {"plant.duration": 8.0, "launcher.cut_short": True})


def test_a_scenario_says_what_would_fly() -> None:
    assert repr(SCENARIO) == (
        f"Scenario({str(CASE1)!r}: rigid_body, shooting, horizon 5, governor none, "
        "20 steps of 0.4 s, 8 s in all)"
    )
    assert "\n" not in repr(from_sections({}))


def test_a_flight_says_how_far_it_came() -> None:
    flight = SCENARIO.build().run()
    error = np.degrees(lie.angle_between(flight.final_reference, flight.final_attitude))
    text = repr(flight)
    assert text.startswith("Flight(20 steps of 0.4 s, 8 s in all, ")
    assert f" to {error:.4g} deg from the reference, largest torque 0.01 N m, 20 of 20 " in text
    assert "\n" not in text


def test_a_solver_says_what_it_solves_and_a_solution_how_it_went() -> None:
    solver = ShootingSolver(problem_of(SCENARIO), options=ShootingOptions(max_iterations=7))
    assert repr(solver) == (
        "ShootingSolver(AttitudeOcp(5 steps of 0.4 s, 3 controls, |u| <= 0.01 N m, 0 zones), "
        "exact, backward_sweep, backtracking, residual <= 1e-12 within 7 iterations)"
    )
    solution = solver.solve(lie.exp(np.array([0.1, 0.0, 0.0])), np.zeros(3))
    text = repr(solution)
    assert text.startswith(f"Solution(CONVERGED after {solution.iterations} iterations, residual ")
    assert (
        f"{solution.residual:.2g}, cost {solution.cost:.6g}, 5.73 deg from the reference, " in text
    )
    assert text.endswith(" us)")
    assert "\n" not in text


def test_a_problem_says_its_own_kind() -> None:
    ocp = TerminalSetOcp(np.diag([1.0, 0.8, 0.7]), 0.5, 3, terminal_set="false")
    assert repr(ocp) == "TerminalSetOcp(3 steps of 0.5 s, 3 controls, no torque limit, 0 zones)"
