"""A bag holds all that is needed to fly again, and survives the death of its recorder."""

from __future__ import annotations

import os
import random
import signal
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from graph.conftest import CASE1, Graph
from rosbags.highlevel import AnyReader

from spacecraft_gnc import __version__
from spacecraft_gnc.analysis.reader import read_flight
from spacecraft_gnc.launcher.launcher import Launcher
from spacecraft_gnc.launcher.outcome import NodeDied
from spacecraft_gnc.launcher.progress import Display, Report
from spacecraft_gnc.recording.bag import open_bag
from spacecraft_gnc.recording.rebuild import rebuild
from spacecraft_gnc.scenario import load
from spacecraft_gnc.scenario.provenance import lock_file

pytestmark = pytest.mark.graph

OTHER = (
    "plant.duration=8.0",
    "nmpc_controller.max_torque=0.008",
    "plant.initial_momentum=[0.,0.,0.01]",
)
CONSOLE = {"storage_folder", "autostart"}  # what the launcher passes on the command line


@pytest.fixture(scope="module")
def evidence(tmp_path_factory: Any) -> Any:
    """Return metadata, attachments and flight of a bag with overrides."""
    out = Graph(tmp_path_factory.mktemp("evidence")).fly(*OTHER)
    with open_bag(out / "bag") as bag:
        return bag.metadata(), bag.attachments(), read_flight(out / "bag")


def test_the_record_of_the_run(evidence: Any) -> None:
    records, attachments, _ = evidence
    run = records["run"]
    assert run["package_version"] == __version__
    assert run["mode"] == "lockstep"
    assert (run["vehicle"], run["method"], run["variant"], run["governor"]) == (
        "rigid_body",
        "shooting",
        "exact",
        "none",
    )
    assert run["method_package"] == f"spacecraft_gnc {__version__}"
    assert run["rmw"].startswith("rmw_")
    needed = {"host", "cpu", "os", "python", "numpy", "numba", "rclpy", "started", "formulation"}
    assert not [name for name in needed if not run[name]]
    assert {"git_commit", "lock_sha256"} <= run.keys()
    assert attachments.get("requirements.lock", b"") == lock_file()
    assert set(records["losses"].values()) == {"0"}


def test_the_parameters_in_force_fly_the_same_run_again(evidence: Any, tmp_path: Path) -> None:
    _, attachments, flight = evidence
    file = tmp_path / "parameters.yaml"
    file.write_bytes(attachments["parameters.yaml"])
    told, flown = load(file), load(CASE1, list(OTHER))
    for node in ("plant", "nmpc_controller", "reference_governor", "recorder"):
        for name, value in flown.values[node].items():
            if name not in CONSOLE:
                assert told.values[node][name] == value, (node, name)
    again = told.build().run()
    np.testing.assert_array_equal(again.torque, flight.trajectory.torque)
    np.testing.assert_array_equal(again.attitude, flight.trajectory.attitude)


class Killer(Display):
    """Kills the recorder at a moment; remembers which step was reported when."""

    def __init__(self, moment: float) -> None:
        self.moment = moment  # [s] wall after the first report
        self.launcher: Launcher | None = None
        self.reports: list[tuple[float, int]] = []
        self.killed = 0.0

    def flying(self, report: Report) -> None:
        self.reports.append((time.monotonic(), report.step))
        if not self.killed and self.reports[-1][0] - self.reports[0][0] >= self.moment:
            assert self.launcher is not None
            os.kill(self.launcher._processes["recorder"].pid, signal.SIGKILL)
            self.killed = time.monotonic()

    @property
    def owed(self) -> int:
        """The last step known to be older than one second."""
        return max((step for at, step in self.reports if at < self.killed - 1.0), default=-1)


@pytest.mark.parametrize(
    "mode",
    [("plant.mode=lockstep",), ("plant.mode=free_run", "plant.real_time_factor=40.0")],
    ids=["lockstep", "free_run"],
)
def test_a_killed_recorder_is_recovered(graph: Any, mode: tuple[str, ...]) -> None:
    killer = Killer(random.Random(len(mode)).uniform(2.0, 4.0))
    with pytest.raises(NodeDied, match=r"recorder .* was killed by SIGKILL"):
        graph.fly("plant.duration=1000000.0", *mode, display=killer)
    rebuilt = rebuild(graph.launcher.plan.bag)
    assert killer.owed > 0
    assert rebuilt.last_whole_step is not None
    assert rebuilt.last_whole_step >= killer.owed
    assert not rebuilt.missing_steps
    with AnyReader([rebuilt.folder]) as reader:
        assert reader.message_count == rebuilt.messages
    with open_bag(rebuilt.folder) as bag:
        assert {"scenario.yaml", "parameters.yaml"} <= bag.attachments().keys()
        assert {"run", "recovered", "losses"} <= bag.metadata().keys()
    flight = read_flight(rebuilt.folder)
    assert len(flight.trajectory.time) >= killer.owed
    assert not flight.info.unfinished
