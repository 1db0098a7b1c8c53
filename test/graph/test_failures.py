"""What ends a graph early ends it at once, in order, and says why."""

from __future__ import annotations

import os
import resource
import signal
from pathlib import Path
from typing import Any

import pytest
from graph.killing import kill_governor_between_steps

from spacecraft_gnc.analysis.reader import RecordedRun, read_flight
from spacecraft_gnc.launcher import domain
from spacecraft_gnc.launcher.outcome import Interrupted, NodeDied, NodeRefused

pytestmark = pytest.mark.graph

ENDLESS = "plant.duration=1000000.0"
EARLY = 60
MEGABYTE = 1_000_000
SAVED = 2000  # steps, over a second of wall time: longer than a recorder keeps messages to itself


def kill(name: str) -> Any:
    return lambda launcher: os.kill(launcher._processes[name].pid, signal.SIGKILL)


def assert_whole(flight: RecordedRun, *, killed: bool = False) -> None:
    """Nothing is missing but what was under way at the end.

    Where a node was killed, that is all that the recorder had not received: the end of a topic.
    """
    last = len(flight.trajectory.time) - 1
    for topic, steps in flight.info.missing.items():
        assert steps[-1] >= last, (topic, steps)
        assert steps[0] >= last or (killed and steps[-1] - steps[0] < len(steps)), (topic, steps)


@pytest.mark.parametrize("name", ["plant", "nmpc_controller", "reference_governor", "recorder"])
def test_a_killed_node_ends_the_run(graph: Any, at: Any, name: str) -> None:
    display = at(SAVED if name == "recorder" else EARLY, kill(name))
    running: list[int] = []

    def tell(text: str) -> None:
        display.told.append(text)
        running.append(list(graph.exit_codes.values()).count(None))

    display.tell = tell
    with pytest.raises(NodeDied, match=f"{name} .* was killed by SIGKILL at step") as caught:
        graph.fly(ENDLESS, display=display)
    assert caught.value.exit_code == 1
    assert caught.value.told
    assert display.told == [f"error: {caught.value}"]
    assert running == [3]  # it is named before the others are ended
    codes = graph.exit_codes
    assert codes.pop(name) == -signal.SIGKILL
    assert codes == dict.fromkeys(codes, 0)
    bag = graph.launcher.plan.bag
    flight = read_flight(bag, allow_unfinished=name == "recorder")
    assert flight.info.unfinished == (name == "recorder")
    assert len(flight.trajectory.time) > 0
    assert_whole(flight, killed=True)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_run_in_order(graph: Any, at: Any, number: int) -> None:
    before = signal.getsignal(number)
    with pytest.raises(Interrupted, match=signal.Signals(number).name) as caught:
        graph.fly(ENDLESS, display=at(EARLY, lambda _: os.kill(os.getpid(), number)))
    assert caught.value.exit_code == 128 + number
    assert graph.exit_codes == dict.fromkeys(graph.exit_codes, 0)
    assert signal.getsignal(number) is before
    flight = read_flight(graph.launcher.plan.bag)
    assert len(flight.trajectory.time) >= EARLY
    assert_whole(flight)


@pytest.mark.parametrize("name", ["nmpc_controller", "reference_governor", "recorder"])
def test_a_killed_node_is_restarted_where_asked(graph: Any, at: Any, name: str) -> None:
    in_order = name == "reference_governor"
    display = at(EARLY, kill_governor_between_steps if in_order else kill(name))
    patient = "plant.command_timeout=120.0"  # a busy machine may take long to start a process
    changes = ("plant.duration=800.0", "launcher.on_node_death=restart", patient)
    out = graph.fly(*changes, display=display)
    assert graph.outcome.restarts == (name,)
    assert graph.outcome.strangers == ()
    assert "SIGKILL" in display.notes[0]
    assert graph.exit_codes == dict.fromkeys(graph.exit_codes, 0)
    assert "flew 2000 steps: 0 deadlines missed" in (out / "logs" / "plant.log").read_text()
    if name == "recorder":
        assert len(graph.outcome.bags) == 2
        assert len(read_flight(graph.outcome.bags[1]).trajectory.time) > 0
    else:
        flight = read_flight(out / "bag")
        assert len(flight.trajectory.time) == 2000
        flight.info.missing.pop("solver_status", None)  # killed between torque and status
        assert not flight.info.missing


def test_a_second_graph_on_a_domain_is_refused(graph: Any) -> None:
    lock = domain.claim_free({"scenario": "first.yaml"})
    with pytest.raises(domain.DomainTaken, match=r"another graph runs .*first\.yaml") as caught:
        graph.fly(f"launcher.domain_id={lock.domain_id}")
    assert caught.value.exit_code == 2
    lock.release()


def test_the_domain_of_the_environment_is_used(graph: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    lock = domain.claim_free({"scenario": "first.yaml"})
    monkeypatch.setenv("ROS_DOMAIN_ID", str(lock.domain_id))
    with pytest.raises(domain.DomainTaken, match=f"received {lock.domain_id},"):
        graph.fly()
    lock.release()


def test_a_node_that_cannot_be_configured(graph: Any, tmp_path: Path) -> None:
    (tmp_path / "occupied").mkdir()
    out = tmp_path / "occupied"
    with pytest.raises(NodeRefused, match="recorder: ") as caught:
        graph.fly(ENDLESS, out=out, before=lambda: (out / "bag").write_text("a file"))
    assert caught.value.exit_code == 2
    assert not (out / "bag").is_dir()


def test_no_controller_in_lockstep_falls_back(graph: Any) -> None:
    out = graph.fly(
        "plant.duration=1.2",
        "plant.command_timeout=0.3",
        "launcher.nodes=[plant, reference_governor, recorder]",
    )
    flown = read_flight(out / "bag").trajectory
    assert flown.source.tolist() == [4, 4, 4]
    assert not flown.torque.any()
    assert graph.outcome.missed_deadlines == 3


def test_a_full_disk_is_named_although_the_log_is_on_it(graph: Any, at: Any) -> None:
    out, display = graph.folder / "run", at(0, lambda _: None)

    def fill() -> None:
        (out / "logs").mkdir()
        for name in ("plant", "nmpc_controller", "reference_governor", "recorder"):
            (out / "logs" / f"{name}.log").symlink_to("/dev/full")
        resource.setrlimit(resource.RLIMIT_FSIZE, (MEGABYTE, before[1]))  # the nodes inherit it

    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    try:
        with pytest.raises(NodeDied, match=r"recorder .* ended with exit code 2 at step"):
            graph.fly(ENDLESS, out=out, display=display, before=fill)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    (death,) = (text for text in display.told if text.startswith("error: "))
    assert "File too large" in death
    (trouble,) = (text for text in display.told if text.startswith("warning: "))
    assert "No space left on device; the logs of this flight have gaps" in trouble
