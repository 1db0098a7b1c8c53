"""The bags of some scenarios, and what commands tell of them, are as pinned.

``tools/pin.py --check`` does so for every scenario, which takes too long for each run of the tests.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from pinned import flights, store

pytestmark = [pytest.mark.graph, pytest.mark.long]

SOME = ["gupta2015_case1", "governed_nmpc", "kalabic2014_nmpc", "sun_moon"]


@pytest.mark.parametrize("name", SOME)
def test_a_bag_is_as_pinned(name: str, tmp_path: Path) -> None:
    found = flights.recorded(name, tmp_path)
    differing = flights.differences(name, store.load(name)["recorded"], found)
    assert not differing, "\n".join(differing)
