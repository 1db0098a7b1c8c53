"""Settings of every test."""

from __future__ import annotations

import pytest
from browser import browser, module_browser  # noqa: F401 - fixtures
from hypothesis import settings

# Timings do not depend on the code alone (first calls compile), and CI must not depend on a seed.
# `pytest --hypothesis-profile=explore` draws new samples.
settings.register_profile("fixed", deadline=None, derandomize=True)
settings.register_profile("explore", deadline=None, max_examples=500)
settings.load_profile("fixed")


@pytest.hookimpl(tryfirst=True)  # before `-m` selects by the marker added here
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Count live pages among the graphs: both take free ports, and two would share two cores."""
    for item in items:
        if item.path.parent.name == "live":
            item.add_marker("graph")
