"""One vehicle of the plant node: its core, and its ends in the graph."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.nodes._node import GncNode
from spacecraft_gnc.nodes._pace import Applied
from spacecraft_gnc.ros.graph_of import vehicle_signals
from spacecraft_gnc.scenario import Scenario
from spacecraft_gnc.signals import Signal
from spacecraft_gnc.signals.graph import PLANT
from spacecraft_gnc.signals.members import Seams
from spacecraft_gnc.signals.message import Stamp


class Agent:
    """One vehicle, and its ends in the graph.

    Parameters
    ----------
    name
        Its namespace in the graph.
    scenario
        What flies.
    craft
        Namespaces of its craft; empty: it is one.
    """

    def __init__(self, name: str, scenario: Scenario, craft: Sequence[str]) -> None:
        self.name = name
        self.craft = tuple(craft)
        self.commanded = self.craft or (name,)
        """Namespaces of which a command is awaited."""
        self.signals = vehicle_signals(scenario.vehicle)
        self.seams = Seams.among(self.signals)
        self.core = scenario.build_plant()
        self.core.warm_up()
        self.publish: dict[Signal, Callable[[bytes], None]] = {}
        self.reset()

    def reset(self) -> None:
        """Return to the initial state."""
        self.core.reset()
        idle = [Applied(self.idle(space), Source.ZERO) for space in self.commanded]
        self.applied = self._together(idle)
        self.last_commands = dict.fromkeys(self.commanded, b"")
        self.state = b""

    def idle(self, space: str) -> Any:
        """Return the control without a command of the vehicle, or of one of its craft."""
        idle = self.core.idle_control
        return idle[self.craft.index(space)] if self.craft else idle

    def step(self, applied: Mapping[str, Applied]) -> None:
        """Fly one control period under what acts on each craft."""
        self.applied = self._together([applied[space] for space in self.commanded])
        self.core.step(self.applied.control)

    def _together(self, applied: Sequence[Applied]) -> Applied:
        """Return what acts on all craft as the plant takes it (`loop.protocols.Plant`)."""
        if not self.craft:
            return applied[0]
        controls, sources = zip(*applied, strict=True)
        return Applied(np.stack(controls), sources)

    def open(self, node: GncNode) -> None:
        """Advertise what the plant publishes of this vehicle."""
        self.publish = {
            signal: node.advertise(signal, self.name).publish
            for signal in self.signals
            if PLANT in signal.publishers
        }

    def tell(self, stamp: Stamp, step: int) -> None:
        """Publish the current state and what is told beside it."""
        for signal, value in self.core.outputs(self.applied):
            data = signal.encode(stamp, step, value)
            if signal is self.seams.state:
                self.state = data
            self.publish[signal](data)

    def repeat(self) -> None:
        """Publish the same state again."""
        self.publish[self.seams.state](self.state)
