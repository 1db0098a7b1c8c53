"""Signals of every vehicle that is installed, for bags of any of them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress

from spacecraft_gnc.errors import GncError
from spacecraft_gnc.signals import Signal, graph
from spacecraft_gnc.signals.graph import CONTROLLER, PLANT
from spacecraft_gnc.vehicles.registry import VEHICLES, names, vehicle_of
from spacecraft_gnc.vehicles.vehicle import Vehicle


def every_signal() -> tuple[Signal, ...]:
    """Return the signals of the graph and of the vehicles; a broken one of another package's none.

    A signal that several vehicles share comes once.
    """
    declared = (_declared(vehicle) for vehicle in _known_vehicles())
    found = dict.fromkeys(signal for signals in declared for signal in signals)
    return (*found, *graph.SIGNALS)


def state_signals() -> list[Signal]:
    """Return the signals that tell the state of a vehicle, one of which every flight has."""
    return [signal for signal in every_signal() if _is_state(signal)]


def vehicles_by_state() -> dict[Signal, Vehicle]:
    """Return the vehicles that can fly as a graph, by the signal that tells their state."""
    return {
        signal: vehicle
        for vehicle in _known_vehicles()
        for signal in _declared(vehicle)
        if _is_state(signal)
    }


def _is_state(signal: Signal) -> bool:
    told = signal.publishers == (PLANT,) and CONTROLLER in signal.subscribers
    return told and not signal.shared


def _known_vehicles() -> Iterator[Vehicle]:
    for name in names(VEHICLES):
        with suppress(GncError):
            yield vehicle_of(name)


def _declared(vehicle: Vehicle) -> tuple[Signal, ...]:
    try:
        signals: tuple[Signal, ...] = () if vehicle.signals is None else vehicle.signals.load()
    except GncError:
        return ()
    return signals


def signal_of(topic: str, type_name: str) -> Signal:
    """Return the signal of a recorded topic, by the last part of its name and its type.

    That of a vehicle that is not installed has no fields, and therefore no rules.
    """
    name = topic.rpartition("/")[2]
    for signal in every_signal():
        if signal.name.strip("/") == name and signal.type == type_name:
            return signal
    return Signal(name=name, type=type_name, fields={})
