"""A turn of 30 deg from rest with defaults only, over 11 decades of inertia and 9 of torque.

    .venv/bin/python benchmarks/defaults.py            # each pair of decades, each body
    .venv/bin/python benchmarks/defaults.py --corners  # as the tests do: corners and middle

A scenario names inertia, ``max_torque`` and start, nothing else. Each flight has to settle to
0.1 deg within its own duration, at most 0.1 % over its torque limit. Exit code 1: one does not.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Final, NamedTuple

import numpy as np

from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.scenario import from_sections
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.prediction import predict

ANGLE: Final = 30.0  # [deg]
AXIS: Final = np.array([1.0, 2.0, -1.0]) / np.sqrt(6.0)
LARGEST_EXCESS: Final = 1e-3
MOMENTS: Final = tuple(10.0**k for k in range(-3, 9))  # [kg m^2]
TORQUES: Final = tuple(10.0**k for k in range(-6, 4))  # [N m]
BODIES: Final = {
    "diagonal": np.diag([1.0, 0.8, 0.8]),
    "full": np.array([[1.0, 0.1, -0.05], [0.1, 0.8, 0.07], [-0.05, 0.07, 0.6]]),
    "rod": np.diag([1.0, 1.0, 0.05]),
}
CORNERS: Final = ((1e-3, 1e-6), (1e-3, 1e3), (1e2, 1e-2), (1e8, 1e-6), (1e8, 1e3))


class Turn(NamedTuple):
    """A flight, in shares of its own scales."""

    body: str
    moment: float
    torque: float
    settled: float
    """Time under 0.1 deg for good over ``settling_time``; NaN: never."""
    predicted: float
    """The same of the prediction."""
    excess: float
    """Largest torque over its limit, less one."""
    failed: int
    """Steps without a solution."""

    @property
    def holds(self) -> bool:
        """Whether it settles and keeps its limit."""
        return self.settled < 3.0 and self.excess <= LARGEST_EXCESS


def turn(body: str, moment: float, torque: float) -> Turn:
    """Fly a body of that size."""
    sections = {
        "plant": {
            "inertia": (moment * BODIES[body]).ravel(),
            "initial_rotation_vector": np.radians(ANGLE) * AXIS,
        },
        "nmpc_controller": {"max_torque": torque},
    }
    scenario = from_sections(sections)
    told, wanted = predict(scenario), scenario.controller.settling_time
    metrics = summarize(scenario.build().run(), scenario)
    settled = metrics["settle_time_0.1deg"]
    return Turn(
        body,
        moment,
        torque,
        np.nan if settled is None else settled / wanted,
        np.nan if told is None else told.settling_time / wanted,
        metrics["max_torque"] / torque - 1.0,
        metrics["steps"] - metrics["sources"].get("OPTIMAL", 0),
    )


def turns(pairs: Array) -> Iterator[Turn]:
    """Fly every body at every pair of moment and torque."""
    for body in BODIES:
        for moment, torque in pairs:
            yield turn(body, float(moment), float(torque))


def main() -> int:
    """Fly the sweep and print what each body does at the worst."""
    pairs = CORNERS if "--corners" in sys.argv else [(j, u) for j in MOMENTS for u in TORQUES]
    flown = list(turns(np.array(pairs)))
    print("body      flights  settled [settling times]  predicted   largest excess  not solved")
    for body in BODIES:
        own = [t for t in flown if t.body == body]
        settled, told = (np.array([getattr(t, n) for t in own]) for n in ("settled", "predicted"))
        print(
            f"{body:<9} {len(own):7d}  {settled.min():.3f} to {settled.max():.3f}          "
            f"{told.min():.3f} to {told.max():.3f}  {max(t.excess for t in own):14.2e}  "
            f"{sum(t.failed for t in own):10d}"
        )
    bad = [t for t in flown if not t.holds]
    for t in bad:
        print(f"fails: {t}")
    print(f"{len(flown) - len(bad)} of {len(flown)} settle within their duration and limit")
    return 1 if bad else 0


if __name__ == "__main__":
    raise SystemExit(main())
