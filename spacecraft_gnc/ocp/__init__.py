"""Optimal control problems on SO(3) and their solvers."""

from spacecraft_gnc.ocp.baselines import FsolveSolver, SlsqpSolver
from spacecraft_gnc.ocp.batch import BatchSolution
from spacecraft_gnc.ocp.continuation import (
    AutomaticContinuation,
    Continuation,
    EffortContinuation,
    HorizonContinuation,
    PenaltyContinuation,
    StateContinuation,
    cheapest,
)
from spacecraft_gnc.ocp.linearization import Linearization, linearize
from spacecraft_gnc.ocp.neighboring import NeighboringExtremal, NeighboringOptions
from spacecraft_gnc.ocp.nominal import NominalRun, fly_nominal
from spacecraft_gnc.ocp.problem import AttitudeOcp, Weights
from spacecraft_gnc.ocp.shooting import ShootingOptions, ShootingSolver
from spacecraft_gnc.ocp.solution import Solution
from spacecraft_gnc.ocp.terminal_problem import TerminalSetOcp
from spacecraft_gnc.ocp.terminal_set import TerminalSetSolver
from spacecraft_gnc.ocp.zones import PointingZone
from spacecraft_gnc.status import Status

__all__ = [
    "AttitudeOcp",
    "AutomaticContinuation",
    "BatchSolution",
    "Continuation",
    "EffortContinuation",
    "FsolveSolver",
    "HorizonContinuation",
    "Linearization",
    "NeighboringExtremal",
    "NeighboringOptions",
    "NominalRun",
    "PenaltyContinuation",
    "PointingZone",
    "ShootingOptions",
    "ShootingSolver",
    "SlsqpSolver",
    "Solution",
    "StateContinuation",
    "Status",
    "TerminalSetOcp",
    "TerminalSetSolver",
    "Weights",
    "cheapest",
    "fly_nominal",
    "linearize",
]
