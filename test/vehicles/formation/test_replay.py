"""A replay gives the recorded states and references of a formation to another law."""

from __future__ import annotations

import json

import matplotlib.pyplot as plt
import numpy as np
import pytest
from formation_bags import ORBIT, SECTIONS, fly, sections

from spacecraft_gnc.cli.main import main
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.recording.bag import open_bag
from spacecraft_gnc.scenario import from_sections
from spacecraft_gnc.vehicles.formation.recorded import read_recorded
from spacecraft_gnc.vehicles.formation.resolve import REPLAY


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    return fly(tmp_path_factory.mktemp("flown"))


@pytest.fixture(scope="module")
def flown(bag):
    scenario = from_sections(SECTIONS)
    with open_bag(bag) as opened:
        return read_recorded(opened, None, scenario).trajectory, scenario


def changed(**controller):
    return from_sections(sections(nmpc_controller=controller))


def test_a_bag_holds_what_was_simulated(bag, flown):
    """The commands of the craft come from their own topics."""
    recorded, scenario = flown
    simulated = scenario.build().run()
    for name, _ in type(recorded).columns():
        if name != "solve_time":
            np.testing.assert_array_equal(getattr(recorded, name), getattr(simulated, name), name)
    with open_bag(bag) as opened:  # the craft by their topics
        unknown = read_recorded(opened, None, None).trajectory
    np.testing.assert_array_equal(unknown.delta_v, recorded.delta_v)


def test_what_is_missing_of_a_bag_is_told(tmp_path):
    bag = fly(tmp_path, late=[(3, 1)], silent=[(5, 0), (6, 0), (6, 1), (6, 2)])
    with open_bag(bag) as opened:
        flight, missing, overridden = read_recorded(opened, None, from_sections(SECTIONS))
    assert missing == {
        "sc1/delta_v_command": (5, 6),
        "sc2/delta_v_command": (6,),
        "sc3/delta_v_command": (6,),
    }
    assert overridden == (3,)
    assert np.isnan(flight.delta_v[5]).any(axis=1).tolist() == [True, False, False]
    assert flight.source.tolist() == [5, 5, 5, 5, 5, 4, -1, 5, 5]


def test_the_same_law_answers_bit_for_bit(flown):
    flight, scenario = flown
    resolved = REPLAY.resolve(flight, scenario, scenario)
    assert resolved.first_difference is None
    assert resolved.steps.tolist() == list(range(9))


def test_other_weights_are_compared_in_numbers(flown):
    flight, scenario = flown
    revised = changed(weights={"delta_v": 400.0})
    resolved = REPLAY.resolve(flight, scenario, revised, steps=(2, 6))
    numbers = REPLAY.compare(resolved, scenario, revised)
    assert numbers["first_difference"] == 2
    off = np.linalg.norm(resolved.replayed - resolved.recorded, axis=-1)
    assert numbers["max_delta_v_difference"] == off.max() > 0.0
    assert numbers["replayed"]["total_delta_v"] < numbers["recorded"]["total_delta_v"]
    rows = REPLAY.sides(numbers["recorded"], numbers["replayed"])
    assert [row[0] for row in rows][:2] == ["method", "largest delta-v"]
    assert REPLAY.differences(numbers, 100.0)[0] == ("first difference", "step 2, 200 s")
    figure = REPLAY.figure(resolved, ("flown", "replayed"), "title")
    assert len(figure.axes) == 3
    plt.close(figure)


def test_another_period_is_refused(flown):
    flight, scenario = flown
    halved = sections(
        nmpc_controller={"time_step": ORBIT / 40}, reference_governor={"phase": [12, 0, 26]}
    )
    with pytest.raises(ParameterError, match=r"time_step: received 137\.307 s"):
        REPLAY.resolve(flight, scenario, from_sections(halved))


def test_the_command_replays_a_bag(bag, capsys):
    arguments = [str(bag), "--method", "lqr", "--set", "nmpc_controller.weights.delta_v=400.0"]
    with pytest.raises(SystemExit) as ended:
        main(["replay", *arguments, "--json"])
    assert not ended.value.code
    numbers = json.loads(capsys.readouterr().out)
    assert numbers["steps"] == 9
    assert numbers["max_delta_v_difference"] > 0.0
