"""Messages of a formation: what goes in comes out, and what does not fit is refused."""

from __future__ import annotations

import numpy as np
import pytest

from spacecraft_gnc.loop.protocols import Command, Source
from spacecraft_gnc.signals import Refused
from spacecraft_gnc.vehicles.formation.decision import Answer, FormationDecision
from spacecraft_gnc.vehicles.formation.signals import (
    COMMAND,
    GOVERNOR_STATUS,
    REFERENCE,
    STATE,
    Motion,
)
from spacecraft_gnc.vehicles.formation.state import FormationReference, FormationState

RNG = np.random.default_rng(18)


def _state(n: int = 3) -> FormationState:
    position, velocity, applied = RNG.normal(size=(3, n, 3))
    return FormationState(7, position, velocity, np.arange(n) > 0, applied)


def _reference(n: int = 3) -> FormationReference:
    return FormationReference(np.arange(n) + 40, *RNG.normal(size=(2, n, 3)))


@pytest.mark.parametrize("n", [2, 3, 5])
def test_a_state_keeps_every_bit(n: int) -> None:
    state = _state(n)
    data = STATE.encode((1, 2), 7, Motion(state, (Source.METHOD,) * n))
    found = STATE.value(STATE.decode(data))
    assert found.step == 7
    for name in ("position", "velocity", "healthy", "applied"):
        np.testing.assert_array_equal(getattr(found, name), getattr(state, name), strict=True)


def test_a_reference_keeps_every_bit() -> None:
    reference = _reference()
    found = REFERENCE.value(REFERENCE.decode(REFERENCE.encode((1, 2), 7, reference)))
    for name in ("shift", "position", "velocity"):
        np.testing.assert_array_equal(getattr(found, name), getattr(reference, name), strict=True)


def test_a_command_keeps_every_bit() -> None:
    delta_v = RNG.normal(size=3)
    data = COMMAND.encode((1, 2), 7, Command(delta_v, Source.ZERO))
    found = COMMAND.value(COMMAND.decode(data))
    assert found.source is Source.ZERO
    np.testing.assert_array_equal(found.control, delta_v)


def test_a_decision_is_told_in_full() -> None:
    decision = FormationDecision(
        _reference(), "time_shift", Answer.PASSAGE, 3.0, 1.0, 2.0, 4, 125000, "separation of a",
        0.25, 7.0, "delta-v of b", -0.5, 12.5, deadlocked=True, waypoint=np.array([1, 2, 3]),
        passages_left=2, lost=np.array([False, True, False]),
        response=np.array([1.0, np.nan, 0.5]), formed=False, decision_time=1e-3,
    )  # fmt: skip
    message = GOVERNOR_STATUS.read(GOVERNOR_STATUS.encode((1, 2), 7, decision))
    assert message["law"] == "time_shift"
    assert message["status"] == Answer.PASSAGE
    assert list(message["waypoint"]) == [1, 2, 3]
    assert list(message["lost"]) == [False, True, False]
    assert [message[name] for name in ("cost", "shift_cost", "state_cost")] == [3.0, 1.0, 2.0]
    assert (message["n_admissible"], message["n_candidates"]) == (4, 125000)
    assert (message["margin"], message["refused_margin"], message["error"]) == (0.25, -0.5, 12.5)
    assert (message["deadlocked"], message["passages_left"], message["formed"]) == (True, 2, False)


@pytest.mark.parametrize(("signal", "name"), [(STATE, "velocity"), (REFERENCE, "position")])
def test_lists_of_another_number_of_craft_are_refused(signal: object, name: str) -> None:
    three = _state() if signal is STATE else _reference()
    torn = three._replace(**{name: np.zeros((2, 3))})
    value = Motion(torn, (Source.METHOD,) * 3) if signal is STATE else torn  # type: ignore[arg-type]
    data = signal.encode((0, 0), 0, value)  # type: ignore[attr-defined]
    message = signal.decode(data)  # type: ignore[attr-defined]
    with pytest.raises(Refused, match=f"{name} holds 6 numbers; required 3 for each of 3 craft"):
        signal.value(message)  # type: ignore[attr-defined]
