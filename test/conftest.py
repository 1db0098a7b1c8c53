"""Settings of every test."""

from __future__ import annotations

import math
import os
from pathlib import Path

import pytest
from browser import browser, module_browser, session_browser  # noqa: F401 - fixtures
from hypothesis import settings

# Timings do not depend on the code alone (first calls compile), and CI must not depend on a seed.
# `pytest --hypothesis-profile=explore` draws new samples.
settings.register_profile("fixed", deadline=None, derandomize=True)
settings.register_profile("explore", deadline=None, max_examples=500)
settings.load_profile("fixed")

# Admissible sets take half a minute each: all processes of all tests share them, and none of them
# writes to the user's own cache.
_CACHE = Path(__file__).parent.parent / ".pytest_cache" / "periodic_sets"
os.environ.setdefault("SPACECRAFT_GNC_CACHE", str(_CACHE))


@pytest.fixture(autouse=True)
def no_progress(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let no machine be so slow that a command tells of its progress."""
    monkeypatch.setattr("spacecraft_gnc.cli._progress._PATIENCE", math.inf)


@pytest.hookimpl(tryfirst=True)  # before `-m` selects by the marker added here
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Count live pages among the graphs: both take free ports, and two would share two cores."""
    for item in items:
        if item.path.parent.name == "live":
            item.add_marker("graph")
