"""Another controller along a flight that was flown."""

from __future__ import annotations

from typing import Final

from spacecraft_gnc.arguments import require_kind
from spacecraft_gnc.parameters.declare import flatten
from spacecraft_gnc.parameters.problems import Problem
from spacecraft_gnc.parameters.values import plain
from spacecraft_gnc.parameters.yaml_file import Entry, Given
from spacecraft_gnc.scenario.checks_reads import unread_by
from spacecraft_gnc.scenario.load import check_given, entries_of, found_from_here, lay_over
from spacecraft_gnc.scenario.overrides import Overrides, apply
from spacecraft_gnc.scenario.scenario import Scenario
from spacecraft_gnc.scenario.schema import vehicle_given

_CONTROLLER: Final = "nmpc_controller"


def revise(
    scenario: Scenario, overrides: Overrides = (), method: str | None = None
) -> tuple[Scenario, tuple[str, ...]]:
    """Return a scenario for another controller along a flight that was flown under ``scenario``.

    Where a governor moved the reference, it has done its work: it is left out, and so is the start,
    from which the new controller need not reach the target by itself.

    Parameters
    ----------
    scenario : Scenario
        What flew.
    overrides : mapping or sequence of str
        As for `load`.
    method : str, optional
        The other ``nmpc_controller.method``.

    Returns
    -------
    Scenario, tuple of str
        The revised one, and the names of the controller's parameters that were left out because
        the new method does not read them.

    Raises
    ------
    InvalidScenario
        With every problem at once.
    """
    given = _given_along_a_flight(require_kind("scenario", scenario, Scenario))
    problems: list[Problem] = []
    laid_over = {_CONTROLLER: {}, **apply(overrides, problems)[""]}  # of a craft alone: none
    if method is not None:
        laid_over[_CONTROLLER]["method"] = Entry(plain(method), "--method", coerce=True)
    chosen = laid_over[_CONTROLLER].get("method")
    unread: tuple[str, ...] = ()
    if chosen is not None and chosen.value != scenario.controller.method:
        changed = [name for name in given[_CONTROLLER] if not _is_default(scenario, name)]
        unread = tuple(unread_by(scenario.vehicle, str(chosen.value), changed))
    for name in unread:
        del given[_CONTROLLER][name]
    vehicle = vehicle_given({**given.get("plant", {}), **laid_over.get("plant", {})}, scenario.path)
    lay_over(given, found_from_here(vehicle, laid_over))
    revised = check_given(vehicle, given, scenario.path, problems, stated=scenario.defaults)
    return revised, unread


def _given_along_a_flight(scenario: Scenario) -> Given:
    """Return what was given, less what only a start and a target have to meet."""
    sections = {name: flatten(values) for name, values in scenario.sections.items()}
    if scenario.vehicle.revision is not None:
        scenario.vehicle.revision.load()(scenario, sections)
    sections.setdefault(_CONTROLLER, {})
    sections.setdefault("launcher", {})["cut_short"] = True  # no target has to be reached
    return {name: entries_of(values, scenario.path) for name, values in sections.items()}


def _is_default(scenario: Scenario, name: str) -> bool:
    value = scenario.values[_CONTROLLER][name]
    spec = scenario.schema.spec_of(_CONTROLLER, name, value)
    default = None if spec is None else spec.default
    return value == scenario.defaults[_CONTROLLER].get(name, default)
