"""Parameters of a planned transfer: its duration, its bounds, and when another plan is made."""

from __future__ import annotations

from dataclasses import dataclass

from spacecraft_gnc.parameters.parameter import LONGEST, Kind, parameter
from spacecraft_gnc.types import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class PlanParameters:
    """Group ``plan`` of whoever plans: ``method: planned`` or ``governor: planned``."""

    duration: float = parameter(
        Kind.DOUBLE,
        1.0,
        "planned: time of the transfer, from the start to rest at the target",
        unit="s",
        above=0.0,
        maximum=LONGEST,
        is_neutral=True,
    )
    torque_bounds: Array = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "planned: bounds on the components of the torque, body frame: one number or three, "
        "two-sided, or six, the lower ones before the upper ones; .inf: none there; empty: none",
        unit="N m",
        shape=(-1,),
        may_be_empty=True,
        infinite=True,
        is_neutral=True,
    )
    momentum_bounds: Array = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "planned: bounds on the components of the angular momentum, body frame, likewise",
        unit="N m s",
        shape=(-1,),
        may_be_empty=True,
        infinite=True,
        is_neutral=True,
    )
    torque_reserve: float = parameter(
        Kind.DOUBLE,
        0.0,
        "planned: share of the torque bounds that a plan leaves to the tracking",
        minimum=0.0,
        below=1.0,
        is_neutral=True,
    )
    momentum_reserve: float = parameter(
        Kind.DOUBLE,
        0.0,
        "planned: share of the momentum bounds that a plan leaves to the tracking",
        minimum=0.0,
        below=1.0,
        is_neutral=True,
    )
    starts: int = parameter(
        Kind.INTEGER,
        3,
        "planned: deterministic starts of the planner that are tried at least",
        minimum=1,
        maximum=5,
        is_neutral=True,
    )
    replan_error_deg: float = parameter(
        Kind.DOUBLE,
        2.0,
        "planned: attitude error off the plan above which another plan is made; 0: never",
        unit="deg",
        minimum=0.0,
        maximum=180.0,
        is_neutral=True,
    )
    replan_lead: int = parameter(
        Kind.INTEGER,
        5,
        "planned: steps from the request of another plan to its start; the time that it takes to "
        "find has to fit into them",
        unit="steps",
        minimum=1,
        maximum=10_000,
        is_neutral=True,
    )
    file: str = parameter(
        Kind.STRING,
        "",
        "planned: plan of `gnc plan --out` that is flown first, relative to the scenario's file, "
        "or by --set to the current folder; empty: it is found before the flight",
        is_file=True,
        is_neutral=True,
    )
