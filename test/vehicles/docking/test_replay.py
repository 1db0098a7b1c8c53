"""A replay gives the recorded states and references of a docking flight to another law."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pytest
from docking_bags import ungoverned

from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.scenario import from_sections
from spacecraft_gnc.vehicles.docking.resolve import REPLAY


@pytest.fixture(scope="module")
def flown():
    scenario = from_sections(ungoverned())
    return scenario.build().run(), scenario


def changed(**controller):
    return from_sections({**ungoverned(), "nmpc_controller": controller})


def test_the_same_law_answers_bit_for_bit(flown):
    flight, scenario = flown
    resolved = REPLAY.resolve(flight, scenario, scenario)
    assert resolved.first_difference is None
    assert resolved.steps.tolist() == list(range(10))


@pytest.mark.parametrize(
    "other",
    [{"method": "time_invariant_lqr"}, {"mass": 150.0}, {"weights": {"force": 2.0}}],
    ids=["method", "mass", "weights"],
)
def test_another_law_is_compared_in_numbers(flown, other):
    flight, scenario = flown
    revised = changed(**other)
    resolved = REPLAY.resolve(flight, scenario, revised, steps=(2, 6))
    numbers = REPLAY.compare(resolved, scenario, revised)
    assert numbers["first_difference"] == 2
    off = np.abs(resolved.replayed - resolved.recorded)
    assert numbers["max_force_difference"] == off[:, :3].max() > 0.0
    assert numbers["replayed"]["method"] == revised.controller.method
    assert REPLAY.differences(numbers, 5.0)[0] == ("first difference", "step 2, 10 s")
    assert len(REPLAY.sides(numbers["recorded"], numbers["replayed"])) == 4
    figure = REPLAY.figure(resolved, ("flown", "replayed"), "title")
    assert len(figure.axes) == 6
    plt.close(figure)


def test_another_period_is_refused(flown):
    flight, scenario = flown
    with pytest.raises(ParameterError, match=r"time_step: received 2\.5 s"):
        REPLAY.resolve(flight, scenario, changed(time_step=2.5))
