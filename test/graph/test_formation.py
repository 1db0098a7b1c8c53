"""A formation in the graph: a controller node for each craft, the numbers of `gnc simulate`."""

from __future__ import annotations

import os
import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.recording.bag import open_bag
from spacecraft_gnc.recording.columns import Columns, read_columns
from spacecraft_gnc.recording.steps import craft_in
from spacecraft_gnc.scenario import load, load_fleet
from spacecraft_gnc.scenario.shipped import find
from spacecraft_gnc.signals import Signal
from spacecraft_gnc.vehicles.formation.signals import COMMAND, REFERENCE, STATE

pytestmark = pytest.mark.graph

UNGOVERNED = find("afrl_formation_ungoverned")
NAMES = ("sc1", "sc2", "sc3")
FEW = "plant.duration=330.0"  # [s]: 3 control steps
PATIENT = "plant.command_timeout=120.0"  # a busy machine may take long to start a process


def recorded(out: Path, namespace: str | None = None) -> dict[Signal, Columns]:
    with open_bag(out / "bag") as bag:
        assert craft_in(bag, COMMAND, STATE, namespace) == NAMES
        signals = (STATE, REFERENCE, *map(COMMAND.of, NAMES))
        return read_columns(bag, signals, namespace)


def assert_is_simulated(out: Path, *overrides: str) -> None:
    flight: Any = load(UNGOVERNED, overrides).build().run()
    columns = recorded(out)
    states, n = columns[STATE].fields, flight.n_steps
    for name in ("position", "velocity"):
        flown = states[name].reshape(n + 1, 3, 3)
        assert np.array_equal(flown[:-1], getattr(flight, name))
        assert np.array_equal(flown[-1], getattr(flight, f"final_{name}"))
    commands = [columns[COMMAND.of(name)].fields["delta_v"] for name in NAMES]
    assert np.array_equal(np.stack(commands, axis=1), flight.delta_v)
    assert np.array_equal(states["applied_delta_v"][1:].reshape(n, 3, 3), flight.delta_v)
    assert set(states["applied_source"][1:].ravel()) == {Source.METHOD}


def test_a_controller_for_each_craft_flies_what_is_simulated(graph: Any) -> None:
    out = graph.fly(scenario=UNGOVERNED)
    nodes = ("plant", *(f"{name}/nmpc_controller" for name in NAMES), "reference_governor")
    assert graph.exit_codes == dict.fromkeys((*nodes, "recorder"), 0)
    assert set(load_fleet(UNGOVERNED).nodes) == set(graph.exit_codes)
    assert_is_simulated(out)
    whole, of_craft = recorded(out), recorded(out, "/sc2")
    assert np.array_equal(whole[STATE].fields["position"], of_craft[STATE].fields["position"])


def test_one_process_flies_the_same(graph: Any) -> None:
    assert_is_simulated(graph.fly(FEW, "launcher.composed=true", scenario=UNGOVERNED), FEW)


@pytest.mark.long
def test_a_craft_without_a_controller_rests_and_is_named(graph: Any) -> None:
    nodes = "[plant, sc1/nmpc_controller, sc3/nmpc_controller, reference_governor, recorder]"
    changes = (FEW, "plant.command_timeout=0.3", f"launcher.nodes={nodes}")
    out = graph.fly(*changes, scenario=UNGOVERNED)
    log = (out / "logs" / "plant.log").read_text()
    assert "no command of sc2 for step 0 within 0.3 s; idle control applied" in log
    assert graph.outcome.missed_deadlines == 3
    columns = recorded(out)
    sources = columns[STATE].fields["applied_source"][1:]
    assert sources.tolist() == [[Source.METHOD, Source.ZERO, Source.METHOD]] * 3
    applied = columns[STATE].fields["applied_delta_v"][1:].reshape(3, 3, 3)
    assert not applied[:, 1].any()
    assert columns[COMMAND.of("sc2")].steps.size == 0
    for row, name in ((0, "sc1"), (2, "sc3")):
        assert np.array_equal(applied[:, row], columns[COMMAND.of(name)].fields["delta_v"])


def test_the_controller_of_one_craft_is_restarted_and_the_flight_is_the_same(
    graph: Any, at: Any
) -> None:
    def kill(launcher: Any) -> None:
        os.kill(launcher._processes["sc2/nmpc_controller"].pid, signal.SIGKILL)

    changes = ("plant.duration=110000.0", "launcher.on_node_death=restart", PATIENT)
    out = graph.fly(*changes, scenario=UNGOVERNED, display=at(20, kill))
    assert graph.outcome.restarts == ("sc2/nmpc_controller",)
    assert "0 deadlines missed" in (out / "logs" / "plant.log").read_text()
    assert_is_simulated(out, changes[0])


@pytest.mark.long
def test_in_free_run_every_craft_is_commanded(graph: Any) -> None:
    changes = ("plant.mode=free_run", "plant.real_time_factor=1000.0")
    out = graph.fly(*changes, scenario=UNGOVERNED)
    sources = recorded(out)[STATE].fields["applied_source"][1:]
    assert (sources == Source.METHOD).mean() > 0.5
