"""The fuzz of scenario files: a short one finds nothing, and what there is, it finds."""

from __future__ import annotations

import argparse
import importlib.util
import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

from spacecraft_gnc.errors import ScenarioError

ROOT = Path(__file__).resolve().parents[2]
RUN = ROOT / "benchmarks" / "fuzz_scenarios.py"


@pytest.fixture(scope="module")
def fuzz() -> ModuleType:
    spec = importlib.util.spec_from_file_location("fuzz_scenarios", RUN)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_damaged_scenarios_are_refused_or_fly() -> None:
    """Compared with rclpy, where that is installed; none has sets to search for, which is long."""
    ros = ["--ros"] if importlib.util.find_spec("rclpy") else []
    done = subprocess.run(
        [sys.executable, str(RUN), "--cases", "60", "--seed", "8", *ros],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.startswith("60 cases, 0 faults; ")
    flew = [word for word in done.stdout.split(", ") if word.strip().endswith("flew")]
    assert flew, done.stdout  # else nothing was built


def test_cases_are_repeatable_and_differ(fuzz: ModuleType) -> None:
    assert fuzz.case(1, 5) == fuzz.case(1, 5)
    assert len({fuzz.case(1, number) for number in range(50)}) > 45


@pytest.mark.parametrize(
    ("raised", "faults"),
    [(OverflowError("int too large"), 3), (MemoryError(), 3), (ScenarioError("a reason"), 0)],
)
def test_only_errors_of_the_package_are_no_faults(
    raised: Exception,
    faults: int,
    fuzz: ModuleType,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def load(*_: object) -> None:
        raise raised

    monkeypatch.setattr(fuzz, "load", load)
    wanted = argparse.Namespace(cases=3, seed=1, first=7, ros=False)
    _, found, _ = fuzz.run(wanted, tmp_path)
    assert len(found) == faults
    assert all(fault.startswith("case ") for fault in found)


def test_too_much_time_is_a_fault(
    fuzz: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fuzz, "examine", lambda *_, **__: ("flew", 10.5))
    wanted = argparse.Namespace(cases=1, seed=1, first=0, ros=False)
    assert fuzz.run(wanted, tmp_path)[1] == ["case 0: 10.5 s of CPU time"]
