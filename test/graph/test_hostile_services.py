"""A stranger calls every service of a flight: it ends as it should, with the torques it should."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest
from graph.comparison import CASE1, assert_equals_simulation

from spacecraft_gnc.launcher.outcome import NodeDied

sys.path.append(str(Path(__file__).resolve().parents[2] / "benchmarks"))

from hostile_services import Attack, attacked, differing
from lifecycle_msgs.srv import ChangeState

pytestmark = pytest.mark.graph

PATIENT = "plant.command_timeout=60.0"
SOME = ("plant.duration=800.0", PATIENT)
FEW = ("plant.duration=200.0", PATIENT)
ENDLESS = ("plant.duration=40000.0", PATIENT)


@pytest.mark.long
def test_a_hundred_random_calls_change_nothing(tmp_path: Path) -> None:
    """The full form has 1,000: benchmarks/hostile_services.py."""
    attack = attacked(tmp_path / "run", 100, 3, SOME)
    assert attack.stranger is not None
    assert sum(attack.stranger.sent.values()) >= 100
    assert attack.stranger.unanswered == 0
    assert len(attack.stranger.answered) >= 8
    assert differing(tmp_path / "run" / "bag", SOME) == 0


class Deactivation(Attack):
    """Asks the controller to stop."""

    def _attack(self) -> None:
        assert self.stranger is not None
        request = ChangeState.Request()
        request.transition.label = "deactivate"
        self.stranger.call(ChangeState, "nmpc_controller/change_state", request)
        self.stranger.collect()


def test_a_foreign_transition_ends_the_run_by_name_where_the_scenario_says_so(graph: Any) -> None:
    display = Deactivation(1, 1)
    with pytest.raises(NodeDied) as died:
        graph.fly(*ENDLESS, "launcher.on_foreign_transition=stop", display=display)
    assert graph.exit_codes["nmpc_controller"] == 1
    told = "nmpc_controller: transition deactivate was requested by somebody else"
    assert told in "\n".join([str(died.value), *died.value.last_output])


def test_else_it_is_refused(graph: Any) -> None:
    display = Deactivation(1, 1)
    out = graph.fly(*FEW, display=display)
    assert display.stranger.unanswered == display.stranger.transitions == 0
    assert_equals_simulation(out / "bag", *FEW, scenario=CASE1)
    log = (out / "logs" / "nmpc_controller.log").read_text()
    assert "transition deactivate was requested by somebody else" in log


class Impatience(Attack):
    """Has every node configured and activated before the launcher asks for it, in any order."""

    def starting(self, stages: Any) -> None:
        super().starting(stages)
        self.begin()

    def _attack(self) -> None:
        assert self.stranger is not None
        for wanted in ("configure", "activate", "configure", "deactivate", "shutdown"):
            for node in self.stranger.nodes:
                request = ChangeState.Request()
                request.transition.label = wanted
                self.stranger.call(ChangeState, f"{node}/change_state", request)
        self.stranger.collect()


@pytest.mark.long
def test_whoever_is_faster_than_the_launcher_does_its_work(graph: Any) -> None:
    display = Impatience(1, 1)
    out = graph.fly(*FEW, display=display)
    assert display.stranger.unanswered == 0
    assert_equals_simulation(out / "bag", *FEW, scenario=CASE1)
