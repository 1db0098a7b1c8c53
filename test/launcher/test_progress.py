"""What a user sees of a graph that flies, on any terminal."""

from __future__ import annotations

import math
import re
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from spacecraft_gnc.launcher import progress as module
from spacecraft_gnc.launcher.deadlines import lateness
from spacecraft_gnc.launcher.plan import LaunchPlan, make_plan
from spacecraft_gnc.launcher.progress import Bar, Display, PlainLines, Silence, choose
from spacecraft_gnc.scenario import load
from spacecraft_gnc.scenario.shipped import shipped

CASE1 = shipped("gupta2015_case1")
FREE = ("plant.mode=free_run", "plant.real_time_factor=20.0")


@dataclass
class Report:
    step: int = 6000
    wall_elapsed: float = 120.0
    latency: float = math.nan
    missed_deadlines: int = 6000
    status_step: int = 5998
    distance: float = math.nan
    attitude_error: float = math.radians(123.4)
    solve_time: float = 329e-6


@pytest.fixture
def plan(tmp_path: Path) -> LaunchPlan:
    return make_plan(CASE1, FREE, out=tmp_path / "run")


@pytest.fixture
def columns(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Return what makes stderr a terminal of so many columns."""

    def make(count: int) -> None:
        monkeypatch.setenv("COLUMNS", str(count))
        monkeypatch.setenv("TERM", "xterm-256color")
        monkeypatch.delenv("NO_COLOR", raising=False)
        monkeypatch.setattr(sys.stderr, "isatty", lambda: True)

    return make


def lines(text: str) -> list[str]:
    """Return what the terminal holds, without the codes that move its cursor."""
    return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", text).replace("\r", "\n").splitlines()


def test_80_columns_keep_phase_error_and_missed_deadlines(
    plan: LaunchPlan, columns: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    columns(80)
    bar = choose(quiet=False)
    assert isinstance(bar, Bar)
    bar.waiting(plan, 7)
    stages = ("plant", "nmpc_controller", "reference_governor", "recorder")
    bar.starting(dict.fromkeys(stages, "configuring"))
    bar.flying(Report())
    bar.close()
    out, err = capsys.readouterr()
    assert out == ""
    shown = lines(err)
    assert max(len(line) for line in shown) <= 80
    assert any(line.startswith("starting") and "4 configuring" in line for line in shown)
    (flying,) = {line.rstrip() for line in shown if line.startswith("flying")}
    assert flying.endswith("123.4 deg off, 6000 of 6000 deadlines missed")
    assert "…" not in flying


def test_a_wide_terminal_has_room_for_all_of_it(
    plan: LaunchPlan, columns: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    columns(160)
    bar = Bar()
    bar.waiting(plan, 7)
    bar.starting({"plant": "active", "recorder": "configuring"})
    bar.flying(Report(missed_deadlines=3))
    bar.close()
    shown = "\n".join(lines(capsys.readouterr().err))
    assert "plant active, recorder configuring" in shown
    assert "123.4 deg off, 3 deadlines missed, t = 2399.2 s, 20 x real time, 329 us/solve" in shown


@pytest.mark.parametrize(
    ("distance", "angle", "expected"),
    [
        (12.345, math.radians(1.5), "12.35 m and 1.5 deg off"),
        (0.0019999, math.nan, "0.002 m off"),
        (math.nan, math.radians(1.5), "1.5 deg off"),
        (math.nan, math.nan, "t = 29990.0 s"),
    ],
)
def test_it_tells_how_far_it_has_to_go(distance: float, angle: float, expected: str) -> None:
    report = Report(missed_deadlines=0, distance=distance, attitude_error=angle)
    assert module.describe(report, 5.0)[0] == expected


def test_a_log_gets_lines_on_stderr(
    plan: LaunchPlan, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(module, "_LINE_PERIOD", 0.0)
    display = choose(quiet=False)
    assert isinstance(display, PlainLines)
    display.waiting(plan, 7)
    display.flying(Report())
    out, err = capsys.readouterr()
    assert out == ""
    assert "123.4 deg off, 6000 of 6000 deadlines missed, t = 2399.2 s" in err


@pytest.mark.parametrize(
    ("display", "told"),
    [(Display(), "warning: late\n"), (PlainLines(), "warning: late\n"), (Silence(), "")],
)
def test_warnings_go_to_stderr(
    display: Display, told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    display.warn("late")
    assert capsys.readouterr() == ("", told)
    assert type(choose(quiet=True)) is Silence
    assert type(choose(quiet=False, warnings_only=True)) is Display


@pytest.mark.parametrize(
    ("missed", "steps", "elapsed", "overrides", "warned"),
    [
        (6000, 6000, 120.0, FREE, True),
        (3001, 6000, 120.0, FREE, True),
        (3000, 6000, 120.0, FREE, False),
        (50, 50, 1.0, FREE, False),  # a graph that has just started
        (10, 10, math.inf, FREE, True),  # a short flight that is over
        (10, 10, math.inf, (), False),  # lockstep waits
        (0, 0, math.inf, FREE, False),
    ],
)
def test_a_flight_without_its_controller_is_warned_of(
    missed: int, steps: int, elapsed: float, overrides: tuple[str, ...], warned: bool
) -> None:
    text = lateness(missed, steps, elapsed, load(CASE1, overrides))
    assert bool(text) == warned
    if warned:
        assert f"{missed} of {steps} torques came after their deadline" in text
        assert "required one within 20 ms" in text
        assert text.endswith("lower --rate, or fly with --mode lockstep, which waits")
