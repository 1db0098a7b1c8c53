"""Docking scenarios for tests: time-invariant, so that there is one admissible set."""

from __future__ import annotations

from pathlib import Path

from spacecraft_gnc.scenario import load

CONFIG = Path(__file__).parents[1] / "config"
QUICK = {
    "nmpc_controller.method": "time_invariant_lqr",
    "reference_governor.governor": "time_invariant",
    "reference_governor.steady_share": 0.9,
}
"""One set of 80 steps instead of 200 of 100: about the same flight."""


def scenario(name="afrl_docking", **changes):
    """Return a shipped scenario with parameters changed: ``plant__seed=1``."""
    given = {key.replace("__", "."): value for key, value in changes.items()}
    return load(CONFIG / f"{name}.yaml", given)


def quick(name="afrl_docking", **changes):
    """Return a shipped scenario with one admissible set."""
    given = {key.replace(".", "__"): value for key, value in QUICK.items()}
    return scenario(name, **(given | changes))
