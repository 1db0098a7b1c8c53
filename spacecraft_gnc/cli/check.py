"""``gnc check``: validate a scenario without ROS.

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
    from spacecraft_gnc.scenario import InvalidScenario, load_fleet
    from spacecraft_gnc.scenario.overrides import replaces_duration

    try:
        fleet = load_fleet(scenario, overrides or (), namespace)
        fleet.check_cores()
    except InvalidScenario as error:
        if not as_json:
            raise
        problems = [problem.as_dict() for problem in error.problems]
        print_json({"scenario": str(scenario), "ok": False, "problems": problems, "warnings": []})
        raise typer.Exit(error.exit_code) from None
    if quiet and not as_json:
        return
    cut_short = fleet.launcher.cut_short or replaces_duration(overrides or ())
    expected = {agent: _outlook(one, cut_short) for agent, one in fleet.agents.items()}
    facts = {agent: _facts(one, expected[agent]) for agent, one in fleet.agents.items()}
    further = [
        f"/{agent}: {text}" if agent else text
        for agent, outlook in expected.items()
        for text in outlook.warnings
    ]
    if as_json:
        numbers = {agent: _numbers(one, facts[agent]) for agent, one in fleet.agents.items()}
        told = {"problems": [], "warnings": [*fleet.warnings, *further]}
        of_all = {"nodes": list(fleet.nodes), **numbers.get("", {"agents": numbers})}
        print_json({"scenario": str(scenario), "ok": True, **told, **of_all})
        return
    tell_warnings(fleet, further)
    print(f"{scenario}: can fly")
    nodes = ("nodes", ", ".join(fleet.nodes))
    for agent, one in fleet.agents.items():
        if agent:
            print(f"/{agent}")
        print_table([*_rows(one, facts[agent]), *([] if agent else [nodes])])
    if "" not in fleet.agents:
        print("graph")
        print_table([nodes])


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
    ]
    return [row for row in rows if row[1]]


def _joined(*texts: str) -> str:
    return ", ".join(text for text in texts if text)


def _variant(scenario: Scenario) -> str | None:
    """Return the variant; None where the method has none."""
    return scenario.controller.variant if scenario.method.variants else None
