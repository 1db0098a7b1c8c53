"""Record of a flight in formation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from spacecraft_gnc.loop.flight import Flight, Step, column, final
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation.geometry import communication_angles_deg, separations


def _angles(step: Step) -> Array:
    return communication_angles_deg(step.state.position, step.decision.reference.position)


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class FormationFlight(Flight):
    """Arrays of a flight of m craft: row k belongs to control step k, ``final_*`` to the end.

    Pairs of craft are in the order 12, 13, ..., 23, ...

    Attributes
    ----------
    position, velocity : (n, m, 3) arrays
        At the start of the step, before its impulses, Hill's frame [m], [m/s].
    delta_v : (n, m, 3) array
        Change of velocity commanded at the start of the step, Hill's frame [m/s]; a craft that is
        not ``healthy`` makes none.
    time_shift : (n, m) array of int
        Shift of each craft along the natural trajectory [control steps]; -1: not known.
    reference_position, reference_velocity : (n, m, 3) arrays
        States that the craft are to track.
    separation : (n, pairs) array
        Distance of each pair at the start of the step [m].
    communication_angle_deg : (n, pairs) array
        Angle of each pair, between where the other craft is and where it should be [deg].
    healthy, lost : (n, m) arrays of bool
        Whether each craft answers its command, and whether the governor concluded that it is lost.
    status, source : (n,) arrays of int
        `decision.Answer` of the governor; `loop.Source` of the commands, ZERO where one is missing.
    iterations : (n,) array of int
        Candidates among which the governor chose.
    residual : (n,) array
        Largest distance of a craft from its commanded position, lost ones left out [m].
    solve_time : (n,) array
        Wall time of the governor's decision [s].
    cost, shift_cost, state_cost : (n,) arrays
        Of the shifts chosen, and its parts; NaN: not chosen by it.
    n_admissible : (n,) array of int
        Candidates that keep every constraint.
    governor_margin : (n,) array
        Least room along the prediction, as a share of the limit; infinite: there is none.
    deadlocked, formed : (n,) arrays of bool
        What the governor finds: parked in another formation; in the desired one.
    final_position, final_velocity : (m, 3) arrays
        State at the end of the flight.
    """

    position: Array = column("state.position", (-1, 3), carried_by="hill_state/position")
    velocity: Array = column("state.velocity", (-1, 3), carried_by="hill_state/velocity")
    delta_v: Array = column("command.control", (-1, 3))
    time_shift: NDArray[Any] = column(
        "decision.reference.shift", (-1,), carried_by="formation_reference/shift", missing=-1
    )
    reference_position: Array = column(
        "decision.reference.position", (-1, 3), carried_by="formation_reference/position"
    )
    reference_velocity: Array = column(
        "decision.reference.velocity", (-1, 3), carried_by="formation_reference/velocity"
    )
    separation: Array = column(lambda step: separations(step.state.position), (-1,))
    communication_angle_deg: Array = column(_angles, (-1,))
    healthy: NDArray[Any] = column(
        "state.healthy", (-1,), carried_by="hill_state/healthy", missing=True
    )
    lost: NDArray[Any] = column(
        "decision.watched", (-1,), carried_by="time_shift_status/lost", missing=False
    )
    status: NDArray[Any] = column(
        "decision.answer", carried_by="time_shift_status/status", missing=-1
    )
    source: NDArray[Any] = column("command.source", missing=-1)
    iterations: NDArray[Any] = column(
        "decision.n_candidates", carried_by="time_shift_status/n_candidates", missing=0
    )
    residual: Array = column("decision.error", carried_by="time_shift_status/error")
    solve_time: Array = column(
        "decision.decision_time", carried_by="time_shift_status/wall_decision_time"
    )
    cost: Array = column("decision.cost", carried_by="time_shift_status/cost")
    shift_cost: Array = column("decision.shift_cost", carried_by="time_shift_status/shift_cost")
    state_cost: Array = column("decision.state_cost", carried_by="time_shift_status/state_cost")
    n_admissible: NDArray[Any] = column(
        "decision.n_admissible", carried_by="time_shift_status/n_admissible", missing=0
    )
    governor_margin: Array = column("decision.margin", carried_by="time_shift_status/margin")
    deadlocked: NDArray[Any] = column(
        "decision.deadlocked", carried_by="time_shift_status/deadlocked", missing=False
    )
    formed: NDArray[Any] = column(
        "decision.formed", carried_by="time_shift_status/formed", missing=False
    )
    final_position: Array = final("state.position", (-1, 3), carried_by="hill_state/position")
    final_velocity: Array = final("state.velocity", (-1, 3), carried_by="hill_state/velocity")

    @property
    def n_craft(self) -> int:
        """Number of craft."""
        return int(self.position.shape[1])

    def __repr__(self) -> str:
        """Return the flight in one line."""
        return (
            f"Flight({self.n_steps} steps of {self.period:g} s, "
            f"{self.n_steps * self.period:g} s in all, {self.n_craft} craft)"
        )
