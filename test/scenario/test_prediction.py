"""What `gnc check` predicts, against the solver's own gains and against the flight."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from strategies import inertias, weights
from typer.testing import CliRunner

from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.cli.main import app
from spacecraft_gnc.ocp import ShootingSolver, linearize
from spacecraft_gnc.scenario import Scenario, from_sections, load
from spacecraft_gnc.scenario.shipped import shipped
from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import problem_of
from spacecraft_gnc.vehicles.rigid_body.prediction import Prediction, predict

ISS = [128913292.0, -5997592.0, -1099690.0, -5997592.0, 107321738.0, 575054.0, -1099690.0, 575054.0]
ISS = [*ISS, 201433275.0]  # [kg m^2]
CUBE = [0.0022, 0.0, 0.0, 0.0, 0.0022, 0.0, 0.0, 0.0, 0.0019]
FORMER = {
    "weights.stage_attitude": 0.01,
    "weights.stage_momentum": 0.01,
    "weights.stage_torque": 1.0,
    "weights.terminal_attitude": 0.01,
    "weights.terminal_momentum": 0.01,
    "torque_penalty": 1.0e10,
}
"""What every spacecraft had by default, before that followed from it."""
STATION = {
    "plant": {
        "inertia": ISS,
        "time_step": 20.0,
        "duration": 6000.0,
        "initial_rotation_vector": [0.3, 0.2, -0.4],
    },
    "nmpc_controller": {"horizon": 10, "max_torque": 500.0},
}
HUB = {
    "plant": {
        "inertia": [900.0, 0.0, 0.0, 0.0, 800.0, 0.0, 0.0, 0.0, 600.0],
        "time_step": 1.0,
        "duration": 300.0,
        "initial_rotation_vector": [0.3827598580415697, 0.7655197160831394, -1.1482795741247092],
        "initial_momentum": [0.9, -8.0, 18.0],
    },
    "nmpc_controller": {"max_torque": 1.0},
}
CUBESAT = {
    "plant": {
        "inertia": CUBE,
        "time_step": 2.0,
        "duration": 600.0,
        "initial_rotation_vector": [0.5, 1.0, -0.4],
    },
    "nmpc_controller": {"horizon": 10, "max_torque": 1.0e-6},
}


def told(scenario: Scenario) -> Prediction:
    prediction = predict(scenario)
    assert prediction is not None
    return prediction


def flown(scenario: Scenario) -> dict[str, Any]:
    return summarize(scenario.build().run(), scenario)


@given(inertias(), st.tuples(*[weights() for _ in range(4)]), st.integers(1, 30))
@settings(max_examples=40, deadline=None)
def test_the_gains_are_those_of_the_solver(inertia: Any, full: Any, horizon: int) -> None:
    """One step at the target: by the Riccati recursion here, by a sweep of the solver there."""
    names = "stage_attitude", "stage_momentum", "terminal_attitude", "terminal_momentum"
    section = {"horizon": horizon, "time_step": 0.7, "max_torque": 0.0}
    section |= {f"weights.{n}": w.ravel() for n, w in zip(names, full, strict=True)}
    section["weights.stage_torque"] = 1.0
    scenario = from_sections({"plant": {"inertia": inertia.ravel()}, "nmpc_controller": section})
    at_rest = ShootingSolver(problem_of(scenario)).solve(np.eye(3), np.zeros(3))
    radius = np.abs(np.linalg.eigvals(linearize(at_rest).closed_loop)).max()
    assert told(scenario).spectral_radius == pytest.approx(radius, rel=1e-6)


@pytest.mark.parametrize("name", ["gupta2015_case1", "sun_moon_pd", "kalabic2014_ungoverned"])
def test_published_flights_settle_when_predicted(name: str) -> None:
    """Flown for long enough; an underdamped loop is known to half a period or so."""
    scenario = load(shipped(name), {"plant.duration": 300.0})
    assert flown(scenario)["settle_time_0.1deg"] == pytest.approx(
        told(scenario).settling_time, rel=0.15
    )


@pytest.mark.parametrize("sections", [STATION, HUB, CUBESAT], ids=["station", "hub", "cubesat"])
def test_spacecraft_of_any_size_settle_with_what_they_name(sections: Any) -> None:
    """With the former defaults the first two ended where they began, and the third flew 470 U."""
    scenario = from_sections(sections)
    metrics, expected = flown(scenario), told(scenario)
    limit = scenario.controller.max_torque
    assert metrics["final_error_deg"] < 1e-3
    assert metrics["max_torque"] <= 1.001 * limit
    assert metrics["settle_time_0.1deg"] == pytest.approx(expected.settling_time, rel=0.1)
    assert metrics["max_torque"] / limit - 1.0 <= expected.most_excess


@pytest.mark.parametrize("sections", [STATION, HUB], ids=["station", "hub"])
def test_what_would_end_where_it_began_is_told(tmp_path: Path, sections: Any) -> None:
    answer = check(tmp_path, sections, horizon=5, **FORMER)
    (warning,) = answer["warnings"]
    assert "plant.duration: received" in warning or "does not settle" in warning
    assert (answer["predicted_settling_time"] or math.inf) > answer["duration"]


def test_a_penalty_that_is_too_small_is_told_with_the_factor(tmp_path: Path) -> None:
    """The first torque is the largest of the flight, 470 times the limit."""
    answer = check(tmp_path, CUBESAT, **FORMER)
    assert answer["limit_excess"] == pytest.approx(469.3, abs=0.1)
    _, warning = answer["warnings"]
    assert "the first torque is 470.3 times max_torque 1e-06 N m" in warning
    sections = CUBESAT | {"nmpc_controller": CUBESAT["nmpc_controller"] | FORMER}
    metrics = flown(from_sections(sections))
    assert metrics["max_torque"] / 1e-6 - 1.0 == pytest.approx(answer["limit_excess"])


def test_a_horizon_of_one_step_never_settles(tmp_path: Path) -> None:
    answer = check(tmp_path, CUBESAT, horizon=1)
    assert answer["spectral_radius"] == pytest.approx(1.0, abs=1e-6)
    assert answer["predicted_settling_time"] is None
    assert "the loop does not settle at its target" in answer["warnings"][0]


def test_a_method_that_is_not_predicted_says_so(tmp_path: Path) -> None:
    answer = check(tmp_path, CUBESAT, method="terminal_set", terminal_set="false")
    assert answer["predicted_settling_time"] is None
    assert answer["warnings"] == []


def test_gains_too_fast_for_the_period_never_settle() -> None:
    fast = [4.0, 0.0, 0.0, 0.0, 4.0, 0.0, 0.0, 0.0, 4.0]
    section = {"method": "feedback", "time_step": 1.0, "feedback_momentum_gain": fast}
    scenario = from_sections({"plant": {"inertia": np.eye(3).ravel()}, "nmpc_controller": section})
    assert told(scenario).spectral_radius > 1.0
    assert math.isinf(told(scenario).settling_time)


@given(st.floats(1e-3, 1e3), st.floats(0.1, 100.0))
@settings(max_examples=25, deadline=None)
@example(1.0, 100.0)
def test_the_bound_on_the_excess_holds(penalty: float, stiffness: float) -> None:
    """It is kept by the first solve, however small the penalty and strong the saturation."""
    section = {
        "max_torque": 0.01,
        "torque_penalty": penalty * 1e6,
        "weights.stage_torque": 1.0,
        "weights.stage_attitude": stiffness,
        "horizon": 5,
        "time_step": 0.4,
    }
    scenario = from_sections(
        {
            "plant": {
                "inertia": [1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8],
                "initial_rotation_vector": [0.2, 0.3, -0.2],
            },
            "nmpc_controller": section,
        }
    )
    solver = ShootingSolver(problem_of(scenario))
    start = scenario.build_plant().state
    solution = solver.solve(start.attitude, start.momentum)
    if solution.converged:
        excess = np.linalg.norm(solution.torques[0]) / 0.01 - 1.0
        assert excess <= told(scenario).most_excess * 1.01 + 1e-12


def check(folder: Path, sections: Any, **controller: Any) -> dict[str, Any]:
    """Return what `gnc check --json` says."""
    own = sections["nmpc_controller"] | controller
    file = folder / "scenario.yaml"
    file.write_text(from_sections(sections | {"nmpc_controller": own}).to_yaml(), encoding="utf-8")
    result = CliRunner().invoke(app, ["check", str(file), "--json"])
    assert result.exit_code == 0, result.output
    answer: dict[str, Any] = json.loads(result.stdout)
    return answer
