"""``method: terminal_set``: the NMPC with a terminal set, Kalabic et al. 2014, section IV."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from spacecraft_gnc.lazy import Lazy
from spacecraft_gnc.parameters.parameter import LARGEST_WEIGHT, Kind, MatrixRule, group, parameter
from spacecraft_gnc.types import Matrix3
from spacecraft_gnc.vehicles.rigid_body.parameters.ocp import OcpParameters, OcpWeights
from spacecraft_gnc.vehicles.vehicle import Method


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class TerminalSetWeights(OcpWeights):
    """Weights of the cost with a terminal set."""

    stage_rate: Matrix3 = parameter(
        Kind.DYNAMIC,
        0.0,
        "terminal_set: stage weight on the rotation of one step, Q_2 of tr(Q_2 (I - F)) / h^2",
        unit="s^2/rad^2",
        shape=(3, 3),
        matrix=MatrixRule.SEMIDEFINITE,
        minimum=0.0,
        maximum=LARGEST_WEIGHT,
    )


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class TerminalSetParameters(OcpParameters):
    """Parameters of ``method: terminal_set``."""

    terminal_set: str = parameter(
        Kind.STRING,
        "true",
        "terminal_set: terminal constraint; without_kappa: without the torque limit of the "
        "terminal controller",
        choices=("true", "false", "without_kappa"),
    )
    stage_cost_scale: float = parameter(
        Kind.DOUBLE,
        0.1,
        "terminal_set: factor lambda of the stage cost",
        above=0.0,
        below=1.0,
    )
    weights: TerminalSetWeights = group(TerminalSetWeights)


METHOD: Final = Method(
    name="terminal_set",
    build=Lazy(f"{__name__}.controller:TerminalSetController.from_scenario"),
    parameters=TerminalSetParameters,
    refuses_starts=True,
    certifier=Lazy("spacecraft_gnc.vehicles.rigid_body.audit.plans:of_terminal_set"),
)
