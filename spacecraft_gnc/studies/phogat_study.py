"""What is solved of Phogat et al.: the transfer of figure 4, and cases over the paper's range."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.ocp.transfer import (
    AttitudeTransfer,
    TransferSolution,
    TransferSolver,
    shortest_possible_steps,
    shortest_transfer,
)
from spacecraft_gnc.studies.options import Options
from spacecraft_gnc.studies.phogat_compare import Compared, Comparison
from spacecraft_gnc.studies.phogat_speed import Length, time_lengths
from spacecraft_gnc.studies.phogat_transfers import figure_4, paper_transfer, random_transfer
from spacecraft_gnc.types import Array

AXES: Final = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1), "(1, 1, 1)": (1, 1, 1)}
ANGLES: Final = (10, 30, 60, 90)  # [deg]
TIMES: Final = (5, 10, 15, 20, 30)  # [s]
RANDOM: Final = 40
"""Random transfers, with the paper's time step."""


class Case(NamedTuple):
    """A transfer, ours and IPOPT's; None where IPOPT is left out."""

    plan: TransferSolution
    compared: Compared | None


class Shortest(NamedTuple):
    """Time that a turn takes at least: the shortest plan, and what is proven [s]."""

    plan: TransferSolution
    proven: float


@dataclass(frozen=True, slots=True)
class Study:
    """All that was solved."""

    figure_4: TransferSolution
    algorithm_2: TransferSolution
    """Figure 4 by Algorithm 2 alone, as the paper has it."""
    cases: dict[tuple[str, int, int], Case]
    """By axis, angle [deg] and time [s]."""
    shortest: dict[tuple[str, int], Shortest]
    random: tuple[Case, ...]
    lengths: tuple[Length, ...]

    @property
    def compared(self) -> tuple[Compared, ...]:
        """Cases and random transfers that were solved by IPOPT too."""
        every = [*self.cases.values(), *self.random]
        return tuple(case.compared for case in every if case.compared is not None)


def study_all(options: Options) -> Study:
    """Solve everything."""
    comparison = Comparison() if options.baselines else None
    solver, done = TransferSolver(), 0
    wanted = [(axis, angle, time) for axis in AXES for angle in ANGLES for time in TIMES]
    total = len(wanted) + RANDOM

    def case_of(problem: AttitudeTransfer) -> Case:
        nonlocal done
        options.progress("transfers", done, total)
        done += 1
        compared = None if comparison is None else comparison.of(problem)
        return Case(solver.solve(problem) if compared is None else compared.plan, compared)

    cases = {
        (axis, angle, time): case_of(paper_transfer(angle, AXES[axis], time))
        for axis, angle, time in wanted
    }
    return Study(
        figure_4=solver.solve(figure_4()),
        algorithm_2=TransferSolver(starts=1, homotopy=False).solve(figure_4()),
        cases=cases,
        shortest={(axis, angle): _shortest(axis, angle) for axis in AXES for angle in ANGLES},
        random=tuple(case_of(random_transfer(index)) for index in range(RANDOM)),
        lengths=time_lengths(),
    )


def _shortest(axis: str, angle: int) -> Shortest:
    problem = paper_transfer(angle, AXES[axis], TIMES[-1])
    proven = shortest_possible_steps(problem) * problem.body.time_step
    return Shortest(shortest_transfer(problem), proven)


def saturated_as_co_states_say(plan: TransferSolution) -> bool:
    """Whether exactly the torques saturate whose co-state exceeds the bound (paper, section 6)."""
    return bool(
        np.array_equal(np.abs(plan.co_momentum) > plan.problem.limits[1], plan.active_torque != 0)
    )


def kept(plan: TransferSolution, axis: int) -> NDArray[np.intp]:
    """Return the steps over which a component of the momentum stays at its bound."""
    at = plan.active_momentum[:, axis]
    return np.flatnonzero((at[:-1] != 0) & (at[1:] != 0))


def holding_torque(plan: TransferSolution) -> Array:
    """Return (N, 3) torques that would keep each component of the momentum over a step [N m].

    They balance the gyroscopic torque: (Pi_k - F_k^T Pi_k) / h.
    """
    attitude, h = plan.attitude, plan.problem.body.time_step
    turned = np.einsum("kji,kjl,kl->ki", attitude[1:], attitude[:-1], plan.momentum[:-1])
    return np.asarray((plan.momentum[:-1] - turned) / h)


def attitude_co_state(plan: TransferSolution) -> Array:
    """Return (N, 3) zeta_k, the constant co-state of the attitude in the frame of step k."""
    first, later = plan.attitude[1], plan.attitude[1:]
    return np.asarray(np.einsum("kji,jl,l->ki", later, first, plan.zeta))


def time_of_full_torque(degrees: float, moment: float, torque: float) -> float:
    """Return the time of a turn about a principal axis at full torque, there and back [s]."""
    return 2.0 * math.sqrt(math.radians(degrees) * moment / torque)
