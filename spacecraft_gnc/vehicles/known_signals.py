"""Signals of every vehicle that is installed, for bags of any of them."""

from __future__ import annotations

from spacecraft_gnc.errors import GncError
from spacecraft_gnc.signals import Signal, graph
from spacecraft_gnc.signals.graph import CONTROLLER, PLANT
from spacecraft_gnc.vehicles.registry import VEHICLES, names, vehicle_of


def every_signal() -> tuple[Signal, ...]:
    """Return the signals of the graph and of the vehicles; a broken one of another package's none.

    A signal that several vehicles share comes once.
    """
    found: dict[Signal, None] = {}
    for name in names(VEHICLES):
        try:
            declared = vehicle_of(name).signals
            found |= dict.fromkeys(() if declared is None else declared.load())
        except GncError:
            continue
    return (*found, *graph.SIGNALS)


def state_signals() -> list[Signal]:
    """Return the signals that tell the state of a vehicle, one of which every flight has."""
    return [
        s
        for s in every_signal()
        if s.publishers == (PLANT,) and CONTROLLER in s.subscribers and not s.shared
    ]


def signal_of(topic: str, type_name: str) -> Signal:
    """Return the signal of a recorded topic, by the last part of its name and its type.

    That of a vehicle that is not installed has no fields, and therefore no rules.
    """
    name = topic.rpartition("/")[2]
    for signal in every_signal():
        if signal.name.strip("/") == name and signal.type == type_name:
            return signal
    return Signal(name=name, type=type_name, fields={})
