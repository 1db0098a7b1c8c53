"""Record of a docking flight."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from spacecraft_gnc.loop.flight import Flight, column, final
from spacecraft_gnc.types import Array


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class DockingFlight(Flight):
    """Arrays of a flight: row k belongs to control step k, ``final_*`` to the end of the last step.

    Attributes
    ----------
    port_offset, port_velocity : (n, 3) arrays
        Deputy port minus chief port, and its rate of change seen there, chief frame [m], [m/s].
    attitude : (n, 3, 3) array
        Rotation, deputy to chief.
    angular_velocity : (n, 3) array
        Of the deputy relative to the chief, chief frame [rad/s].
    measured_port_offset, measured_port_velocity, measured_attitude, measured_angular_velocity
        The same as navigation tells them.
    force, moment : (n, 3) arrays
        Commanded, chief frame [N], about the deputy's center of mass [N m].
    reference, target : (n, 6) arrays
        Port offset [m] and rotation vector [rad] tracked, and those that the governor is asked for.
    line_of_sight_margin, clearance : (n,) arrays
        Least over the control step that ended at the start of this one [m]; of row 0: at the start.
    thrusters : (n, 6) array of bool
        Whether each of `state.DIRECTIONS` answers.
    status, source, iterations : (n,) arrays of int
        `decision.Answer` of the governor, `loop.Source` of the command, the governor's iterations.
    residual : (n,) array
        Largest violation of the optimality conditions of the governor's program; NaN: no solve.
    solve_time : (n,) array
        Wall time of the governor's decision [s].
    slack : (n,) array
        Smallest slack of a row of the admissible set, as a share of the row's room when docked.
    phase, lost_thruster : (n,) arrays of int
        `decision.Phase`; index of the direction concluded lost, -1: none.
    response_error : (n,) array
        Change of velocity over the last step less the one foretold [m/s]; NaN: not known.
    final_port_offset, final_port_velocity, final_attitude, final_angular_velocity : arrays
        State at the end of the flight.
    final_line_of_sight_margin, final_clearance : arrays of shape ()
        Least over the last step [m].
    """

    port_offset: Array = column("state.port_offset", (3,), carried_by="relative_state/port_offset")
    port_velocity: Array = column(
        "state.port_velocity", (3,), carried_by="relative_state/port_velocity"
    )
    attitude: Array = column("state.attitude", (3, 3), carried_by="relative_state/attitude")
    angular_velocity: Array = column(
        "state.angular_velocity", (3,), carried_by="relative_state/angular_velocity"
    )
    measured_port_offset: Array = column(
        "state.measured.port_offset", (3,), carried_by="relative_state/measured_port_offset"
    )
    measured_port_velocity: Array = column(
        "state.measured.port_velocity", (3,), carried_by="relative_state/measured_port_velocity"
    )
    measured_attitude: Array = column(
        "state.measured.attitude", (3, 3), carried_by="relative_state/measured_attitude"
    )
    measured_angular_velocity: Array = column(
        "state.measured.angular_velocity",
        (3,),
        carried_by="relative_state/measured_angular_velocity",
    )
    force: Array = column(lambda step: step.command.control[:3], (3,))
    moment: Array = column(lambda step: step.command.control[3:], (3,))
    reference: Array = column("decision.reference.vector", (6,))
    target: Array = column("target.vector", (6,))
    line_of_sight_margin: Array = column(
        "state.line_of_sight_margin", carried_by="relative_state/line_of_sight_margin"
    )
    clearance: Array = column("state.clearance", carried_by="relative_state/clearance")
    thrusters: NDArray[Any] = column(
        "state.thrusters", (6,), carried_by="relative_state/thrusters", missing=True
    )
    status: NDArray[Any] = column(
        "decision.answer", carried_by="periodic_governor_status/status", missing=-1
    )
    source: NDArray[Any] = column("command.source", carried_by="wrench_command/source", missing=-1)
    iterations: NDArray[Any] = column(
        "decision.iterations", carried_by="periodic_governor_status/iterations", missing=0
    )
    residual: Array = column("decision.residual", carried_by="periodic_governor_status/residual")
    solve_time: Array = column(
        "decision.decision_time", carried_by="periodic_governor_status/wall_decision_time"
    )
    slack: Array = column("decision.slack", carried_by="periodic_governor_status/slack")
    phase: NDArray[Any] = column(
        "decision.phase", carried_by="periodic_governor_status/phase", missing=-1
    )
    lost_thruster: NDArray[Any] = column(
        "decision.lost_thruster", carried_by="periodic_governor_status/lost_thruster", missing=-1
    )
    response_error: Array = column(
        "decision.response_error", carried_by="periodic_governor_status/response_error"
    )
    final_port_offset: Array = final(
        "state.port_offset", (3,), carried_by="relative_state/port_offset"
    )
    final_port_velocity: Array = final(
        "state.port_velocity", (3,), carried_by="relative_state/port_velocity"
    )
    final_attitude: Array = final("state.attitude", (3, 3), carried_by="relative_state/attitude")
    final_angular_velocity: Array = final(
        "state.angular_velocity", (3,), carried_by="relative_state/angular_velocity"
    )
    final_line_of_sight_margin: Array = final(
        "state.line_of_sight_margin", carried_by="relative_state/line_of_sight_margin"
    )
    final_clearance: Array = final("state.clearance", carried_by="relative_state/clearance")

    def __repr__(self) -> str:
        """Return the flight in one line."""
        return (
            f"Flight({self.n_steps} steps of {self.period:g} s, "
            f"{self.n_steps * self.period:g} s in all, docking)"
        )
