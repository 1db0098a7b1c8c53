"""Where the time of a flight goes: from parameters to metrics, part by part.

    .venv/bin/python benchmarks/flight_parts.py [SCENARIO] [FLIGHTS]

Flies FLIGHTS (200) times SCENARIO (gupta2015_case1) of a rigid body with other rotations, momenta
and inertias, as a worker of a campaign does, in one thread, and prints the median of each part. CPU
times of the process: other work on the machine counts little.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from time import process_time
from typing import Any, Final, NamedTuple

import numpy as np

from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.scenario import Template, load
from spacecraft_gnc.types import Array

SEED: Final = 1
LARGEST_ANGLE: Final = 1.5  # [rad], which every flight of Case I has the time for
LARGEST_MOMENTUM: Final = 5e-3  # [N m s]
SPREAD: Final = 0.1  # of the principal moments
NAMES: Final = (
    "scenario of the template",
    "cores built",
    "flown at once",
    "metrics",
    "all of these",
    "(scenario read by `load`)",
    "(flown step by step)",
)


class Part(NamedTuple):
    """What one part of a flight took."""

    name: str
    times: Array
    """(n,) CPU times [s]."""

    def __str__(self) -> str:
        """Return the median and the 99th percentile in milliseconds."""
        median, late = 1e3 * np.quantile(self.times, [0.5, 0.99])
        return f"{self.name:<28} {median:8.2f} {late:8.2f}"


def variations(scenario: str, n: int) -> Iterator[dict[str, Any]]:
    """Yield the parameters of n flights."""
    random = np.random.default_rng(SEED)
    nominal = np.asarray(load(scenario).plant.inertia)
    for _ in range(n):
        turn, momentum = random.normal(size=(2, 3))
        turn *= random.uniform(0.0, LARGEST_ANGLE) / np.linalg.norm(turn)
        momentum *= random.uniform(0.0, LARGEST_MOMENTUM) / np.linalg.norm(momentum)
        scale = np.diag(np.sqrt(random.uniform(1.0 - SPREAD, 1.0 + SPREAD, 3)))
        yield {
            "plant.initial_rotation_vector": turn.tolist(),
            "plant.initial_momentum": momentum.tolist(),
            "plant.inertia": (scale @ nominal @ scale).ravel().tolist(),
        }


class Clock:
    """Notes the CPU times between calls."""

    def __init__(self) -> None:
        self.times: list[float] = []
        self._last = process_time()

    def note(self) -> None:
        """Note the time since the last call [s]."""
        now = process_time()
        self.times.append(now - self._last)
        self._last = now


def parts(scenario: str, n: int) -> list[Part]:
    """Fly n times and return what each part took; the last two parts by themselves."""
    template, flown, otherwise = Template(scenario), [], []
    for overrides in variations(scenario, n + 1):
        clock = Clock()
        made = template.scenario(overrides)
        clock.note()
        loop = made.build()
        clock.note()
        flight = loop.run()
        clock.note()
        summarize(flight, made)
        clock.note()
        flown.append([*clock.times, sum(clock.times)])
    for overrides in variations(scenario, n + 1):
        clock = Clock()
        made = load(scenario, overrides)
        clock.note()
        loop = made.build()
        clock.note()
        loop.run()
        clock.note()
        otherwise.append(clock.times[::2])
    times = np.hstack([flown, otherwise])[1:]  # the first ones load the kernels
    return [Part(*each) for each in zip(NAMES, times.T, strict=True)]


def main() -> int:
    """Print the table."""
    given = sys.argv[1:]
    scenario, n = (given[0] if given else "gupta2015_case1"), int(given[1]) if given[1:] else 200
    print(f"{n} flights of {scenario}: CPU time of each part, median and 99 % [ms]")
    table = parts(scenario, n)
    for part in table:
        print(part)
    print(f"{1.0 / np.median(table[4].times):.0f} flights/s on one core")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
