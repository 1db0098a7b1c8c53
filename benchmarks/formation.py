"""Time shift governor of a formation: time of a step, search of the passages, and campaigns.

nice python benchmarks/formation.py [--starts N] [--losses N] [--substeps M] [--plain]

Without N: the flight of config/afrl_formation.yaml, step by step, in processor time. With --starts:
N starts drawn at random around that of the figures. With --losses: one craft of the feasible ones
is lost on the way. --plain: without passages out of deadlocks.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from spacecraft_gnc.governors.time_shift import (
    NEVER,
    Answer,
    FormationFlight,
    TimeShiftGovernor,
    TimeShiftProblem,
    fly,
    fly_unshifted,
)
from spacecraft_gnc.governors.time_shift.passages import Passages
from spacecraft_gnc.governors.time_shift.prediction import Predictor
from spacecraft_gnc.plant.random_numbers import uniforms
from spacecraft_gnc.scenario import load
from spacecraft_gnc.vehicles.formation.build import initial_states
from spacecraft_gnc.vehicles.formation.governors.build import time_shift_problem

CONFIG = Path(__file__).resolve().parents[1] / "config" / "afrl_formation.yaml"
SEED = 2016
LONGEST = 700  # steps of a flight


def drawn_start(problem: TimeShiftProblem, run: int) -> np.ndarray:
    """Return the states of a run: phases 0 to 49, offsets 3 to 9 km, amplitudes 0.8 to 1.8."""
    u = uniforms(SEED, run, "formation.start", 0, 9)
    phases = np.floor(problem.samples * u[:3]).astype(int)
    states = (0.8 + u[6:])[:, None] * problem.natural[phases]
    states[:, 1] += 3000.0 + 6000.0 * u[3:6]
    return states


def drawn_loss(run: int) -> np.ndarray:
    """Return the step at which each craft of a run fails: one of them, at step 5 to 59."""
    u = uniforms(SEED, run, "formation.loss", 0, 2)
    failures = np.full(3, NEVER)
    failures[int(3.0 * u[0])] = int(5.0 + 55.0 * u[1])
    return failures


def feasible(
    governor: TimeShiftGovernor, most: int, runs: Iterator[int]
) -> Iterator[tuple[int, np.ndarray]]:
    """Yield (run, states) of the starts that have an admissible combination."""
    for run in runs:
        governor.reset()
        states = drawn_start(governor.problem, run)
        if governor.decide(0, states).answer == Answer.OPTIMAL:
            yield run, states
            most -= 1
        if most == 0:
            return


def keeps_limits(problem: TimeShiftProblem, flight: FormationFlight, failures: np.ndarray) -> bool:
    """Tell whether a flight kept every limit at its samples; no angle is asked of a lost craft."""
    first, second = np.triu_indices(problem.n_craft, 1)
    steps = np.arange(len(flight.states))[:, None]
    gone = (failures >= 0) & (steps >= failures)
    asked = ~(gone[:, first] | gone[:, second])
    return bool(
        flight.largest_delta_v <= problem.max_delta_v
        and flight.separation.min() >= problem.min_separation
        and np.where(asked, flight.angle, 0.0).max() <= problem.max_angle
    )


def tell(name: str, times: list[float]) -> None:
    """Print times in milliseconds."""
    ms = 1e3 * np.array(times)
    print(
        f"{name:30s} median {np.median(ms):6.2f} ms  p99 {np.percentile(ms, 99):6.2f} ms  "
        f"longest {ms.max():6.2f} ms"
    )


def timed(call: Callable[[], object], count: int = 200) -> list[float]:
    """Return the processor times of calls [s]."""
    times = []
    for _ in range(count):
        begun = time.process_time()
        call()
        times.append(time.process_time() - begun)
    return times


def fly_figures(problem: TimeShiftProblem, governor: TimeShiftGovernor) -> None:
    """Print figures and times of the flight of the scenario."""
    start = initial_states(load(CONFIG))
    unshifted = fly_unshifted(problem, start, 150)
    print(
        f"ungoverned: delta-v {unshifted.largest_delta_v:.4f} m/s, separation "
        f"{unshifted.separation.min():.1f} m, angle {np.degrees(unshifted.angle.max()):.1f} deg"
    )
    flight = fly(governor, start, LONGEST)
    print(
        f"governed: formed at step {flight.formed_at}, delta-v {flight.largest_delta_v:.4f} m/s, "
        f"separation {flight.separation.min():.1f} m, angle "
        f"{np.degrees(flight.angle.max()):.1f} deg, total delta-v "
        f"{np.linalg.norm(flight.delta_v, axis=2).sum():.2f} m/s"
    )
    governor.reset()
    times = []
    for k, states in enumerate(flight.states):
        begun = time.process_time()
        governor.decide(k, states)
        times.append(time.process_time() - begun)
    tell("governor step", times)
    predictor, none = Predictor(problem), np.zeros(problem.n_craft, dtype=np.bool_)
    shifts, states = np.zeros(problem.n_craft, dtype=np.int64), flight.states[10]
    tell(
        "  of it predictions and masks", timed(lambda: predictor.predict(10, states, shifts, none))
    )
    begun = time.process_time()
    passages = Passages(predictor, none)
    spent = time.process_time() - begun
    counts = Counter(passages.distances.tolist())
    print(f"passages: {spent:.2f} s; classes by transitions {dict(sorted(counts.items()))}")


def fly_starts(governor: TimeShiftGovernor, count: int) -> None:
    """Print what becomes of starts at random."""
    problem = governor.problem
    found: Counter[str] = Counter()
    steps: dict[bool, list[int]] = {False: [], True: []}
    whole = np.full(problem.n_craft, NEVER)
    for run, states in feasible(governor, count, iter(range(count))):
        flight = fly(governor, states, LONGEST)
        stuck = any(decision.deadlocked for decision in flight.decisions)
        found["feasible"] += 1
        found["deadlocked"] += stuck
        found["formed"] += flight.formed_at >= 0
        found["limits kept"] += keeps_limits(problem, flight, whole)
        if flight.formed_at >= 0:
            steps[stuck].append(flight.formed_at)
        elif not stuck:
            print(f"run {run}: neither formed nor deadlocked in {LONGEST} steps")
    print(f"of {count} starts: {dict(found)}")
    for stuck, name in ((False, "formed at once"), (True, "formed after a deadlock")):
        if steps[stuck]:
            taken = np.array(steps[stuck])
            print(f"{name}: {len(taken)}, step {np.median(taken):.0f}, latest {taken.max()}")


def fly_losses(governor: TimeShiftGovernor, count: int) -> None:
    """Print what becomes of starts at random with the loss of one craft."""
    found: Counter[str] = Counter()
    late = []
    for run, states in feasible(governor, count, iter(range(10 * count))):
        failures = drawn_loss(run)
        flight = fly(governor, states, LONGEST, failures=failures)
        answers = {decision.answer for decision in flight.decisions}
        found["flights"] += 1
        found["noticed"] += flight.decisions[-1].lost.any()
        found["formed"] += flight.formed_at >= 0
        found["limits kept"] += keeps_limits(governor.problem, flight, failures)
        found["some step without admissible shifts"] += bool(
            answers - {Answer.OPTIMAL, Answer.PASSAGE}
        )
        late.append(flight.formed_at)
    print(f"losses: {dict(found)}; formed at step {np.median(late):.0f}, latest {max(late)}")


def main() -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--starts", type=int, default=0, help="starts at random")
    parser.add_argument("--losses", type=int, default=0, help="feasible starts with a loss")
    parser.add_argument("--substeps", type=int, default=1, help="instants tested in a sample")
    parser.add_argument("--plain", action="store_true", help="without passages")
    given = parser.parse_args()
    overrides = {"reference_governor.prediction_substeps": given.substeps}
    problem = time_shift_problem(load(CONFIG, overrides))
    governor = TimeShiftGovernor(problem, resolves_deadlocks=not given.plain)
    begun = time.process_time()
    governor.warm_up()
    print(f"warm-up {time.process_time() - begun:.1f} s of processor time")
    if given.starts:
        fly_starts(governor, given.starts)
    if given.losses:
        fly_losses(governor, given.losses)
    if not (given.starts or given.losses):
        fly_figures(problem, governor)


if __name__ == "__main__":
    main()
