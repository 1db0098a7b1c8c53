"""What an audit starts from: the recorded topics by step, and the scenario that flew."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.analysis.reader import acted, whole_steps
from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.recording.bag import Bag
from spacecraft_gnc.recording.columns import Columns, iter_columns, read_columns
from spacecraft_gnc.recording.metadata import RECOVERED_RECORD
from spacecraft_gnc.recording.steps import (
    ACCEPTED_TARGET,
    GOVERNOR_STATUS,
    INVARIANTS,
    REFERENCE,
    SOLVER_STATUS,
    STATE,
    TORQUE,
    WALL_TIMING,
    flight_namespace,
)
from spacecraft_gnc.scenario import Scenario
from spacecraft_gnc.scenario.recorded import SCENARIO_ATTACHMENT, parse_scenario, scenario_texts
from spacecraft_gnc.types import Array

PLANS: Final = ("predicted_attitudes", "predicted_momenta", "predicted_torques")
KEPT: Final = (
    STATE, INVARIANTS, REFERENCE, GOVERNOR_STATUS, ACCEPTED_TARGET, TORQUE, WALL_TIMING,
)  # fmt: skip
LEADING: Final = (STATE, INVARIANTS)
"""Topics that tell of the end of the last step, too."""
_SHAPES: Final = {
    "attitude": (9,),
    "angular_momentum": (3,),
    "angular_velocity": (3,),
    "torque": (3,),
    "applied_torque": (3,),
}
"""Shape of a field of which no message was recorded; any other is a number."""

Progress = Callable[[int, int], None]


@dataclass(frozen=True, slots=True)
class Evidence:
    """A recorded flight, read for an audit.

    Attributes
    ----------
    path
        The bag.
    scenario
        What flew, as recorded.
    columns
        Every topic but the plans of the solver, which `plans` yields.
    n
        Control steps flown.
    unfinished
        Whether the bag was cut off, and read as far as it goes.
    recovered
        Whether it was cut off and `gnc recover` made it whole.
    """

    path: Path
    scenario: Scenario
    columns: dict[str, Columns]
    n: int
    unfinished: bool
    recovered: bool
    bag: Bag
    namespace: str | None

    def rows(self, topic: str, name: str, steps: NDArray[np.int64]) -> Array:
        """Return values of a field (m, ...) at steps (m,); NaN where one was not recorded."""
        columns = self.columns[topic]
        values = columns.fields.get(name, np.empty((0, *_SHAPES.get(name, ()))))
        found = np.full((len(steps), *values.shape[1:]), np.nan)
        places = np.searchsorted(columns.steps, steps)
        there = places < columns.steps.size
        there[there] = columns.steps[places[there]] == steps[there]
        found[there] = values[places[there]]
        return found

    def common(self, *topics: str) -> NDArray[np.int64]:
        """Return the steps that all of these topics hold."""
        steps = self.columns[topics[0]].steps
        for topic in topics[1:]:
            steps = np.intersect1d(steps, self.columns[topic].steps, assume_unique=True)
        return steps

    def solves(self, progress: Progress | None = None) -> Iterator[Columns]:
        """Yield the solver's messages, some thousand at a time."""
        for _, block in iter_columns(self.bag, [SOLVER_STATUS], self.namespace, progress):
            yield block


def read_evidence(
    bag: Bag, namespace: str | None, progress: Progress | None, *, stopped: bool = False
) -> Evidence:
    """Read what an audit needs, but for the plans; a flight that was ``stopped`` has loose ends.

    Raises
    ------
    RecordingError
        If the bag is no flight of one spacecraft, or holds no scenario that this version reads.
    """
    columns = read_columns(bag, [*KEPT, SOLVER_STATUS], namespace, progress, leave_out=PLANS)
    whole_steps(bag, columns, acted(columns))  # refuses what is no flight
    text, defaults = scenario_texts(bag.attachments())
    name = flight_namespace(bag, namespace)
    scenario, problem = parse_scenario(text, bag.path, name, defaults)
    if scenario is None:
        reason = problem or "none is attached"
        raise RecordingError(
            f"{bag.path}: received no scenario to audit by ({reason}); required the attachment "
            f"{SCENARIO_ATTACHMENT} of `gnc launch`, in this version's form; read it with the "
            "version that flew"
        )
    recovered = RECOVERED_RECORD in bag.metadata()
    n = _flown(columns, bag.unfinished or recovered or stopped)
    return Evidence(bag.path, scenario, columns, n, bag.unfinished, recovered, bag, namespace)


def _flown(columns: dict[str, Columns], cut: bool) -> int:
    """Return the control steps flown: up to the last message; in a cut bag, to the last whole one.

    The governor answers the last state, too, of which no control step starts.
    """
    topics = (STATE, INVARIANTS, TORQUE, SOLVER_STATUS)
    ends = [
        int(columns[topic].steps[-1]) + (topic not in LEADING)
        for topic in (*topics, *((REFERENCE, GOVERNOR_STATUS) if cut else ()))
        if columns[topic].steps.size
    ]
    return (min if cut else max)(ends)
