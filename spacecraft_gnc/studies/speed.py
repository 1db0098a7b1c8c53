"""Speed of the cores on this machine.

Wall times of `time.perf_counter`, in one process and one thread, after a warm-up. Machines are
shared and noisy: the median is the figure to quote.
"""

from __future__ import annotations

import os
import platform
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.governors.feedback_loop import FeedbackPredictor
from spacecraft_gnc.governors.prediction import Prediction
from spacecraft_gnc.governors.search import GeodesicSearch
from spacecraft_gnc.loop import ClosedLoop
from spacecraft_gnc.ocp import ShootingSolver
from spacecraft_gnc.types import Array, Matrix3, State
from spacecraft_gnc.vehicles.rigid_body.controllers.feedback.controller import FeedbackController
from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import problem_of
from spacecraft_gnc.vehicles.rigid_body.governors.build import reference_set_of
from spacecraft_gnc.vehicles.rigid_body.governors.predictors import feedback_predictor

if TYPE_CHECKING:
    from spacecraft_gnc.scenario import Scenario

_MARCH = 200_000  # integrator steps in one timed call
_PREDICTED = 100  # steps of each prediction of a governor's update


def machine() -> dict[str, Any]:
    """Return what the figures depend on: processor, cores, system, Python and libraries."""
    model = platform.processor() or platform.machine()
    information = Path("/proc/cpuinfo")
    if information.is_file():
        lines = information.read_text(encoding="utf-8").splitlines()
        model = next((line.split(":")[1].strip() for line in lines if "model name" in line), model)
    return {
        "processor": model,
        "cores": os.cpu_count(),
        "load": os.getloadavg()[0],
        "system": f"{platform.system()} {platform.release()}",
        "python": platform.python_version(),
        "numpy": np.__version__,
    }


def machine_line() -> str:
    """Return `machine` in one line."""
    m = machine()
    return (
        f"{m['processor']}, {m['cores']} cores (load {m['load']:.1f}), {m['system']}, "
        f"Python {m['python']}, numpy {m['numpy']}"
    )


def quantiles(seconds: Array) -> dict[str, float | int]:
    """Return median, 99 % quantile, largest value and number of samples."""
    return {
        "median": float(np.median(seconds)),
        "p99": float(np.quantile(seconds, 0.99)),
        "max": float(np.max(seconds)),
        "samples": len(seconds),
    }


def time_calls(call: Callable[[], object], repeats: int) -> Array:
    """Return the wall time [s] of each of ``repeats`` calls."""
    call()
    times = np.empty(repeats)
    for i in range(repeats):
        begun = perf_counter()
        call()
        times[i] = perf_counter() - begun
    return times


def time_integrator(inertia: Array, time_step: float, repeats: int = 20) -> dict[str, Any]:
    """Time one LGVI step: inside the kernel, and as a call from Python."""
    body = RigidBody(inertia, time_step)
    torque = np.array([0.001, -0.002, 0.001])
    attitude, momentum, zero = np.eye(3), np.array([0.02, -0.03, 0.05]), np.zeros(3)
    march = time_calls(lambda: body.step(attitude, momentum, zero, _MARCH), repeats) / _MARCH
    single = time_calls(lambda: body.step(attitude, momentum, torque), 200 * repeats)
    return {"kernel": quantiles(march), "call": quantiles(single)}


def time_solves(scenario: Scenario, repeats: int = 20) -> dict[str, Any]:
    """Time the warm solves of a scenario's flight: in the kernel, and as calls from Python.

    ``kernel``: one call for them all, of which each repeat gives the mean. Every solve starts from
    the multipliers that it had in the flight.
    """
    ocp, plant = problem_of(scenario), scenario.build_plant()
    solver, warm = ShootingSolver(ocp), np.zeros((ocp.horizon, 6))
    state, states, starts = plant.state, [], []
    for _ in range(plant.n_steps):
        solution = solver.solve(state.attitude, state.momentum, warm_start=warm)
        states.append(state)
        starts.append(warm)
        warm = solution.multipliers[1:]
        state = plant.step(solution.torques[0])
    states, guesses = states[1:], np.array(starts[1:])
    attitudes = np.array([s.attitude for s in states])
    momenta = np.array([s.momentum for s in states])
    together, calls = [], []
    for _ in range(repeats + 1):
        batch = solver.solve_batch(attitudes, momenta, warm_starts=guesses)
        together.append(batch.solve_time / len(states))
        for state, warm in zip(states, guesses, strict=True):
            begun = perf_counter()
            solver.solve(state.attitude, state.momentum, warm_start=warm)
            calls.append(perf_counter() - begun)
    return {
        "kernel": quantiles(np.array(together[1:])),
        "call": quantiles(np.array(calls[len(states) :])),
    }


def time_flight(loop: ClosedLoop, repeats: int = 20) -> dict[str, Any]:
    """Time whole flights of a closed loop, and every solve in them but the first (cold) ones.

    ``step``: of a flight's time, the share of one control step.
    """
    flight = loop.run()
    flights, solves = np.empty(repeats), []
    for i in range(repeats):
        begun = perf_counter()
        flight = loop.run()
        flights[i] = perf_counter() - begun
        solves.append(flight.solve_time[1:])
    steps = len(flight.time)
    return {
        "flight": quantiles(flights),
        "step": quantiles(flights / steps),
        "solve": quantiles(np.concatenate(solves)),
    }


def time_governor(scenario: Scenario, repeats: int = 2000) -> dict[str, Any]:
    """Time the update of a scenario's reference governor.

    ``update``: the longest there is, all halvings of the bisection with every prediction flown
    over 100 steps to its end; ``flight``: those of the scenario's flight that had to bisect.
    """
    references, law = (
        reference_set_of(scenario),
        FeedbackController.from_scenario(scenario).feedback,
    )
    ahead = feedback_predictor(scenario, law, references, horizon=_PREDICTED)
    g, p = scenario.governor, scenario.plant
    search = GeodesicSearch(_Refusing(ahead), references, g.alpha_tolerance, g.cut_point_shift)
    start = State(0, lie.exp(p.initial_rotation_vector), np.zeros(3))
    near = start.attitude @ lie.exp(np.array([0.01, 0.0, 0.0]))  # nothing is violated on the way
    update = time_calls(lambda: search.step(start, start.attitude, near), repeats)
    return {"update": quantiles(update), "flight": quantiles(_time_bisections(scenario))}


class _Refusing:
    """Flies every prediction to its end and then refuses it, so that a bisection runs to its."""

    slow = False

    def __init__(self, predictor: FeedbackPredictor) -> None:
        self.horizon = predictor.horizon
        self._predictor = predictor

    def warm_up(self) -> None:
        self._predictor.warm_up()

    def reset(self) -> None:
        self._predictor.reset()

    def predict(self, state: State, reference: Matrix3, reserve: float = 0.0) -> Prediction:
        found = self._predictor.predict(state, reference, reserve)
        assert found.admissible  # noqa: S101 - else it was not flown to its end
        return found._replace(admissible=False)


def _time_bisections(scenario: Scenario) -> Array:
    loop = scenario.build()
    for core in (loop.plant, loop.controller, loop.governor):
        core.warm_up()
        core.reset()
    times, state = [], loop.plant.state
    for _ in range(loop.plant.n_steps):
        begun = perf_counter()
        decision = loop.governor.decide(state)
        spent = perf_counter() - begun
        if decision.evaluations > 1:
            times.append(spent)
        state = loop.plant.step(loop.controller.command(state, decision.reference).control)
    return np.array(times)
