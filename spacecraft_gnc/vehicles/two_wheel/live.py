"""Live view of a spacecraft with wheels: values, charts and readouts."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any, Final

from spacecraft_gnc import lie
from spacecraft_gnc.drawing.live import (
    Panel,
    Readout,
    Series,
    attitude_readouts,
    attitude_values,
    error_panel,
    listed,
    magnitude,
    source_panel,
    source_readout,
)
from spacecraft_gnc.drawing.sources import source_name
from spacecraft_gnc.vehicles.two_wheel.flown import limit_of
from spacecraft_gnc.vehicles.two_wheel.scenario import Scenario

_SHOWN: Final = (
    "angular_velocity", "wheel_speed", "wheel_acceleration", "total_momentum", "healthy",
)  # fmt: skip
_LIMITS: Final = ("max_wheel_speed", "max_wheel_acceleration")


class WheelLive:
    """Implements `drawing.live.VehicleLive`."""

    fields: Final[Mapping[str, str]] = MappingProxyType({})
    history: Final = (
        "error_deg", "target_error_deg", "wheel_speed", "wheel_acceleration", "source",
    )  # fmt: skip

    def constants(self, scenario: Scenario | None) -> dict[str, Any]:
        """Return the limits of the wheels [rad/s], [rad/s^2] (0: none) and ``target`` (3, 3)."""
        target = None if scenario is None else scenario.governor.target_rotation_vector
        return {
            **{name: limit_of(scenario, name) for name in _LIMITS},
            "target": None if target is None else lie.exp(target),
            "zones": (),
        }

    def panels(self, scenario: Scenario | None) -> list[Panel]:
        """Return the charts."""
        limits = self.constants(scenario)
        governed = scenario is not None and scenario.governor.governor != "none"
        return [
            Panel(
                kind="bars", name="acceleration", title="Wheel accelerations now", unit="rad/s²",
                series=[Series("wheel_acceleration")], numbered="wheel ",
                limit=limits["max_wheel_acceleration"],
            ),
            error_panel(governed),
            Panel(
                kind="strip", name="speed", title="Wheel speeds", unit="rad/s",
                series=[Series("wheel_speed")], numbered="wheel ", limit=limits["max_wheel_speed"],
            ),
            Panel(
                kind="strip", name="acceleration_history", title="Wheel accelerations",
                unit="rad/s²", series=[Series("wheel_acceleration")], numbered="wheel ",
                limit=limits["max_wheel_acceleration"],
            ),
            source_panel("Command"),
        ]  # fmt: skip

    def values(self, row: Mapping[str, Any], constants: Mapping[str, Any]) -> dict[str, Any]:
        """Return what is shown of a step."""
        source = row.get("source")
        return {
            **attitude_values(row, constants),
            **{name: row.get(name) for name in _SHOWN},
            "source": source_name(-1 if source is None else int(source), "unknown"),
        }

    def readouts(self, values: Mapping[str, Any], governed: bool) -> dict[str, list[Readout]]:
        """Return the lines beside the picture."""
        return {
            "state": [*attitude_readouts(values, governed), *_state(values)],
            "wheels": list(_wheels(values)),
        }

    def line(self, values: Mapping[str, Any]) -> list[str]:
        """Return a few words about a step."""
        parts = []
        if math.isfinite(values["error_deg"]):
            parts.append(f"{values['error_deg']:.4g} deg off the reference")
        if values["wheel_speed"] is not None:
            parts.append(f"wheels at {listed(values['wheel_speed'])} rad/s")
        if values["wheel_acceleration"] is not None:
            parts.append(f"({values['source']})")
        return parts


LIVE: Final = WheelLive()


def _state(values: Mapping[str, Any]) -> Iterator[Readout]:
    if values["wheel_acceleration"] is not None:
        yield source_readout("command", values["source"])
    yield Readout("rate of the bus", magnitude(values["angular_velocity"], "rad/s"))
    yield Readout("total momentum", magnitude(values["total_momentum"], "N m s"))


def _wheels(values: Mapping[str, Any]) -> Iterator[Readout]:
    """Yield the speed of each wheel; one that does not answer stands out."""
    speeds, healthy = values["wheel_speed"], values["healthy"]
    for i, speed in enumerate(() if speeds is None else speeds.tolist()):
        lost = healthy is not None and not healthy[i]
        text = f"{speed:.4g} rad/s{', lost' if lost else ''}"
        yield Readout(f"wheel {i + 1}", text, "bad" if lost else "")
