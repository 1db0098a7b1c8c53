"""``gnc check``: can this scenario fly, and if not, why; without ROS.

Kernels are loaded only where a core has to look ahead from the start, or where the penalty of the
torque limit may be too small.
"""

from __future__ import annotations

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

if TYPE_CHECKING:
    from spacecraft_gnc.scenario import Scenario
    from spacecraft_gnc.vehicles.vehicle import Facts, Outlook


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
    if quiet and not as_json:
        return
    cut_short = checked.launcher.cut_short or replaces_duration(overrides or ())
    expected = _outlook(checked, cut_short)
    facts = _facts(checked, expected)
    if as_json:
        told = {"problems": [], "warnings": [*checked.warnings, *expected.warnings]}
        print_json({"scenario": str(scenario), "ok": True, **told, **_numbers(checked, facts)})
    else:
        tell_warnings(checked, expected.warnings)
        print(f"{scenario}: can fly")
        print_table(_rows(checked, facts))


def _outlook(scenario: Scenario, cut_short: bool) -> Outlook:
    from spacecraft_gnc.vehicles.vehicle import Outlook

    part = scenario.vehicle.outlook
    return Outlook() if part is None else part.load()(scenario, cut_short)


def _facts(scenario: Scenario, expected: Outlook) -> Facts:
    from spacecraft_gnc.vehicles.vehicle import Facts

    part = scenario.vehicle.facts
    return Facts() if part is None else part.load()(scenario, expected)


def _numbers(scenario: Scenario, facts: Facts) -> dict[str, Any]:
    """Return what a scenario would fly, in numbers."""
    return {
        "vehicle": scenario.vehicle.name,
        "mode": scenario.plant.mode,
        "steps": scenario.n_steps,
        "period": scenario.period,
        "substeps": scenario.substeps,
        "duration": scenario.n_steps * scenario.period,
        "method": scenario.controller.method,
        "variant": _variant(scenario),
        "governor": scenario.governor.governor,
        "nodes": list(scenario.launcher.nodes),
        **facts.numbers,
    }


def _rows(scenario: Scenario, facts: Facts) -> list[tuple[str, str]]:
    plant, period, steps = scenario.plant, scenario.period, scenario.n_steps
    pace = f"free_run x{plant.real_time_factor:g}" if plant.mode == "free_run" else plant.mode
    variant = _variant(scenario)
    method = scenario.controller.method + ("" if variant is None else f" ({variant})")
    rows = [
        ("vehicle", _joined(scenario.vehicle.name, facts.body)),
        ("flight", f"{steps} control steps of {period:g} s, {steps * period:g} s in all, {pace}"),
        ("integrator", f"{scenario.substeps} step(s) of {plant.time_step:g} s a control step"),
        ("start", facts.start),
        ("controller", _joined(method, facts.controller)),
        *facts.rows,
        ("governor", _joined(scenario.governor.governor, facts.governor)),
        ("nodes", ", ".join(scenario.launcher.nodes)),
    ]
    return [row for row in rows if row[1]]


def _joined(*texts: str) -> str:
    return ", ".join(text for text in texts if text)


def _variant(scenario: Scenario) -> str | None:
    """Return the variant; None where the method has none."""
    return scenario.controller.variant if scenario.method.variants else None
