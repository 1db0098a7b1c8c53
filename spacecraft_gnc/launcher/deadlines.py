"""Warning of a free run that misses most of its deadlines."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from spacecraft_gnc.scenario import Scenario

_MANY: Final = 0.5  # fraction of the steps
_PATIENCE: Final = 3.0  # [s] wall: a graph may miss the first deadlines after its start


def misses_most(missed: int, steps: int) -> bool:
    """Tell whether most of the deadlines were missed."""
    return steps > 0 and missed > _MANY * steps


def lateness(missed: int, steps: int, wall_elapsed: float, scenario: Scenario) -> str:
    """Return a one-line warning if the controller misses most deadlines; otherwise an empty text.

    Parameters
    ----------
    missed, steps
        Missed deadlines and control steps.
    wall_elapsed
        Since step 0 [s]; infinite when the flight is over.
    scenario
        The scenario that flies.
    """
    plant = scenario.plant
    settled = wall_elapsed >= _PATIENCE
    if plant.mode != "free_run" or not settled or not misses_most(missed, steps):
        return ""
    due = 1e3 * scenario.period / plant.real_time_factor
    return (
        f"plant.real_time_factor: {missed} of {steps} torques came after their deadline, and the "
        f"plant flew held or zero torque instead; required one within {due:.3g} ms, the control "
        f"period at {plant.real_time_factor:g} times real time; lower --rate, or fly with --mode "
        "lockstep, which waits"
    )
