"""``gnc view`` and ``gnc inspect watch`` beside a real flight, from before its start to its end."""

from __future__ import annotations

import contextlib
import json
import os
import pty
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from live.watching import EventReader

from spacecraft_gnc.launcher import domain

pytestmark = pytest.mark.graph
ROOT = Path(__file__).resolve().parents[2]
PATIENCE = 60.0  # [s] wall
SHORT = "plant.duration=60.0"  # 150 control steps


@contextlib.contextmanager
def gnc(*argv: str, terminal: int | None = None) -> Iterator[subprocess.Popen[str]]:
    """A command beside the test, which ends at the latest with it."""
    with subprocess.Popen(
        [sys.executable, "-m", "spacecraft_gnc", *argv],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT), "TERM": "xterm-256color"},
        stdout=subprocess.PIPE if terminal is None else terminal,
        stderr=subprocess.PIPE if terminal is None else terminal,
        text=True,
    ) as process:
        try:
            yield process
        finally:
            process.kill()


def free_domain() -> str:
    """Return a domain that stays free until the flight: every other test takes the lowest."""
    for domain_id in reversed(domain._FREE_DOMAINS):
        with contextlib.suppress(domain.DomainTaken):
            domain.claim_given(domain_id, {"test": "view"}).release()
            if domain._ports_free(domain_id):
                return str(domain_id)
    raise AssertionError("no domain is free")


class Watcher(threading.Thread):
    """Collects what a page would receive, until the flight is over."""

    def __init__(self, port: int) -> None:
        super().__init__(daemon=True)
        self.reader = EventReader(port)
        self.phases: list[str] = []
        self.numbers: list[int] = []
        self.rows: list[Any] = []
        self.setup: dict[str, Any] = {}
        self.last: dict[str, Any] = {}
        self.waiting = threading.Event()

    def run(self) -> None:
        for name, data in self.reader:
            if name == "setup":
                self.setup = data
            elif name == "history":
                self.rows = []
            else:
                self.take(data)
                if data["phase"] == "over":
                    return

    def take(self, frame: dict[str, Any]) -> None:
        self.rows += frame["samples"]
        self.numbers.append(frame["number"])
        self.last = frame
        if frame["phase"] not in self.phases:
            self.phases.append(frame["phase"])
        self.waiting.set()


def test_a_page_sees_a_whole_flight(graph: Any) -> None:
    chosen = free_domain()
    with gnc("view", "--domain-id", chosen, "--no-browser", "--json") as view:
        about = json.loads("".join(iter(view.stdout.readline, "}\n")) + "}")
        watcher = Watcher(about["port"])
        watcher.start()
        assert watcher.waiting.wait(PATIENCE)
        graph.fly(
            "plant.mode=free_run",
            "plant.real_time_factor=12",
            SHORT,
            f"launcher.domain_id={chosen}",
            record=False,
        )
        watcher.join(PATIENCE)
        assert not watcher.is_alive(), watcher.last
        view.send_signal(signal.SIGINT)
        _, err = view.communicate(timeout=PATIENCE)
    assert (view.returncode, err) == (0, "")
    assert watcher.phases[0] == "waiting"
    assert watcher.phases[-1] == "over"
    assert "flying" in watcher.phases
    assert watcher.numbers == list(range(watcher.numbers[0], watcher.numbers[-1] + 1))
    assert watcher.last["step"] == 150
    assert watcher.last["error_deg"] < 5.0  # of 43: a slow machine misses deadlines
    assert (watcher.setup["n_steps"], watcher.setup["torque_limit"]) == (150, 0.01)
    times = [row[0] for row in watcher.rows]
    assert times[0] == 0.0
    assert times == sorted(set(times))
    assert len(times) > 100


def test_watch_follows_a_flight_to_its_end(graph: Any) -> None:
    chosen = free_domain()
    with gnc("inspect", "watch", "--domain-id", chosen, "--timeout", "60") as watch:
        graph.fly(
            "plant.mode=free_run",
            "plant.real_time_factor=12",
            SHORT,
            f"launcher.domain_id={chosen}",
            record=False,
        )
        out, err = watch.communicate(timeout=PATIENCE)
    assert (watch.returncode, err) == (0, "")
    lines = out.splitlines()
    assert lines[0].startswith("flying, step ")
    assert lines[-1].startswith("over, step 150, t = 60.0 s, ")
    assert "(optimal)" in out


def test_on_a_terminal_it_is_a_dashboard_that_ctrl_c_ends(graph: Any, at: Any) -> None:
    chosen = free_domain()
    ours, theirs = pty.openpty()
    seen: list[bytes] = []
    whole = threading.Event()

    def read() -> None:
        while True:
            try:
                seen.append(os.read(ours, 65536))
            except OSError:  # the other end was closed
                return
            if b"deadlines missed" in b"".join(seen):
                whole.set()

    command = ("inspect", "watch", "--domain-id", chosen, "--timeout", "60")
    with gnc(*command, terminal=theirs) as watch:
        os.close(theirs)
        threading.Thread(target=read, daemon=True).start()

        def interrupt(_: Any) -> None:
            assert whole.wait(PATIENCE)
            watch.send_signal(signal.SIGINT)
            assert watch.wait(PATIENCE) == 0

        graph.fly(
            "plant.mode=free_run",
            "plant.real_time_factor=10",
            "plant.duration=40.0",
            f"launcher.domain_id={chosen}",
            record=False,
            display=at(20, interrupt),
        )
    os.close(ours)
    text = b"".join(seen).decode(errors="replace")
    assert "\x1b[" in text
    assert "flying" in text
    assert "error to reference" in text
    assert "Traceback" not in text
