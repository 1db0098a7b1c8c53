"""Replay of every recorded step, by the same controller or another one.

The controller is given the recorded state and reference of each step, so it never flies away from
the recording: differences of the commands are differences of the controllers alone.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from spacecraft_gnc.loop.protocols import Command, Reference
from spacecraft_gnc.status import Status
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.replay import complete_steps, require_period
from spacecraft_gnc.vehicles.two_wheel.controllers.report import solve_of
from spacecraft_gnc.vehicles.two_wheel.resolved import Resolved
from spacecraft_gnc.vehicles.two_wheel.state import WheelState

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from spacecraft_gnc.vehicles.two_wheel.flight import WheelFlight
    from spacecraft_gnc.vehicles.two_wheel.scenario import Scenario

_STILL: Final = np.zeros(3)
_NEEDED: Final = ("attitude", "reference", "wheel_speed", "wheel_acceleration")


class WheelReplay:
    """Implements `vehicles.replay.VehicleReplay`."""

    control = "acceleration"

    def resolve(
        self,
        flight: WheelFlight,
        recorded: Scenario,
        revised: Scenario,
        *,
        steps: tuple[int, int] | None = None,
        cold: bool = False,
        progress: Callable[[int, int], None] | None = None,
    ) -> Resolved:
        """Answer every recorded step again; ``cold``: forget the past before each.

        Raises
        ------
        ParameterError
            If the periods of the two differ, or no step can be compared.
        """
        del recorded
        controller = revised.build_controller()
        require_period(controller, flight)
        chosen = complete_steps(flight, _NEEDED, steps, "command")
        controller.warm_up()
        controller.reset()
        answers, walls, costs = [], [], []
        for i, k in enumerate(chosen.tolist()):
            if cold:
                controller.reset()
            begun = time.perf_counter()
            reference = Reference(flight.reference[k], _STILL, _STILL)
            command = controller.command(_state(flight, k), reference)
            walls.append(time.perf_counter() - begun)
            answers.append(command.control)
            costs.append(_cost(command))
            if progress is not None:
                progress(i + 1, len(chosen))
        solved = flight.status[chosen] == Status.CONVERGED
        return Resolved(
            chosen,
            flight.time[chosen],
            flight.wheel_acceleration[chosen],
            np.array(answers),
            np.array(walls),
            np.where(solved, flight.cost[chosen], np.nan),
            np.array(costs),
        )

    def compare(self, resolved: Resolved, recorded: Scenario, revised: Scenario) -> dict[str, Any]:
        """Return the comparison in numbers, ready for JSON."""
        return {
            "steps": len(resolved.steps),
            "first_difference": resolved.first_difference,
            "max_acceleration_difference": float(resolved.difference.max()),
            "max_cost_difference": resolved.cost_difference,
            "recorded": _side(recorded, resolved.recorded, resolved.recorded_costs, None),
            "replayed": _side(
                revised, resolved.replayed, resolved.replayed_costs, resolved.wall_times
            ),
        }

    def sides(self, old: dict[str, Any], new: dict[str, Any]) -> list[tuple[str, str, str]]:
        """Return the rows of a table: what it is, as flown, as replayed."""
        flown, again = (f"{side['max_acceleration']:.6g} rad/s^2" for side in (old, new))
        return [
            ("method", old["method"], new["method"]),
            ("steps with a plan", str(old["solved"]), str(new["solved"])),
            ("largest acceleration", flown, again),
            ("time a command, median", "-", f"{1e6 * new['solve_time_median']:.0f} us"),
        ]

    def differences(self, numbers: dict[str, Any], period: float) -> list[tuple[str, str]]:
        """Return the rows that hold for both together."""
        first = numbers["first_difference"]
        where = "none, bit for bit" if first is None else f"step {first}, {first * period:g} s"
        largest = f"{numbers['max_acceleration_difference']:.3g} rad/s^2"
        cost = numbers["max_cost_difference"]
        rows = [("first difference", where), ("largest difference", largest)]
        return rows if cost is None else [*rows, ("difference of costs", f"{cost:.3g}")]

    def figure(self, resolved: Resolved, names: tuple[str, str], title: str = "") -> Figure:
        """Draw both commands, and their difference."""
        from spacecraft_gnc.vehicles.two_wheel.pictures import replay_figure

        return replay_figure(resolved, names, title)


REPLAY: Final = WheelReplay()


def _state(flight: WheelFlight, k: int) -> WheelState:
    return WheelState(
        k,
        flight.attitude[k],
        flight.angular_velocity[k],
        flight.wheel_speed[k],
        flight.total_momentum[k],
        flight.healthy[k],
        flight.wheel_acceleration[k - 1] if k else None,
    )


def _side(scenario: Scenario, commands: Array, costs: Array, walls: Array | None) -> dict[str, Any]:
    c = scenario.controller
    plans = f"{c.method}, {c.prediction_model}, {c.solver}"
    return {
        "method": plans if c.method == "underactuated" else c.method,
        "solved": int(np.isfinite(costs).sum()),
        "max_acceleration": float(np.abs(commands).max()),
        "solve_time_median": None if walls is None else float(np.median(walls)),
    }


def _cost(command: Command) -> float:
    """Return the cost of the plan behind a command; NaN where none was found."""
    solve = solve_of(command)
    return solve.cost if solve and solve.status is Status.CONVERGED else math.nan
