"""Long flights: memory of every process, cost of the seals, test runs in a row."""

from __future__ import annotations

import re
import subprocess
import sys
import time
from argparse import Namespace
from collections import defaultdict
from pathlib import Path
from statistics import median
from typing import Any, Final, NamedTuple

import numpy as np
import psutil
from hostile_checks import audit_failures
from hostile_flight import NODES, ROOT, Flight, Late, Row

from spacecraft_gnc.recording.timing import read_latencies

_SAMPLE: Final = 0.5  # [s] wall between two looks at the memory
_SETTLED: Final = 0.3  # of the flight, after which memory must no longer grow
_MOST_GROWTH: Final = 1.0  # [MB per 1e5 steps]
_PER_CHUNK: Final = 1e-3  # [MB] of the bag's index, which is written at the end
_BEST: Final = 0.95  # of the rate without seals, at least
_LONG: Final = 4 * 3600.0  # [s] wall


def soak(options: Namespace) -> list[Row]:
    """Fly long, recorded and not, and look at the memory of each process."""
    return [_soaked(options, record=True), _soaked(options, record=False)]


def _soaked(options: Namespace, *, record: bool) -> Row:
    steps = int(options.steps)
    name = f"soak, {'' if record else 'un'}recorded"
    samples: dict[str, list[tuple[int, float]]] = defaultdict(list)
    with Flight(options.folder / name.replace(", ", "_"), steps=steps, record=record) as flight:
        try:
            flight.observe()
            flight.wait_step(1)
            deadline = time.monotonic() + _LONG
            while "plant" in flight.running() and time.monotonic() < deadline:
                step = flight.progress()["step"]
                for node, size in sizes(flight).items():
                    samples[node].append((step, size))
                time.sleep(_SAMPLE)
            code = flight.wait_end()
        except Late as error:
            return Row(name, "a long flight in lockstep", steps, "", str(error), False)
    growth = {node: _growth(np.array(told), steps) for node, told in samples.items()}
    index = _index(flight) / (steps / 1e5) if record and code == 0 else 0.0
    if record:
        growth["recorder"] -= index
    problem = audit_failures(flight.bag) if record and code == 0 else ""
    told = ", ".join(f"{node} {value:+.2f}" for node, value in growth.items())
    return Row(
        name,
        "a long flight in lockstep",
        steps,
        f"growth below {_MOST_GROWTH:g} MB per 1e5 steps beside the bag's index"
        + ("; audit passes" if record else ""),
        f"MB per 1e5 steps: {told}"
        + (f" (beside {index:.2f} of index)" if record else "")
        + (f"; audit: {problem or 'passes'}" if record else "")
        + (f"; exit code {code}" if code else ""),
        code == 0 and not problem and max(growth.values()) < _MOST_GROWTH,
    )


def sizes(flight: Flight) -> dict[str, float]:
    """Return the resident memory of each process [MB]."""
    found = {}
    for name in flight.running():
        try:
            process = psutil.Process(flight.pid) if name == "launcher" else flight.node(name)
            found[name] = process.memory_info().rss / 1e6
        except (psutil.Error, Late):
            continue
    return found


def _growth(told: Any, steps: int) -> float:
    """Return the slope of (step, MB), once settled [MB per 1e5 steps]."""
    settled = told[told[:, 0] >= _SETTLED * steps]
    if len(settled) < 3 or np.ptp(settled[:, 0]) == 0.0:
        return 0.0
    return float(1e5 * np.polyfit(settled[:, 0], settled[:, 1], 1)[0])


def _index(flight: Flight) -> float:
    """Return the memory of the bag's index, which the recorder holds until the end [MB]."""
    from mcap.reader import make_reader

    with next(flight.bag.glob("*.mcap")).open("rb") as stream:
        summary = make_reader(stream).get_summary()
    return _PER_CHUNK * len(summary.chunk_indexes) if summary else 0.0


class Cost(NamedTuple):
    """What the steps of a flight took."""

    rate: float
    """[steps/s]"""
    latency: float
    """State to command, median [s]."""
    processor: float
    """Of all nodes, for a step [s]."""


def guards(options: Namespace) -> list[Row]:
    """Fly with and without a key in turn, and compare rates, latencies and processor times."""
    found: dict[bool, list[Cost]] = {True: [], False: []}
    for number in range(int(options.rounds)):
        for sealed in (number % 2 == 0, number % 2 == 1):
            out = options.folder / f"guards-{number}-{sealed}"
            try:
                found[sealed].append(_cost(out, int(options.round_steps), sealed=sealed))
            except Late as error:
                return [Row(_GUARDS, "", 0, "", str(error), False)]
    own, bare = (Cost(*map(median, zip(*found[key], strict=True))) for key in (True, False))
    ratio = own.rate / bare.rate
    return [
        Row(
            _GUARDS,
            "flights in lockstep with and without a key, in turn",
            int(options.rounds),
            f"at least {_BEST:g} of the steps a second without",
            f"{own.rate:.0f} and {bare.rate:.0f} steps/s with and without, ratio {ratio:.3f}; "
            f"state to command {1e3 * own.latency:.3f} and {1e3 * bare.latency:.3f} ms; "
            f"processor time {1e3 * own.processor:.3f} and {1e3 * bare.processor:.3f} ms a step",
            ratio >= _BEST,
        )
    ]


_GUARDS: Final = "cost of the seals"
_RATE: Final = re.compile(r"(\d+) steps/s")


def _cost(out: Path, steps: int, *, sealed: bool) -> Cost:
    """Fly once; the processor time is that between a tenth and nine tenths of the flight."""
    with Flight(out, steps=steps, sealed=sealed) as flight:
        flight.observe()
        spent = []
        for share in (0.1, 0.9):
            flight.wait_step(int(share * steps))
            spent.append((flight.progress()["step"], processor_time(flight)))
        code = flight.wait_end(300.0)
        if code != 0:
            raise Late(f"exit code {code}: {flight.errors.text[-300:]}")
        rate = float(_RATE.findall(flight.output.text)[0])
    latency = float(np.median(read_latencies(flight.bag)))
    (first, before), (last, after) = spent
    each = (after - before) / (last - first)
    return Cost(rate, latency, each)


def processor_time(flight: Flight) -> float:
    """Return the processor time of all nodes so far [s]."""
    return sum(sum(flight.node(name).cpu_times()[:2]) for name in NODES)


def repeat(options: Namespace) -> list[Row]:
    """Run test/graph again and again."""
    command = [sys.executable, "-m", "pytest", "-q", "-x", "test/graph"]
    passed, told = 0, "all passed"
    for _ in range(int(options.runs)):
        done = subprocess.run(
            command, cwd=ROOT, capture_output=True, text=True, timeout=_LONG, check=False
        )
        if done.returncode:
            told = " ".join(done.stdout.splitlines()[-3:])[-300:]
            break
        passed += 1
    runs = int(options.runs)
    return [
        Row(
            "test/graph in a row",
            "runs of all of it",
            runs,
            "no failure",
            f"{passed} of {runs}: {told}",
            passed == runs,
        )
    ]
