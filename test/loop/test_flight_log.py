"""The log copies values step by step, whatever becomes of the objects that it read them of."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from spacecraft_gnc import scenario
from spacecraft_gnc.errors import ParameterError, RecordingError
from spacecraft_gnc.loop import Command, Source
from spacecraft_gnc.loop.flight import End, Flight, Moment, Step, column, final
from spacecraft_gnc.loop.flight_log import FlightLog
from spacecraft_gnc.types import Array

NAN = np.nan


@dataclass(frozen=True, slots=True, kw_only=True)
class Logged(Flight):
    speed: Array = column("state.speed", (2,))
    wheels: Array = column("state.wheels", (-1,))
    force: Array = column("command.control")
    source: Array = column("command.source", missing=-1)
    residual: Array = column("residual", of=lambda step: step.command.report)
    iterations: Array = column("iterations", of=lambda step: step.command.report, missing=0)
    twice: Array = column(lambda step: 2 * step.target)
    drag: Array = column("drag", moment=Moment.OUTCOME)
    final_speed: Array = final("state.speed", (2,))


def test_values_of_reused_buffers_are_copied_before_the_plant_steps():
    speed = np.zeros(2)  # one buffer for all states
    state = SimpleNamespace(speed=speed, wheels=None)
    log = FlightLog(Logged, 3, 0.5)
    reports = (None, SimpleNamespace(residual=0.25, iterations=4), None)
    for k, report in enumerate(reports):
        state.wheels = np.full(3, k) if k else None
        log.add(k, Step(state, float(k), None, Command(1.5 * k, Source.METHOD, report)))
        speed += 1.0
        log.add_outcome(k, SimpleNamespace(drag=-1.0 * k))
    flight = log.finish(End(state, None))
    np.testing.assert_array_equal(flight.time, [0.0, 0.5, 1.0])
    np.testing.assert_array_equal(flight.speed, [[0, 0], [1, 1], [2, 2]])
    np.testing.assert_array_equal(flight.wheels, [[NAN] * 3, [1] * 3, [2] * 3])
    np.testing.assert_array_equal(flight.force, [0.0, 1.5, 3.0])
    np.testing.assert_array_equal(flight.source, [Source.METHOD] * 3)
    np.testing.assert_array_equal(flight.residual, [NAN, 0.25, NAN])
    np.testing.assert_array_equal(flight.iterations, [0, 4, 0])
    np.testing.assert_array_equal(flight.twice, [0.0, 2.0, 4.0])
    np.testing.assert_array_equal(flight.drag, [0.0, -1.0, -2.0])
    np.testing.assert_array_equal(flight.final_speed, [3, 3])
    assert flight.iterations.dtype == flight.source.dtype == np.int64


def test_only_a_dotted_attribute_is_a_name():
    @dataclass(frozen=True, slots=True, kw_only=True)
    class Odd(Flight):
        speed: Array = column("state.speed[0]")

    with pytest.raises(ParameterError, match=r"column speed: received .*; required a dotted"):
        FlightLog(Odd, 1, 1.0)


def test_a_file_of_before_a_column_existed_is_read(tmp_path):
    """The scenario without disturbances of a file written before they could be listed."""
    flight = scenario.load("gupta2015_case1", ("plant.duration=4.0",)).build().run()
    now = flight.save(tmp_path / "now.npz")
    with np.load(now) as members:
        arrays = {name: members[name] for name in members.files if name != "external_torque"}
    before = tmp_path / "before.npz"
    np.savez(before, **arrays)
    assert (type(flight).load(before).external_torque == np.zeros((10, 3))).all()
    del arrays["attitude"]
    np.savez(before, **arrays)
    with pytest.raises(RecordingError, match="attitude"):
        type(flight).load(before)
