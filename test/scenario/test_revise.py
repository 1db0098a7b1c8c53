"""A scenario for another controller along a flight."""

from __future__ import annotations

from pathlib import Path

import pytest

from spacecraft_gnc.scenario import InvalidScenario, load, revise

CONFIG = Path(__file__).parents[2] / "config"


def recorded(name, **overrides):
    return load(CONFIG / f"{name}.yaml", overrides)


def test_nothing_asked_nothing_changed():
    scenario = recorded("gupta2015_case1")
    revised, unread = revise(scenario)
    assert unread == ()
    assert revised.values["nmpc_controller"] == scenario.values["nmpc_controller"]
    assert revised.n_steps == scenario.n_steps


@pytest.mark.parametrize(
    ("name", "method", "unread"),
    [
        ("gupta2015_case1", "slsqp", set()),
        ("kalabic2014_nmpc", "shooting", {"weights.stage_rate", "terminal_set"}),
        ("bagherzadeh2023_ne", "shooting", {"nominal_rotation_vector"}),
        ("bagherzadeh2023_estimated_du", "slsqp", {"variant", "formulation"}),
    ],
)
def test_what_the_new_method_does_not_read_is_left_out_and_named(name, method, unread):
    revised, found = revise(recorded(name), method=method)
    assert set(found) == unread
    assert revised.controller.method == method


def test_stated_defaults_are_not_named():
    scenario = recorded("gupta2015_case1")
    revised, unread = revise(scenario, method="feedback")
    stated, also_unread = revise(load_of(scenario), method="feedback")
    assert unread == also_unread
    assert stated.values["nmpc_controller"] == revised.values["nmpc_controller"]


def load_of(scenario):
    """Return the scenario as the launcher states it: every default written out."""
    from spacecraft_gnc.scenario import from_sections

    return from_sections(scenario.values)


def test_the_user_s_own_values_are_still_refused():
    with pytest.raises(InvalidScenario, match=r"--set: nmpc_controller\.weights\.stage_rate"):
        revise(recorded("gupta2015_case1"), ["nmpc_controller.weights.stage_rate=2.0"], "shooting")


def test_the_method_may_be_set_like_any_other_value():
    revised, _ = revise(recorded("gupta2015_case1"), ["nmpc_controller.method=fsolve"])
    assert revised.controller.method == "fsolve"


def test_no_target_has_to_be_reached():
    weak = {"nmpc_controller.max_torque": 1e-6}
    with pytest.raises(InvalidScenario):
        recorded("gupta2015_case1", **weak)
    assert revise(recorded("gupta2015_case1"), weak)[0].controller.max_torque == 1e-6


@pytest.mark.parametrize("method", ["slsqp", "feedback", "terminal_set", "neighboring_extremal"])
def test_a_governor_s_work_is_done(method):
    revised, _ = revise(recorded("governed_nmpc"), method=method)
    assert revised.governor.governor == "none"
    assert revised.controller.zones
    assert revised.build_controller().name == method


@pytest.mark.parametrize(
    ("method", "words"),
    [("bogus", "--method: nmpc_controller.method: received 'bogus'; required one of shooting")],
)
def test_an_unknown_method_is_refused(method, words):
    with pytest.raises(InvalidScenario, match=words):
        revise(recorded("gupta2015_case1"), method=method)
