"""Graphs of real processes, each on a domain of its own."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from spacecraft_gnc.launcher.launcher import Launcher
from spacecraft_gnc.launcher.plan import make_plan
from spacecraft_gnc.launcher.progress import Display, Report

CASE1 = Path(__file__).resolve().parents[2] / "config" / "gupta2015_case1.yaml"


class At(Display):
    """Does something once, when the graph reports a step of at least ``step``."""

    def __init__(self, step: int, action: Callable[[Launcher], None]) -> None:
        self.step = step
        self.action = action
        self.launcher: Launcher | None = None
        self.notes: list[str] = []
        self.told: list[str] = []

    def flying(self, report: Report) -> None:
        if report.step >= self.step and self.launcher is not None:
            launcher, self.launcher = self.launcher, None
            self.action(launcher)

    def note(self, text: str) -> None:
        self.notes.append(text)

    def tell(self, text: str) -> None:
        self.told.append(text)


class Graph:
    """Launches Case I with overrides into a folder of the test."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.launcher: Launcher | None = None

    def fly(self, *overrides: str, display: Display | None = None, **options: Any) -> Path:
        """Launch; return the folder of the run."""
        out = options.pop("out", None) or self.folder / f"run-{len(list(self.folder.iterdir()))}"
        before = options.pop("before", None)
        plan = make_plan(options.pop("scenario", CASE1), overrides, out=out, **options)
        if before is not None:
            before()
        self.launcher = Launcher(plan, display or Display(), time.monotonic())
        if hasattr(display, "launcher"):
            display.launcher = self.launcher
        self.outcome = self.launcher.run()
        return out

    @property
    def exit_codes(self) -> dict[str, int | None]:
        assert self.launcher is not None
        return {name: p.exit_code for name, p in self.launcher._processes.items()}


@pytest.fixture
def at() -> type[At]:
    return At


@pytest.fixture
def graph(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Graph:
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    return Graph(tmp_path)
