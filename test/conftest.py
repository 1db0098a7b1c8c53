"""Settings of every test."""

from __future__ import annotations

import pytest
from browser import browser, module_browser  # noqa: F401 - fixtures
from hypothesis import settings

# Timings are no property of the code (first calls compile), and CI must not depend on a seed.
# `pytest --hypothesis-profile=explore` draws new samples.
settings.register_profile("fixed", deadline=None, derandomize=True)
settings.register_profile("explore", deadline=None, max_examples=500)
settings.load_profile("fixed")


@pytest.hookimpl(tryfirst=True)  # before `-m` selects by the marker that is added here
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Give workers whole files, and one of them every graph: two at a time would share two cores.

    The graphs come first, for they take longest. The live pages go with them: both take free ports.
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
