"""Plans that a bag tells of, as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import zip_longest
from typing import NamedTuple

import numpy as np

from spacecraft_gnc.recording.columns import Columns
from spacecraft_gnc.types import Array


class RecordedPlan(NamedTuple):
    """A plan of N steps that was taken in flight; `msg/AttitudePlan` says what its arrays are."""

    number: int
    first_step: int
    """Control step at which it starts."""
    cause: int
    """`governors.planned.report.Cause`."""
    cost: float
    """Sum of |u|^2 / 2 [N^2 m^2]."""
    torque: Array
    """(N, 3) [N m]."""
    momentum: Array
    """(N + 1, 3) [N m s]."""
    co_momentum: Array
    """(N, 3) [N m]; its negative is the torque where no bound acts."""
    torque_multipliers: Array
    """(N, 3) [N m]."""
    momentum_multipliers: Array
    """(N + 1, 3) [N m/s]."""


def as_flown(plans: Sequence[RecordedPlan], name: str) -> tuple[Array, Array]:
    """Return an array of plans, each up to the next one's start: steps (m,) and values (m, 3).

    A row of NaN stands between two of them.
    """
    steps, values = [np.empty(0)], [np.empty((0, 3))]
    for plan, after in zip_longest(plans, plans[1:]):
        planned: Array = getattr(plan, name)
        n = len(planned) if after is None else after.first_step - plan.first_step
        steps.append(plan.first_step + np.arange(len(planned[:n]) + 1.0))
        values += [planned[:n], np.full((1, 3), np.nan)]
    return np.concatenate(steps), np.concatenate(values)


def plans_of(columns: Columns) -> tuple[RecordedPlan, ...]:
    """Return the plans in the order in which they were taken."""
    fields = columns.fields
    return tuple(_plan({name: values[i] for name, values in fields.items()}) for i in
                 range(columns.steps.size))  # fmt: skip


def _plan(fields: dict[str, Array]) -> RecordedPlan:
    return RecordedPlan(
        number=int(fields["number"]),
        first_step=int(fields["first_step"]),
        cause=int(fields["cause"]),
        cost=float(fields["cost"]),
        torque=_vectors(fields["torques"]),
        momentum=_vectors(fields["momenta"]),
        co_momentum=_vectors(fields["co_momenta"]),
        torque_multipliers=_vectors(fields["torque_multipliers"]),
        momentum_multipliers=_vectors(fields["momentum_multipliers"]),
    )


def _vectors(values: Array) -> Array:
    """Return a sequence as (n, 3), without what pads it to the longest plan's."""
    return np.asarray(values[np.isfinite(values)].reshape(-1, 3))
