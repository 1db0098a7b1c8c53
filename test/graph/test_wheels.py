"""Two wheels left, and a wheel lost in flight: graphs of processes, their bags and their audits."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from graph.comparison import CASE1, assert_equals_simulation
from rosbags.highlevel import AnyReader

from spacecraft_gnc.analysis.audit import audit_bag
from spacecraft_gnc.analysis.reader import read_flight
from spacecraft_gnc.vehicles.two_wheel.controllers.report import Mode, Rest

pytestmark = pytest.mark.graph

LOST_AT, NOTICED_WITHIN = 10, 3  # control steps
WHEELS = {
    "afrl_two_wheel": (2, None, Mode.NOMINAL),
    "afrl_wheel_loss": (3, 2, Mode.UNDERACTUATED),
    "afrl_wheel_loss_pyramid": (4, 0, Mode.REALLOCATED),
}
"""Number of wheels, the one that is lost, and how the flight ends."""


def messages(bag: Path, topic: str) -> list[Any]:
    """Return the messages of a topic in order."""
    with AnyReader([bag]) as reader:
        wanted = [c for c in reader.connections if c.topic == topic]
        return [reader.deserialize(raw, c.msgtype) for c, _, raw in reader.messages(wanted)]


LONG = pytest.mark.long
PYRAMID = "afrl_wheel_loss_pyramid"


@pytest.fixture(
    params=[name if name != PYRAMID else pytest.param(name, marks=LONG) for name in WHEELS]
)
def flown(request: Any, graph: Any) -> tuple[str, Path]:
    """A scenario, and the run of its four processes."""
    out = graph.fly(scenario=CASE1.parent / f"{request.param}.yaml")
    assert graph.exit_codes == dict.fromkeys(
        ("plant", "nmpc_controller", "reference_governor", "recorder"), 0
    )
    return request.param, out


def test_a_flight_is_that_of_simulate_and_its_audit_passes(flown: tuple[str, Path]) -> None:
    name, out = flown
    assert_equals_simulation(out / "bag", scenario=CASE1.parent / f"{name}.yaml")
    audit = audit_bag(out)
    assert audit.passed, audit.first
    flight: Any = read_flight(out / "bag").trajectory
    assert len(messages(out / "bag", "/wheel_solver_status")) == flight.n_steps
    assert np.abs(flight.wheel_speed).max() <= 100.0
    assert np.abs(flight.wheel_acceleration).max() <= 5.0
    assert np.abs(np.diff(flight.total_momentum, axis=0)).max() == 0.0
    told = messages(out / "bag", "/wheel_diagnosis")
    n_wheels, lost, mode = WHEELS[name]
    assert flight.wheel_speed.shape == (flight.n_steps, n_wheels)
    assert len(told) == flight.n_steps
    if lost is None:  # the method watches no wheel
        assert all(message.healthy.all() and message.mode == mode for message in told)
        assert np.isnan([message.residual for message in told]).all()
    else:
        require_diagnosis(told, flight, lost, mode)


def require_diagnosis(told: list[Any], flight: Any, lost: int, mode: Mode) -> None:
    """Check that the loss is noticed in time, once, and that no other wheel is blamed."""
    healthy = np.array([message.healthy for message in told])
    noticed = np.flatnonzero(~healthy[:, lost])
    assert LOST_AT < noticed[0] <= LOST_AT + NOTICED_WITHIN
    assert not healthy[noticed[0] :, lost].any()
    assert np.delete(healthy, lost, axis=1).all()
    np.testing.assert_array_equal(healthy, flight.diagnosed)
    assert [message.mode for message in told] == [
        mode if k >= noticed[0] else Mode.NOMINAL for k in range(len(told))
    ]
    assert told[-1].rest == Rest.AT_TARGET
    assert abs(told[noticed[0]].residual[lost]) > told[noticed[0]].threshold[lost]
    assert told[-1].pointing_loss < np.radians(0.6)
