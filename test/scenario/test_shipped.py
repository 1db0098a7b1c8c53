"""The scenarios that come with the package are found, and can fly."""

from __future__ import annotations

from pathlib import Path

import pytest

from spacecraft_gnc.errors import GncError
from spacecraft_gnc.scenario import InvalidScenario, load
from spacecraft_gnc.scenario import shipped as module
from spacecraft_gnc.scenario.shipped import find, shipped


def test_a_shipped_scenario_is_found_and_loads():
    assert load(shipped("gupta2015_case1")).build().plant.n_steps == 375


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("gupta2015_case", "use gupta2015_case1 or gupta2015_case2"),
        ("config/gupta2015_case1.yaml", "use gupta2015_case1 or"),
        ("zzz", "use one of .*bagherzadeh2023_estimated_du, .*, kalabic2014_ungoverned"),
    ],
)
def test_an_unknown_one_is_refused_with_those_near(name, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InvalidScenario, match=rf"\S+: received no such file; required .*; {words}"):
        load(name)


def test_a_name_means_the_shipped_one_unless_a_file_is_there(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    name = "gupta2015_case1"
    assert load(name).path == str(shipped(name))
    (tmp_path / name).mkdir()  # a folder is no scenario
    assert find(name) == shipped(name)
    (tmp_path / f"{name}.yaml").touch()
    assert find(name) == Path(f"{name}.yaml")
    (tmp_path / name).rmdir()
    (tmp_path / name).touch()
    assert find(name) == Path(name)


@pytest.mark.parametrize("path", ["missing.yaml", "a" * 300, "none/x", ".", "a\0b"])
def test_a_path_is_left_to_its_reader(path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(GncError, match=r"required .*; "):
        load(path)


@pytest.mark.parametrize("place", ["lib/python3.11/site-packages", "lib/site-packages", "."])
def test_an_installed_package_has_them_in_its_share_folder(place, tmp_path, monkeypatch):
    """Of its prefix (a plain, a --user and a --prefix installation), or beside it (--target)."""
    folder = tmp_path / "share" / "spacecraft_gnc" / "config"
    folder.mkdir(parents=True)
    (folder / "mine.yaml").touch()
    (tmp_path / place / "config").mkdir(parents=True)
    (tmp_path / place / "config" / "other.yaml").touch()  # of another package
    installed = tmp_path / place / "spacecraft_gnc" / "scenario" / "shipped.py"
    monkeypatch.setattr(module, "__file__", str(installed))
    assert shipped("mine") == folder / "mine.yaml"
    with pytest.raises(InvalidScenario, match="no such file"):
        shipped("other")


def test_colcon_names_its_prefixes(tmp_path, monkeypatch):
    folder = tmp_path / "share" / "spacecraft_gnc" / "config"
    folder.mkdir(parents=True)
    (folder / "mine.yaml").touch()
    monkeypatch.setattr(module, "__file__", "/build/spacecraft_gnc/scenario/shipped.py")
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"/nowhere:{tmp_path}")
    assert shipped("mine") == folder / "mine.yaml"
