"""Every scenario that is shipped, and every method, flies the same in the graph as without ROS."""

from __future__ import annotations

from typing import Any

import pytest
from graph.comparison import CASE1, assert_equals_simulation

pytestmark = [pytest.mark.graph, pytest.mark.long]

COMPOSED = "launcher.composed=true"
SHIPPED = sorted(CASE1.parent.glob("*.yaml"))
BASELINES = ["slsqp", "fsolve"]
SHORT = "plant.duration=4.0"


@pytest.mark.parametrize("scenario", SHIPPED, ids=lambda path: path.stem)
def test_a_shipped_scenario(graph: Any, scenario: Any) -> None:
    out = graph.fly(COMPOSED, scenario=scenario)
    assert graph.exit_codes == {"graph": 0}
    assert_equals_simulation(out / "bag", COMPOSED, scenario=scenario)


@pytest.mark.parametrize("method", BASELINES)
def test_a_baseline(graph: Any, method: str) -> None:
    overrides = (f"nmpc_controller.method={method}", SHORT)
    out = graph.fly(*overrides)
    assert set(graph.exit_codes.values()) == {0}
    assert_equals_simulation(out / "bag", *overrides)
