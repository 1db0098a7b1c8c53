"""Settings of every test."""

from __future__ import annotations

from browser import browser, module_browser  # noqa: F401 - fixtures
from hypothesis import settings

# Timings are no property of the code (first calls compile), and CI must not depend on a seed.
# `pytest --hypothesis-profile=explore` draws new samples.
settings.register_profile("fixed", deadline=None, derandomize=True)
settings.register_profile("explore", deadline=None, max_examples=500)
settings.load_profile("fixed")
