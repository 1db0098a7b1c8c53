"""``gnc check``: can this scenario fly, and if not, why; without ROS.

Kernels are loaded only where a core has to look ahead from the start, or where the penalty of the
torque limit may be too small.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import typer

from spacecraft_gnc.cli._common import (
    JsonOption,
    QuietOption,
    ScenarioArgument,
    SetOption,
    SpacecraftOption,
    print_json,
    print_table,
    tell_warnings,
)
from spacecraft_gnc.vehicles.rigid_body.outlook import Outlook, outlook, settling_text

if TYPE_CHECKING:
    from spacecraft_gnc.scenario import Scenario
    from spacecraft_gnc.types import Array


def check(
    scenario: ScenarioArgument,
    overrides: SetOption = None,
    namespace: SpacecraftOption = None,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Check a scenario file; list every problem with the way to mend it."""
    from spacecraft_gnc.scenario import InvalidScenario, load
    from spacecraft_gnc.scenario.overrides import replaces_duration

    try:
        checked = load(scenario, overrides or (), namespace)
        checked.check_cores()
    except InvalidScenario as error:
        if not as_json:
            raise
        problems = [problem.as_dict() for problem in error.problems]
        print_json({"scenario": str(scenario), "ok": False, "problems": problems, "warnings": []})
        raise typer.Exit(error.exit_code) from None
    cut_short = checked.launcher.cut_short or replaces_duration(overrides or ())
    if as_json:
        expected = outlook(checked, cut_short)
        told = {"problems": [], "warnings": [*checked.warnings, *expected.warnings]}
        numbers = {**facts(checked), **_foretold(expected)}
        print_json({"scenario": str(scenario), "ok": True, **told, **numbers})
    elif not quiet:
        expected = outlook(checked, cut_short)
        tell_warnings(checked, expected.warnings)
        print(f"{scenario}: can fly")
        print_table(_rows(checked, expected))


def facts(scenario: Scenario) -> dict[str, Any]:
    """Return what a scenario would fly, in numbers."""
    return {
        "vehicle": scenario.plant.vehicle,
        "mode": scenario.plant.mode,
        "steps": scenario.n_steps,
        "period": scenario.period,
        "substeps": scenario.substeps,
        "duration": scenario.n_steps * scenario.period,
        "initial_error_deg": _initial_error_deg(scenario),
        "method": scenario.controller.method,
        "variant": _variant(scenario),
        "horizon": _horizon(scenario),
        "max_torque": scenario.controller.max_torque,
        "zones": [zone.name for zone in scenario.controller.zones],
        "governor": scenario.governor.governor,
        "nodes": list(scenario.launcher.nodes),
    }


def _foretold(expected: Outlook) -> dict[str, Any]:
    """Return the prediction in numbers; None for what is not predicted, or never."""
    prediction = expected.prediction
    if prediction is None:
        return dict.fromkeys(("spectral_radius", "predicted_settling_time", "limit_excess"))
    time = prediction.settling_time
    return {
        "spectral_radius": prediction.spectral_radius,
        "predicted_settling_time": time if math.isfinite(time) else None,
        "limit_excess": expected.excess,
    }


def _rows(scenario: Scenario, expected: Outlook) -> list[tuple[str, str]]:
    import numpy as np

    plant, controller = scenario.plant, scenario.controller
    moments = " ".join(f"{value:g}" for value in np.linalg.eigvalsh(plant.inertia))
    momentum = float(np.linalg.norm(plant.initial_momentum))
    error = _initial_error_deg(scenario)
    period, steps = scenario.period, scenario.n_steps
    pace = f"free_run x{plant.real_time_factor:g}" if plant.mode == "free_run" else plant.mode
    zones = [f"{z.name} ({z.kind}, {z.half_angle_deg:g} deg)" for z in controller.zones]
    return [
        ("vehicle", f"{plant.vehicle}, principal moments {moments} kg m^2"),
        ("flight", f"{steps} control steps of {period:g} s, {steps * period:g} s in all, {pace}"),
        ("integrator", f"{scenario.substeps} step(s) of {plant.time_step:g} s a control step"),
        ("start", f"{error:.4g} deg from the target, |Pi| {momentum:g} N m s"),
        ("controller", _controller(scenario)),
        ("torque limit", f"{controller.max_torque:g} N m" if controller.max_torque else "none"),
        ("settling", settling_text(scenario, expected.prediction)),
        ("zones", ", ".join(zones) or "none"),
        ("governor", _governor(scenario)),
        ("nodes", ", ".join(scenario.launcher.nodes)),
    ]


def _controller(scenario: Scenario) -> str:
    """Return the method with variant and horizon, where it has them."""
    variant, horizon = _variant(scenario), _horizon(scenario)
    return (
        scenario.controller.method
        + (f" ({variant})" if variant is not None else "")
        + (f", horizon {horizon} steps" if horizon is not None else "")
    )


def _variant(scenario: Scenario) -> str | None:
    """Return the variant; None where the method has none."""
    return scenario.controller.variant if scenario.traits.variants else None


def _horizon(scenario: Scenario) -> int | None:
    """Return the prediction horizon in steps; None where the method reads none."""
    return scenario.controller.horizon if "horizon" in scenario.traits.reads else None


def _governor(scenario: Scenario) -> str:
    """Return the governor with the limits that it keeps."""
    g = scenario.governor
    limits = (("torque", g.max_torque, "N m"), ("momentum", g.max_momentum, "N m s"))
    kept = [f"{what} limit {value:g} {unit}" for what, value, unit in limits if value > 0.0]
    return ", ".join([g.governor, *kept])


def _initial_error_deg(scenario: Scenario) -> float:
    """Return the angle between the initial and the target attitude [deg]."""
    start = _quaternion(scenario.plant.initial_rotation_vector)
    target = _quaternion(scenario.governor.target_rotation_vector)
    return math.degrees(2.0 * math.acos(min(1.0, abs(float(start @ target)))))


def _quaternion(rotation_vector: Array) -> Array:
    """Return the unit quaternion (4,), scalar first, of a rotation vector (3,) [rad]."""
    import numpy as np

    angle = float(np.linalg.norm(rotation_vector))
    vector = 0.5 * np.sinc(0.5 * angle / math.pi) * rotation_vector
    return np.array([math.cos(0.5 * angle), *vector])
