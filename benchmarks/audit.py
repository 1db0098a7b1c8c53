"""How long `gnc audit` takes, and how much memory: a bag of 375 steps, and one of 100,000.

    python benchmarks/audit.py [--steps 375 100000] [--runs 3] [--folder FOLDER] [--scenario FILE]

The flight is that of a scenario, flown by the cores as `gnc simulate` does and as long as asked;
its messages are serialized by the nodes' own encoders and recorded by their own writer. The audit
runs in a process of its own: the time is that of the whole command, imports included, and the
memory the largest resident set that the system counts. Needs the messages built (`make setup`).
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from spacecraft_gnc.loop.protocols import Command, GovernorDecision, Plant, Source, State
from spacecraft_gnc.recording.writer import BagWriter
from spacecraft_gnc.ros.bag_topics import announce
from spacecraft_gnc.scenario import Scenario, load
from spacecraft_gnc.signals import Signal, graph
from spacecraft_gnc.signals.graph import CLOCK
from spacecraft_gnc.signals.message import period_ns, stamp_of
from spacecraft_gnc.types import Vector3
from spacecraft_gnc.vehicles.rigid_body.outputs import Outputs
from spacecraft_gnc.vehicles.rigid_body.signals import SIGNALS

CASE = Path(__file__).parents[1] / "config" / "gupta2015_case1.yaml"
MIB = 1024.0  # KiB


class Recording:
    """The messages of a flight on their way into a bag."""

    def __init__(self, bag: BagWriter, scenario: Scenario) -> None:
        self._bag = bag
        self._period_ns = period_ns(scenario.period)
        self._outputs = Outputs(scenario)
        for signal in (*SIGNALS, *graph.SIGNALS):  # a recorder announces every one that it takes
            if signal.recorded:
                topic, gapless = f"/{signal.name.strip('/')}", signal.every_step
                announce(bag, topic, signal.type, [signal.qos], gapless=gapless)

    def setup(self) -> None:
        """Record what a controller tells once."""
        self._write(0, self._outputs.setup())

    def _write(self, step: int, told: Iterable[tuple[Signal, Any]]) -> None:
        seconds, nanoseconds = stamp = stamp_of(step, self._period_ns)
        log_time = seconds * 1_000_000_000 + nanoseconds
        for signal, value in told:
            if signal.recorded:
                data = signal.encode(stamp, step, value)
                topic = f"/{signal.name.strip('/')}"
                self._bag.write(topic, log_time, log_time, data)

    def state(self, plant: Plant, applied: tuple[Vector3, Source]) -> None:
        """Record what the plant publishes."""
        step = plant.state.step
        self._write(step, plant.outputs(applied))
        if step < plant.n_steps:
            self._write(step, [(CLOCK, [stamp_of(step, self._period_ns)])])

    def answers(self, state: State, decision: GovernorDecision, command: Command) -> None:
        """Record what governor and controller publish."""
        self._write(state.step, self._outputs.governor(decision))
        wall = (1e-4, np.nan)
        told = self._outputs.controller(state, decision.reference, command, wall)
        self._write(state.step, told)


def make_bag(folder: Path, file: Path, steps: int) -> Path:
    """Fly a scenario for so many steps, and record it."""
    period = load(file).period
    scenario = load(file, [f"plant.duration={steps * period!r}"])
    loop = scenario.build()
    for core in (loop.plant, loop.controller, loop.governor):
        core.warm_up()
        core.reset()
    with BagWriter(folder / "bag") as bag:
        bag.attach("scenario.yaml", "application/yaml", scenario.to_yaml().encode())
        recording = Recording(bag, scenario)
        recording.setup()
        applied = (np.zeros(3), Source.ZERO)
        for _ in range(steps):
            state = loop.plant.state
            recording.state(loop.plant, applied)
            decision = loop.governor.decide(state)
            command = loop.controller.command(state, decision.reference)
            recording.answers(state, decision, command)
            applied = (command.control, command.source)
            loop.plant.step(command.control)
        recording.state(loop.plant, applied)
    return folder / "bag"


def measure(bag: Path) -> tuple[float, float]:
    """Audit a bag in a process of its own; return seconds and MiB."""
    command = [sys.executable, "-m", "spacecraft_gnc", "audit", str(bag), "--quiet"]
    started = time.perf_counter()
    process = subprocess.Popen(command, cwd=CASE.parents[1])
    _, status, usage = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - started
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise SystemExit(f"{bag}: the audit ended with {process.returncode}; required 0")
    return seconds, usage.ru_maxrss / MIB


def main() -> None:
    """Print a line for each length."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=int, nargs="+", default=[375, 100_000])
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--scenario", type=Path, default=CASE)
    parser.add_argument("--folder", type=Path, help="where the bags are made and left")
    options = parser.parse_args()
    with TemporaryDirectory(prefix="gnc_audit_") as temporary:
        for steps in options.steps:
            folder = (options.folder or Path(temporary)) / str(steps)
            if not folder.exists():
                make_bag(folder, options.scenario, steps)
            size = sum(file.stat().st_size for file in folder.rglob("*.mcap")) / MIB**2
            runs = [measure(folder / "bag") for _ in range(options.runs)]
            seconds, memory = (min(values) for values in zip(*runs, strict=True))
            print(
                f"{steps:7d} steps, {size:7.1f} MiB: {seconds:6.2f} s, {memory:6.0f} MiB "
                f"(best of {options.runs})",
                flush=True,
            )
            if options.folder is None:
                shutil.rmtree(folder)


if __name__ == "__main__":
    main()
