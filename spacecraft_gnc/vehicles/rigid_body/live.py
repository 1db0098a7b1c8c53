"""Live view of a rigid body: values, charts and readouts."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, Final

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.drawing.live import (
    Panel,
    Readout,
    Series,
    attitude_readouts,
    attitude_values,
    duration,
    error_panel,
    magnitude,
    number,
    small,
    source_panel,
    source_readout,
)
from spacecraft_gnc.drawing.sources import source_name
from spacecraft_gnc.drawing.zones import pointing_margin_deg
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.status import Status
from spacecraft_gnc.vehicles.rigid_body.planner import live as live_plan
from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario

_METHOD: Final = source_name(Source.METHOD)
_NO_SOLVE: Final = "no solve"


def status_name(status: int) -> str:
    """Return a solver status in words; it is a constant of SolverStatus."""
    return Status(status).text if 0 <= status < len(Status) else _NO_SOLVE


class RigidBodyLive:
    """Implements `drawing.live.VehicleLive`."""

    fields: Final = {
        **live_plan.FIELDS,
        "curvature": "solver_status/min_curvature",
        "admissible": "governor_status/admissible",
        "constraint": "governor_status/active_constraint",
    }
    history: Final = (
        "error_deg", "target_error_deg", "momentum", "torque", "source", *live_plan.HISTORY,
    )  # fmt: skip

    def constants(self, scenario: Scenario | None) -> dict[str, Any]:
        """Return ``torque_limit`` [N m] (0: none), ``target`` (3, 3), ``zones`` and ``bounds``.

        ``target`` is None where the reference moves by itself, ``bounds`` (4, 3) of a plan where
        none is flown.
        """
        if scenario is None:
            return {"torque_limit": 0.0, "target": None, "zones": (), "bounds": None}
        governor, controller = scenario.governor, scenario.controller
        governed = scenario.law.looks_ahead
        return {
            "torque_limit": controller.max_torque or (governor.max_torque if governed else 0.0),
            "target": None if scenario.law.moves else lie.exp(governor.target_rotation_vector),
            "zones": controller.zones,
            "bounds": live_plan.real_bounds(scenario),
        }

    def panels(self, scenario: Scenario | None) -> list[Panel]:
        """Return the charts."""
        governed = scenario is not None and scenario.governor.governor != "none"
        constants = self.constants(scenario)
        bounds = constants["bounds"]
        torque = {"norm": "|u|", "limit": constants["torque_limit"]}
        if bounds is not None:
            torque = {"limit": live_plan.common(bounds[:2])}
        return [
            Panel(
                kind="bars", name="torque", title="Torque, body frame", unit="N m",
                series=[Series("torque", "xyz")], **torque,
            ),
            error_panel(governed),
            Panel(
                kind="strip", name="momentum", title="Angular momentum", unit="N m s",
                series=[Series("momentum", "xyz")],
                limit=0.0 if bounds is None else live_plan.common(bounds[2:]),
            ),
            *([] if bounds is None else live_plan.panels(bounds)),
            source_panel("Torque"),
        ]  # fmt: skip

    def values(self, row: Mapping[str, Any], constants: Mapping[str, Any]) -> dict[str, Any]:
        """Return what is shown of a step."""
        turned = attitude_values(row, constants)
        source = row.get("source")
        return {
            **turned,
            "momentum": row.get("momentum"),
            "torque": row.get("torque"),
            "external_torque": row.get("external_torque"),
            "source": source_name(-1 if source is None else int(source), "unknown"),
            "margins_deg": _margins_deg(turned["attitude"], constants["zones"]),
            "solve": _solve(row),
            "decision": _decision(row),
            **live_plan.values(row, constants),
        }

    def readouts(self, values: Mapping[str, Any], governed: bool) -> dict[str, list[Readout]]:
        """Return the lines beside the picture."""
        solves = values["source"] != _METHOD
        return {
            "state": [*attitude_readouts(values, governed), *_state(values)],
            "solver": list(_solver(values["solve"])) if solves and values["solve"] else [],
            "governor": list(_governor(values["decision"]))
            if governed and values["decision"]
            else [],
            "plan": list(live_plan.readouts(values)),
        }

    def line(self, values: Mapping[str, Any]) -> list[str]:
        """Return a few words about a step."""
        parts = []
        if math.isfinite(values["error_deg"]):
            parts.append(f"{values['error_deg']:.4g} deg off the reference")
        if values["torque"] is not None:
            norm = float(np.linalg.norm(values["torque"]))
            parts.append(f"|u| {norm:.4g} N m ({values['source']})")
        if values["solve"] is not None:
            parts.append(f"{values['solve']['status']}, {values['solve']['iterations']} iterations")
        if values["decision"] is not None:
            parts.append(f"alpha {values['decision']['alpha']:.3g}")
        return [*parts, *live_plan.line(values)]


LIVE: Final = RigidBodyLive()


def _margins_deg(attitude: Any, zones: Any) -> dict[str, float]:
    """Return the angles left to the pointing zones [deg] by name."""
    if attitude is None:
        return {}
    return {zone.name: float(pointing_margin_deg(attitude[None], zone)[0]) for zone in zones}


def _solve(row: Mapping[str, Any]) -> dict[str, Any] | None:
    """Return what the solver told of a step; NaN where it did not, None without it."""
    if row.get("status") is None:
        return None
    numbers = ("residual", "cost", "curvature", "solve_time")
    return {
        "status": status_name(int(row["status"])),
        "iterations": int(row["iterations"]),
        **{name: float(row.get(name, math.nan)) for name in numbers},
    }


def _decision(row: Mapping[str, Any]) -> dict[str, Any] | None:
    """Return what the governor told of a step; None where it did not."""
    alpha = row.get("alpha")
    if alpha is None or math.isnan(alpha):
        return None
    return {
        "alpha": float(alpha),
        "margin": float(row["governor_margin"]),
        "admissible": bool(row.get("admissible", True)),
        "constraint": row.get("constraint", ""),
    }


def _state(values: Mapping[str, Any]) -> Iterator[Readout]:
    if values["torque"] is not None:
        yield source_readout("torque", values["source"])
    yield Readout("disturbed by", magnitude(values["external_torque"], "N m"))
    for name, margin in values["margins_deg"].items():
        yield Readout(f"margin to {name}", number(margin, 4, "°"), "bad" if margin < 0.0 else "")


def _solver(solve: Mapping[str, Any]) -> Iterator[Readout]:
    status = solve["status"]
    yield Readout("solver", status, "" if status == Status.CONVERGED.text else "warn")
    yield Readout("iterations", "" if status == _NO_SOLVE else f"{solve['iterations']}")
    yield Readout("residual", small(solve["residual"]))
    yield Readout("least curvature", small(solve["curvature"]))
    yield Readout("solve time", duration(solve["solve_time"]))


def _governor(decision: Mapping[str, Any]) -> Iterator[Readout]:
    yield Readout("governor alpha", number(decision["alpha"], 4))
    yield Readout("margin", small(decision["margin"]))
    yield Readout("limited by", decision["constraint"])
    yield Readout("reference held", "" if decision["admissible"] else "yes", "warn")
