"""The scenarios that come with the package are found, and can fly."""

from __future__ import annotations

import pytest

from spacecraft_gnc.errors import ScenarioError
from spacecraft_gnc.scenario import load
from spacecraft_gnc.scenario import shipped as module
from spacecraft_gnc.scenario.shipped import shipped


def test_a_shipped_scenario_is_found_and_loads():
    assert load(shipped("gupta2015_case1")).build().plant.n_steps == 375


def test_an_unknown_one_is_refused_with_those_known():
    with pytest.raises(ScenarioError, match=r"'gupta1815'.*gupta2015_case1"):
        shipped("gupta1815")


def test_an_installed_package_has_them_in_its_share_folder(tmp_path, monkeypatch):
    folder = tmp_path / "share" / "spacecraft_gnc" / "config"
    folder.mkdir(parents=True)
    (folder / "mine.yaml").touch()
    monkeypatch.setattr(module, "__file__", str(tmp_path / "lib" / "a" / "b" / "shipped.py"))
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"/nowhere:{tmp_path}")
    assert shipped("mine") == folder / "mine.yaml"
