"""Cache folder of admissible sets, shared by the docking tests of a session."""

from __future__ import annotations

import pytest


@pytest.fixture(scope="session", autouse=True)
def cache_of_sets(tmp_path_factory):
    """Keep the sets in a temporary folder, which the workers of a session share."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.getbasetemp().parent / "cache"))
        yield
