"""What is said and drawn of a flight that was disturbed."""

from __future__ import annotations

import numpy as np
import pytest
from analysis.flights import at_rest
from analysis.test_report import Page

from spacecraft_gnc.cli.main import main
from spacecraft_gnc.scenario import load
from spacecraft_gnc.vehicles.rigid_body.pictures.figures import flight_figures

NAME = "gupta2015_case1_disturbed"
GOVERNED = ["governed_nmpc", "--set", "plant.disturbances=[constant]"]
TORQUE = ["--set", "plant.constant_torque=[1.0e-6, 0.0, 0.0]"]


def code(*argv):
    with pytest.raises(SystemExit) as ended:
        main(argv)
    return ended.value.code


@pytest.fixture(scope="module")
def flight():
    return load(NAME).build().run()


def test_it_settles_where_the_torque_balances_the_disturbance(flight):
    assert np.abs(flight.external_torque - [1e-4, -1.5e-4, 1e-4]).max() < 1e-6
    balance = flight.torque[-1] + flight.external_torque[-1]
    assert np.linalg.norm(balance) < 0.05 * np.linalg.norm(flight.external_torque[-1])
    assert "external_torque" in dict(flight_figures(flight))


def test_an_undisturbed_flight_has_no_figure_of_it():
    assert "external_torque" not in dict(flight_figures(at_rest()))
    unknown = at_rest(external_torque=np.full((20, 3), np.nan))
    assert "external_torque" not in dict(flight_figures(unknown))


def test_a_report_and_a_plot_of_it_show_the_torque(flight, tmp_path):
    scenario = load(NAME)
    saved = flight.save(tmp_path / "flight.npz", scenario.to_yaml(), scenario.stated_defaults())
    assert code("report", str(saved), "--out", str(tmp_path / "report.html")) == 0
    page = Page((tmp_path / "report.html").read_text())
    curves = page.chart("external_torque")["figure"]["data"]
    assert [curve["name"] for curve in curves] == ["x", "y", "z"]


def test_check_lists_the_parts_and_what_a_governor_rests_on(capsys):
    assert code("check", NAME) == 0
    told = capsys.readouterr().out
    assert "disturbances  constant, gravity_gradient, not known to the controller" in told
    assert "limits are sure" not in told
    assert code("check", *GOVERNED, *TORQUE) == 0
    assert "limits are sure without the disturbances only" in capsys.readouterr().out
    heavier = ["--set", "nmpc_controller.inertia=[1.1, 0.0, 0.0, 0.0, 0.9, 0.0, 0.0, 0.0, 0.9]"]
    assert code("check", *GOVERNED, *TORQUE, *heavier) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "sure for the believed inertia and without the disturbances only" in told


def test_a_disturbance_that_is_not_installed_is_one_line(capsys):
    assert code("check", NAME, "--set", "plant.disturbances=[drag]") == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "plant.disturbances: received 'drag'; required one of constant" in line
