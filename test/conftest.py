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
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Give each worker whole files, and one worker all graphs, because two would share two cores.

    Graphs run first because they take longest. Live pages run with them: both take free ports.
    """
    for item in items:
        if item.path.parent.name == "live":
            item.add_marker("graph")
    if config.pluginmanager.hasplugin("xdist"):
        for item in items:
            name = f"{item.path.parent.name}/{item.path.name}"
            graph = item.get_closest_marker("graph") is not None
            item.add_marker(pytest.mark.xdist_group("graph" if graph else name))
        items.sort(key=lambda item: item.get_closest_marker("graph") is None)
