"""Traits of the control methods: what each one reads, and what its flights can tell.

A controller class declares them as its attribute ``traits``; one that declares nothing has those of
`MethodTraits()`. The built-in ones stand here, so that a scenario is checked without a solver.
"""

from __future__ import annotations

from typing import Final, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.loop.protocols import Source

_Number = TypeVar("_Number", np.int64, np.float64)


class MethodTraits(NamedTuple):
    """What is to be known of a method without building it."""

    reads: frozenset[str] = frozenset()
    """Parameters of ``nmpc_controller`` that it reads beside those that every method reads, such as
    ``horizon`` and ``weights.stage_attitude``; what is not read is neither shown nor priced."""
    variants: tuple[str, ...] = ()
    """Words that ``variant`` may be; empty where the method has no variants."""
    memoryless: bool = False
    """Whether a command without a solve follows from state and reference alone, so that an audit
    may ask for it once more."""
    refuses_starts: bool = False
    """Whether it refuses some starts when it is built."""
    hard_limits: bool = False
    """Whether its limits are constraints of its solve: its cost then leaves the penalties out."""
    former_source: Source | None = None
    """What `Source.METHOD` was called in its flights before that source existed."""

    def current_sources(self, sources: NDArray[_Number]) -> NDArray[_Number]:
        """Return the sources (n,) of a flight as this version numbers them."""
        current = sources.copy()
        if self.former_source is not None:
            current[sources == self.former_source] = Source.METHOD
        return current


_OPTIMAL: Final = frozenset(
    {
        "weights.stage_attitude",
        "weights.stage_torque",
        "horizon",
        "residual_tolerance",
        "max_iterations",
    }
)
_PENALISED: Final = _OPTIMAL | {
    "weights.stage_momentum",
    "weights.terminal_attitude",
    "weights.terminal_momentum",
    "torque_penalty",
    "actuators",
    "standstill_error_deg",
}
_NEWTON: Final = _PENALISED | {"formulation", "step_rule", "damping", "continuation"}
SHOOTING: Final = MethodTraits(_NEWTON, ("exact", "estimated_du", "estimated_u"))
NEIGHBORING_EXTREMAL: Final = MethodTraits(
    _NEWTON
    | {
        "nominal_rotation_vector",
        "nominal_momentum",
        "exact_every",
        "ne_tolerance",
        "ne_max_age",
    }
)
SLSQP: Final = MethodTraits(_PENALISED, hard_limits=True)
FSOLVE: Final = MethodTraits(_PENALISED)
TERMINAL_SET: Final = MethodTraits(
    _OPTIMAL | {"terminal_set", "stage_cost_scale", "weights.stage_rate"}, refuses_starts=True
)
FEEDBACK: Final = MethodTraits(
    frozenset({"feedback_attitude_gain", "feedback_momentum_gain"}),
    memoryless=True,
    former_source=Source.FEEDBACK,
)
