"""A vehicle of two craft, of another package: what the shared graph makes of such a one."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import metadata
from typing import Any, NamedTuple

import numpy as np
import pytest

from spacecraft_gnc.lazy import Lazy
from spacecraft_gnc.loop import Command
from spacecraft_gnc.loop.flight import Flight, column
from spacecraft_gnc.parameters.parameter import Kind, parameter
from spacecraft_gnc.parameters.sections import (
    ControllerHost,
    GovernorHost,
    PlantHost,
    method_named,
)
from spacecraft_gnc.signals import Field, Signal
from spacecraft_gnc.signals.graph import CONTROLLER, GOVERNOR, PLANT
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.vehicle import GovernorLaw, Method, Vehicle

HERE = __name__
STATE = Signal(
    name="pair_state",
    type="two_craft_msgs/msg/PairState",
    fields={"position": Field("float64[2]", "m")},
    publishers=(PLANT,),
    subscribers=(CONTROLLER, GOVERNOR),
    unique=True,
)
PUSH = Signal(
    name="push",
    type="two_craft_msgs/msg/Push",
    fields={"push": Field("float64", "m/s")},
    publishers=(CONTROLLER,),
    subscribers=(PLANT,),
    of_craft=True,
)
REFERENCE = Signal(
    name="pair_reference",
    type="two_craft_msgs/msg/PairState",
    fields={"position": Field("float64[2]", "m")},
    publishers=(GOVERNOR,),
    subscribers=(CONTROLLER,),
)
SIGNALS = (STATE, PUSH, REFERENCE)


class Positions(NamedTuple):
    step: int
    position: Array


class Decision(NamedTuple):
    reference: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class PlantParameters(PlantHost):
    spacecraft: tuple[str, ...] = parameter(
        Kind.STRING_ARRAY, ["port", "starboard"], "the craft", shape=(2,), unique=True
    )
    time_step: float = parameter(Kind.DOUBLE, 1.0, "step", unit="s", above=0.0)
    duration: float = parameter(Kind.DOUBLE, 5.0, "time", unit="s", above=0.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class GainParameters:
    gain: float = parameter(Kind.DOUBLE, 0.5, "share of the error", unit="1/s", above=0.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class ControllerParameters(GainParameters, ControllerHost):
    method: str = method_named("pushes")


@dataclass(frozen=True, slots=True, kw_only=True)
class PairFlight(Flight):
    position: Array = column("state.position", (2,), carried_by="pair_state/position")
    push: Array = column("command.control", (2, 1))


class Pair:
    """Two craft on one line, each moved by its pushes."""

    flight = PairFlight
    idle_control = np.zeros((2, 1))

    def __init__(self, scenario: Any) -> None:
        self.period, self.n_steps = scenario.period, scenario.n_steps
        self.reset()

    def step(self, push: Array) -> Positions:
        self.state = Positions(self.state.step + 1, self.state.position + push[:, 0])
        return self.state

    def outputs(self, applied: tuple[Any, Any]) -> list[tuple[Signal, Any]]:
        self.told = applied
        return [(STATE, (self.state.position,))]

    def warm_up(self) -> None:
        pass

    def reset(self) -> None:
        self.state = Positions(0, np.array([1.0, -2.0]))


class Pusher:
    """Pushes one of the craft toward its place."""

    name = "pushes"
    slow = False

    def __init__(self, scenario: Any, craft: int) -> None:
        self.period, self._gain, self._craft = scenario.period, scenario.controller.gain, craft

    def command(self, state: Positions, reference: Array) -> Command:
        error = state.position[self._craft] - reference[self._craft]
        return Command(np.array([-self._gain * error]))

    def warm_up(self) -> None:
        pass

    def reset(self) -> None:
        pass


class Pushers(Pusher):
    """The pushers of both."""

    def __init__(self, scenario: Any) -> None:
        super().__init__(scenario, 0)
        self.craft = (Pusher(scenario, 0), Pusher(scenario, 1))

    def command(self, state: Positions, reference: Array) -> Command:
        return Command(np.stack([one.command(state, reference).control for one in self.craft]))


class Home:
    """A governor whose target is the origin."""

    name = "none"
    slow = False
    target = np.zeros(2)

    def __init__(self, _scenario: Any) -> None:
        pass

    def decide(self, _state: Positions) -> Decision:
        return Decision(self.target)

    def warm_up(self) -> None:
        pass

    def reset(self) -> None:
        pass


def craft(scenario: Any) -> tuple[str, ...]:
    return tuple(scenario.plant.spacecraft)


PAIR = Vehicle(
    name="pair",
    description="two craft on one line",
    sections={
        "plant": PlantParameters,
        "nmpc_controller": ControllerParameters,
        "reference_governor": GovernorHost,
    },
    plant=Lazy(f"{HERE}:Pair"),
    craft=Lazy(f"{HERE}:craft"),
    signals=Lazy(f"{HERE}:SIGNALS"),
    methods=(Method(name="pushes", build=Lazy(f"{HERE}:Pushers"), parameters=GainParameters),),
    governors=(GovernorLaw(name="none", build=Lazy(f"{HERE}:Home"), looks_ahead=False),),
    flight=Lazy(f"{HERE}:PairFlight"),
)


def announce(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have the vehicle's entry point found."""
    installed = metadata.entry_points
    group = "spacecraft_gnc.vehicles"

    def entry_points(**selection: str) -> Any:
        if selection.get("group") != group:
            return installed(**selection)
        return [metadata.EntryPoint("pair", f"{HERE}:PAIR", group)]

    monkeypatch.setattr(metadata, "entry_points", entry_points)
