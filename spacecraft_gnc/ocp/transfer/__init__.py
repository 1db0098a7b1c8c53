"""Attitude transfers in fixed time: energy-optimal, within bounds on torque and momentum."""

from spacecraft_gnc.ocp.transfer.certificate import shortest_possible_steps
from spacecraft_gnc.ocp.transfer.problem import AttitudeTransfer
from spacecraft_gnc.ocp.transfer.shortest import shortest_transfer
from spacecraft_gnc.ocp.transfer.solution import TransferSolution
from spacecraft_gnc.ocp.transfer.solver import TransferSolver

__all__ = [
    "AttitudeTransfer",
    "TransferSolution",
    "TransferSolver",
    "shortest_possible_steps",
    "shortest_transfer",
]
