"""The graph of a scenario: its agents, their signals, and what their nodes tell."""

from __future__ import annotations

from typing import Any

from spacecraft_gnc.errors import LaunchError
from spacecraft_gnc.parameters.sections import DEFAULT_VEHICLE
from spacecraft_gnc.scenario import Fleet, Scenario
from spacecraft_gnc.signals import Signal, graph
from spacecraft_gnc.signals.graph import PLANT
from spacecraft_gnc.signals.members import Members, foreign
from spacecraft_gnc.vehicles.registry import vehicle_of
from spacecraft_gnc.vehicles.vehicle import Vehicle


def members_of(fleet: Fleet) -> Members:
    """Return the nodes of the graph."""
    return Members((PLANT, *fleet.peers), fleet.recorder.topics, fleet.craft)


def vehicle_signals(vehicle: Vehicle | None = None) -> tuple[Signal, ...]:
    """Return the signals of a vehicle; None: of the one that flies unless a scenario says so."""
    known = vehicle_of(DEFAULT_VEHICLE) if vehicle is None else vehicle
    signals: tuple[Signal, ...] = () if known.signals is None else known.signals.load()
    return signals


def signals_of(fleet: Fleet) -> list[tuple[str, Signal]]:
    """Return (agent, signal) of every vehicle, and the signals of the graph.

    A signal of each craft comes once for each, with its namespace in place of the agent's.
    """
    own = [
        (space, signal)
        for agent, one in fleet.agents.items()
        for signal in vehicle_signals(one.vehicle)
        for space in (fleet.craft_of(agent) if signal.of_craft else ()) or (agent,)
    ]
    return [*own, *(("", signal) for signal in graph.SIGNALS)]


def foreign_topics(fleet: Fleet) -> tuple[str, ...]:
    """Return what the recorder is asked for and the graph does not have."""
    return foreign(signals_of(fleet), fleet.recorder.topics)


def outputs_of(scenario: Scenario) -> Any:
    """Return what tells the nodes of a vehicle what to publish.

    Raises
    ------
    LaunchError
        If the vehicle has nothing to tell, and cannot fly as a graph.
    """
    vehicle = scenario.vehicle
    if vehicle.outputs is None or vehicle.signals is None:
        raise LaunchError(
            f"plant.vehicle: received {vehicle.name!r}, which declares no signals; required a "
            "vehicle with signals and outputs to fly as a graph; use `gnc simulate`"
        )
    return vehicle.outputs.load()(scenario)
