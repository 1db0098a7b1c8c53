"""Warning of a free run that misses most of its deadlines."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from spacecraft_gnc.scenario import Scenario

_MANY: Final = 0.5  # share of the steps
_PATIENCE: Final = 3.0  # [s] wall: a graph that has just started may miss the first ones


def misses_most(missed: int, steps: int) -> bool:
    """Tell whether so many missed deadlines are most of them."""
    return steps > 0 and missed > _MANY * steps


def lateness(missed: int, steps: int, wall_elapsed: float, scenario: Scenario) -> str:
    """Return one line on a flight that flies without its controller; empty where it does not.

    Parameters
    ----------
    missed, steps
        Deadlines missed in so many control steps.
    wall_elapsed
        Since step 0 [s]; infinite when the flight is over.
    scenario
        What flies.
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
