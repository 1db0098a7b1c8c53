"""Replay of every recorded step, by the same controller or another one.

The controller is given the measured state and the reference of each step as recorded, so it never
flies away from the recording: differences of the commands are differences of the laws alone. The
laws have no memory and no cost of a plan: a cold start and costs do not apply.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.docking.resolved import Resolved
from spacecraft_gnc.vehicles.docking.state import Navigation, RelativeReference, RelativeState
from spacecraft_gnc.vehicles.replay import complete_steps, require_period

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from spacecraft_gnc.vehicles.docking.flight import DockingFlight
    from spacecraft_gnc.vehicles.docking.scenario import Scenario

_PARTS: Final = ("port_offset", "port_velocity", "attitude", "angular_velocity")
_NEEDED: Final = (*(f"measured_{name}" for name in _PARTS), "reference", "force", "moment")


class DockingReplay:
    """Implements `vehicles.replay.VehicleReplay`."""

    control = "wrench"

    def resolve(
        self,
        flight: DockingFlight,
        recorded: Scenario,
        revised: Scenario,
        *,
        steps: tuple[int, int] | None = None,
        cold: bool = False,
        progress: Callable[[int, int], None] | None = None,
    ) -> Resolved:
        """Answer every recorded step again.

        Raises
        ------
        ParameterError
            If the periods of the two differ, or no step can be compared.
        """
        del recorded, cold
        controller = revised.build_controller()
        require_period(controller, flight)
        chosen = complete_steps(flight, _NEEDED, steps, "command")
        controller.warm_up()
        answers, walls = [], []
        for i, k in enumerate(chosen.tolist()):
            begun = time.perf_counter()
            reference = RelativeReference.of(flight.reference[k])
            answers.append(controller.command(_state(flight, k), reference).control)
            walls.append(time.perf_counter() - begun)
            if progress is not None:
                progress(i + 1, len(chosen))
        flown = np.hstack([flight.force[chosen], flight.moment[chosen]])
        return Resolved(chosen, flight.time[chosen], flown, np.array(answers), np.array(walls))

    def compare(self, resolved: Resolved, recorded: Scenario, revised: Scenario) -> dict[str, Any]:
        """Return the comparison in numbers, ready for JSON."""
        force, moment = resolved.largest_differences
        return {
            "steps": len(resolved.steps),
            "first_difference": resolved.first_difference,
            "max_force_difference": force,
            "max_moment_difference": moment,
            "recorded": _side(recorded, resolved.recorded, None),
            "replayed": _side(revised, resolved.replayed, resolved.wall_times),
        }

    def sides(self, old: dict[str, Any], new: dict[str, Any]) -> list[tuple[str, str, str]]:
        """Return the rows of a table: what it is, as flown, as replayed."""
        return [
            ("method", old["method"], new["method"]),
            ("largest force", f"{old['max_force']:.6g} N", f"{new['max_force']:.6g} N"),
            ("largest moment", f"{old['max_moment']:.6g} N m", f"{new['max_moment']:.6g} N m"),
            ("time a command, median", "-", f"{1e6 * new['solve_time_median']:.0f} us"),
        ]

    def differences(self, numbers: dict[str, Any], period: float) -> list[tuple[str, str]]:
        """Return the rows that hold for both together."""
        first = numbers["first_difference"]
        where = "none, bit for bit" if first is None else f"step {first}, {first * period:g} s"
        return [
            ("first difference", where),
            ("largest difference of force", f"{numbers['max_force_difference']:.3g} N"),
            ("largest difference of moment", f"{numbers['max_moment_difference']:.3g} N m"),
        ]

    def figure(self, resolved: Resolved, names: tuple[str, str], title: str = "") -> Figure:
        """Draw both forces and both moments, and their differences."""
        from spacecraft_gnc.vehicles.docking.replay_picture import replay_figure

        return replay_figure(resolved, names, title)


REPLAY: Final = DockingReplay()


def _state(flight: DockingFlight, k: int) -> RelativeState:
    truth = Navigation(*(getattr(flight, name)[k] for name in _PARTS))
    measured = Navigation(*(getattr(flight, f"measured_{name}")[k] for name in _PARTS))
    last = np.concatenate([flight.force[k - 1], flight.moment[k - 1]]) if k else np.zeros(6)
    margins = float(flight.line_of_sight_margin[k]), float(flight.clearance[k])
    return RelativeState(k, *truth, measured, *margins, flight.thrusters[k], last)


def _side(scenario: Scenario, wrenches: Array, walls: Array | None) -> dict[str, Any]:
    return {
        "method": scenario.controller.method,
        "max_force": float(np.abs(wrenches[:, :3]).max()),
        "max_moment": float(np.abs(wrenches[:, 3:]).max()),
        "solve_time_median": None if walls is None else float(np.median(walls)),
    }
