"""Replay of every recorded step, by the same controller or another one.

The controller is given the state and the reference of each step as recorded, so it never flies away
from the recording: differences of the commands are differences of the laws alone. The law has no
memory and no cost of a plan: a cold start and costs do not apply.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation.resolved import Resolved
from spacecraft_gnc.vehicles.formation.state import FormationReference, FormationState
from spacecraft_gnc.vehicles.replay import complete_steps, require_period

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from spacecraft_gnc.vehicles.formation.flight import FormationFlight
    from spacecraft_gnc.vehicles.formation.scenario import Scenario

_NEEDED: Final = ("position", "velocity", "reference_position", "reference_velocity", "delta_v")


class FormationReplay:
    """Implements `vehicles.replay.VehicleReplay`."""

    control = "delta-v"

    def resolve(
        self,
        flight: FormationFlight,
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
            answers.append(controller.command(_state(flight, k), _reference(flight, k)).control)
            walls.append(time.perf_counter() - begun)
            if progress is not None:
                progress(i + 1, len(chosen))
        flown = flight.delta_v[chosen]
        return Resolved(chosen, flight.time[chosen], flown, np.array(answers), np.array(walls))

    def compare(self, resolved: Resolved, recorded: Scenario, revised: Scenario) -> dict[str, Any]:
        """Return the comparison in numbers, ready for JSON."""
        return {
            "steps": len(resolved.steps),
            "first_difference": resolved.first_difference,
            "max_delta_v_difference": resolved.largest_difference,
            "recorded": _side(recorded, resolved.recorded, None),
            "replayed": _side(revised, resolved.replayed, resolved.wall_times),
        }

    def sides(self, old: dict[str, Any], new: dict[str, Any]) -> list[tuple[str, str, str]]:
        """Return the rows of a table: what it is, as flown, as replayed."""
        return [
            ("method", old["method"], new["method"]),
            ("largest delta-v", f"{old['max_delta_v']:.6g} m/s", f"{new['max_delta_v']:.6g} m/s"),
            (
                "delta-v of all steps and craft",
                f"{old['total_delta_v']:.6g} m/s",
                f"{new['total_delta_v']:.6g} m/s",
            ),
            ("time a command, median", "-", f"{1e6 * new['solve_time_median']:.0f} us"),
        ]

    def differences(self, numbers: dict[str, Any], period: float) -> list[tuple[str, str]]:
        """Return the rows that hold for both together."""
        first = numbers["first_difference"]
        where = "none, bit for bit" if first is None else f"step {first}, {first * period:g} s"
        return [
            ("first difference", where),
            ("largest difference of delta-v", f"{numbers['max_delta_v_difference']:.3g} m/s"),
        ]

    def figure(self, resolved: Resolved, names: tuple[str, str], title: str = "") -> Figure:
        """Draw the delta-v of both, and their difference, of each craft."""
        from spacecraft_gnc.vehicles.formation.replay_picture import replay_figure

        return replay_figure(resolved, names, title)


REPLAY: Final = FormationReplay()


def _state(flight: FormationFlight, k: int) -> FormationState:
    last = flight.delta_v[k - 1] if k else np.zeros_like(flight.delta_v[0])
    return FormationState(k, flight.position[k], flight.velocity[k], flight.healthy[k], last)


def _reference(flight: FormationFlight, k: int) -> FormationReference:
    commanded = flight.reference_position[k], flight.reference_velocity[k]
    return FormationReference(flight.time_shift[k], *commanded)


def _side(scenario: Scenario, delta_v: Array, walls: Array | None) -> dict[str, Any]:
    sizes = np.linalg.norm(delta_v, axis=-1)
    return {
        "method": scenario.controller.method,
        "max_delta_v": float(sizes.max()),
        "total_delta_v": float(sizes.sum()),
        "solve_time_median": None if walls is None else float(np.median(walls)),
    }
