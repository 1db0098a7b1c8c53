"""Signals of a formation: state, reference, the command of each craft, the governor's account."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np

from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.signals import ANY, Field, Message, Refused, Rule, Signal
from spacecraft_gnc.signals.applied import Applied
from spacecraft_gnc.signals.graph import CONTROL, CONTROLLER, GOVERNOR, GUIDANCE, MOTION, PLANT
from spacecraft_gnc.signals.rules import INFINITE
from spacecraft_gnc.signals.structures import VECTOR3
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation.decision import Answer, FormationDecision
from spacecraft_gnc.vehicles.formation.state import FormationReference, FormationState

HILL_FRAME: Final = "hill"
_SOURCE: Final = Rule(most=max(Source))
_SOURCES: Final = tuple(Source)


class Impulse(NamedTuple):
    """Change of velocity of one craft as commanded."""

    control: Array
    """(3,) Hill frame [m/s]."""
    source: Source


class Motion(NamedTuple):
    """A state, and where the impulses of the step before it came from."""

    state: FormationState
    sources: tuple[Source, ...]
    """Of each craft."""


def _pack_motion(motion: Motion) -> tuple[Any, ...]:
    state, sources = motion
    return (
        state.position.ravel(),
        state.velocity.ravel(),
        state.healthy,
        state.applied.ravel(),
        [int(source) for source in sources],
    )


def _unpack_state(message: Message) -> FormationState:
    healthy = np.array(message["healthy"], dtype=bool)
    position, velocity, applied = (
        _by_craft(message, name, healthy.size)
        for name in ("position", "velocity", "applied_delta_v")
    )
    return FormationState(message.step, position, velocity, healthy, applied)


def _pack_command(command: Any) -> tuple[Any, ...]:
    return command.control, int(command.source)


def _unpack_command(message: Message) -> Impulse:
    return Impulse(message.array("delta_v"), _SOURCES[message["source"]])


def _pack_reference(reference: FormationReference) -> tuple[Any, ...]:
    return reference.shift, reference.position.ravel(), reference.velocity.ravel()


def _unpack_reference(message: Message) -> FormationReference:
    shift = np.array(message["shift"], dtype=np.int64)
    position, velocity = (_by_craft(message, name, shift.size) for name in ("position", "velocity"))
    return FormationReference(shift, position, velocity)


def _by_craft(message: Message, name: str, n: int) -> Array:
    """Return the numbers of a field (n, 3).

    Raises
    ------
    Refused
        If there are not 3 for each craft.
    """
    numbers = message.array(name)
    if numbers.size != 3 * n:
        raise Refused(f"{name} holds {numbers.size} numbers; required 3 for each of {n} craft")
    return numbers.reshape(n, 3)


def _pack_decision(decision: FormationDecision) -> tuple[Any, ...]:
    return (
        decision.law,
        int(decision.answer),
        decision.cost,
        decision.shift_cost,
        decision.state_cost,
        decision.n_admissible,
        decision.n_candidates,
        decision.constraint,
        decision.margin,
        decision.constraint_ahead,
        decision.refused,
        decision.refused_margin,
        decision.error,
        decision.deadlocked,
        decision.waypoint,
        decision.passages_left,
        decision.lost,
        decision.response,
        decision.formed,
        decision.decision_time,
    )


STATE: Final = Signal(
    name="hill_state",
    type="spacecraft_gnc_msgs/msg/HillState",
    fields={
        "position": Field("float64[]", "m"),
        "velocity": Field("float64[]", "m/s"),
        "healthy": Field("bool[]"),
        "applied_delta_v": Field("float64[]", "m/s"),
        "applied_source": Field("uint8[]", "-"),
    },
    publishers=(PLANT,),
    subscribers=(CONTROLLER, GOVERNOR),
    frame=HILL_FRAME,
    unique=True,
    rank=MOTION,
    pack=_pack_motion,
    unpack=_unpack_state,
)
REFERENCE: Final = Signal(
    name="formation_reference",
    type="spacecraft_gnc_msgs/msg/FormationReference",
    fields={
        "shift": Field("uint32[]", "control steps"),
        "position": Field("float64[]", "m"),
        "velocity": Field("float64[]", "m/s"),
    },
    publishers=(GOVERNOR,),
    subscribers=(CONTROLLER,),
    frame=HILL_FRAME,
    rank=GUIDANCE,
    pack=_pack_reference,
    unpack=_unpack_reference,
)
COMMAND: Final = Signal(
    name="delta_v_command",
    type="spacecraft_gnc_msgs/msg/DeltaVCommand",
    fields={"delta_v": Field(VECTOR3, "m/s"), "source": Field("uint8", "-", _SOURCE)},
    publishers=(CONTROLLER,),
    subscribers=(PLANT,),
    of_craft=True,
    frame=HILL_FRAME,
    rank=CONTROL,
    pack=_pack_command,
    unpack=_unpack_command,
)
GOVERNOR_STATUS: Final = Signal(
    name="time_shift_status",
    type="spacecraft_gnc_msgs/msg/TimeShiftStatus",
    fields={
        "law": Field("string"),
        "status": Field("uint8", "-", Rule(most=max(Answer))),
        "cost": Field("float64", "-", ANY),
        "shift_cost": Field("float64", "-", ANY),
        "state_cost": Field("float64", "-", ANY),
        "n_admissible": Field("int64", "-"),
        "n_candidates": Field("int64", "-"),
        "constraint": Field("string"),
        "margin": Field("float64", "-", INFINITE),
        "constraint_ahead": Field("float64", "control steps"),
        "refused": Field("string"),
        "refused_margin": Field("float64", "-", INFINITE),
        "error": Field("float64", "m", ANY),
        "deadlocked": Field("bool"),
        "waypoint": Field("uint32[]", "control steps"),
        "passages_left": Field("int32", "-"),
        "lost": Field("bool[]"),
        "response": Field("float64[]", "-", ANY),
        "formed": Field("bool"),
        "wall_decision_time": Field("float64", "s", ANY),
    },
    publishers=(GOVERNOR,),
    frame=HILL_FRAME,
    rank=GUIDANCE + 1,
    pack=_pack_decision,
)
APPLIED: Final = Applied(STATE, "applied_delta_v", "applied_source", COMMAND, "delta_v")
SIGNALS: Final = (STATE, REFERENCE, COMMAND, GOVERNOR_STATUS)
