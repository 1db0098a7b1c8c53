"""The package in examples/, installed into a scratch environment, adds a method and a vehicle."""

from __future__ import annotations

import json
import os
import shutil
import site
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
SOURCE = ROOT / "examples" / "gnc_example"
SCENARIOS = SOURCE / "scenarios"


def run(*command: str | Path, code: int = 0) -> str:
    """Run a command; return what it printed, or what it said of its end."""
    environment = {**os.environ, "AMENT_PREFIX_PATH": sys.prefix}  # where the messages are
    environment.pop("ROS_DOMAIN_ID", None)  # each graph takes a free one
    result = subprocess.run(
        [*map(str, command)], capture_output=True, text=True, check=False, env=environment
    )
    assert result.returncode == code, f"{command}: {result.stdout}{result.stderr}"
    return result.stdout if code == 0 else result.stderr


@pytest.fixture(scope="module")
def python(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Interpreter of an environment with the example, on top of this one."""
    folder = tmp_path_factory.mktemp("example")
    package = folder / "source"
    shutil.copytree(SOURCE, package)
    run(sys.executable, "-m", "venv", "--without-pip", folder / "venv")
    (packages,) = (folder / "venv").glob("lib/python*/site-packages")
    lines = [f"import site; site.addsitedir({path!r})\n" for path in site.getsitepackages()]
    (packages / "parent.pth").write_text("".join(lines))
    pip = (sys.executable, "-m", "pip", "--python", folder / "venv")
    run(*pip, "install", "-qq", "--no-deps", "--no-build-isolation", "--no-index", package)
    return folder / "venv" / "bin" / "python"


@pytest.fixture(scope="module")
def gnc(python: Path) -> Any:
    """``gnc`` in that environment."""
    return lambda *arguments, code=0: run(python, "-m", "spacecraft_gnc", *arguments, code=code)


def test_the_method_turns_the_spacecraft(gnc: Any) -> None:
    told = json.loads(gnc("simulate", SCENARIOS / "pd_slew.yaml", "--json"))
    assert told["final_error_deg"] < 0.001
    assert told["max_torque"] < 0.02


def test_the_vehicle_ends_in_a_flat_spin(gnc: Any, tmp_path: Path) -> None:
    file = tmp_path / "flight.npz"
    gnc("simulate", SCENARIOS / "flat_spin.yaml", "--out", file)
    with np.load(file) as flight:
        first, last = flight["momentum"][0], flight["final_momentum"]
    assert np.argmax(np.abs(first)) == 2  # about the axis of the smallest moment
    assert abs(last[0]) > 0.98 * np.linalg.norm(last)  # about that of the largest one


def test_a_bad_parameter_is_one_line(gnc: Any) -> None:
    bad = ("--set", "nmpc_controller.plugin.damping=-1.0")
    told = gnc("simulate", SCENARIOS / "pd_slew.yaml", *bad, code=2)
    assert "(plugin.damping): received -1.0; required a number > 0" in told
    assert len(told.strip().splitlines()) == 1


@pytest.mark.graph
def test_the_method_flies_in_the_graph(gnc: Any, tmp_path: Path) -> None:
    flown, bag = tmp_path / "flown", tmp_path / "flown" / "bag"
    gnc("launch", SCENARIOS / "pd_slew.yaml", "--composed", "--out", flown, "--quiet")
    audit = json.loads(gnc("audit", bag, "--json"))
    assert audit["passed"]
    assert audit["steps"] == 300


@pytest.mark.graph
def test_the_vehicle_flies_in_the_graph(gnc: Any, tmp_path: Path) -> None:
    scenario, flown = SCENARIOS / "flat_spin.yaml", tmp_path / "flown"
    short = ("--duration", "5.0")
    gnc("launch", scenario, "--composed", "--out", flown, "--quiet", *short)
    told = gnc("audit", flown / "bag", code=2)
    assert "damped_body" in told
    assert len(told.strip().splitlines()) == 1


def test_a_vehicle_that_is_not_installed_is_one_line() -> None:
    told = run(
        sys.executable, "-m", "spacecraft_gnc", "check", SCENARIOS / "flat_spin.yaml", code=2
    )
    assert "plant.vehicle: received 'damped_body'" in told
