"""Every shipped scenario flies as it flew when it was pinned, bit for bit.

The stored values are remade by ``tools/pin.py``, only in a commit that says why they change.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from pinned import flights, store

pytestmark = pytest.mark.long


def test_each_shipped_scenario_is_pinned() -> None:
    assert store.names() == flights.SHIPPED, "run tools/pin.py NAME for a new scenario"


@pytest.mark.parametrize("name", flights.SHIPPED)
def test_a_scenario_flies_as_pinned(name: str, tmp_path: Path) -> None:
    found = flights.simulated(name, tmp_path)
    differing = flights.differences(name, store.load(name)["simulated"], found)
    assert not differing, "\n".join(differing)
