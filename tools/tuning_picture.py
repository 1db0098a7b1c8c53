"""Draw docs/pictures/tuning.png: effect of settling time, weights and horizon on a 30 deg slew.

`.venv/bin/python tools/tuning_picture.py` writes it and prints the figures of docs/tuning.md.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np

from spacecraft_gnc.drawing import style
from spacecraft_gnc.scenario import Scenario, from_sections
from spacecraft_gnc.vehicles.rigid_body import series
from spacecraft_gnc.vehicles.rigid_body.prediction import predict

mpl.use("Agg")
import matplotlib.pyplot as plt

PICTURE = Path(__file__).resolve().parents[1] / "docs" / "pictures" / "tuning.png"
INERTIA = [1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]  # [kg m^2]
LIMIT = 0.01  # [N m]
TURN = np.radians(30.0) * np.array([1.0, 2.0, -1.0]) / np.sqrt(6.0)
WEIGHTS = (
    "stage_attitude", "stage_momentum", "stage_torque", "terminal_attitude", "terminal_momentum"
)  # fmt: skip
CASE_1 = {
    "stage_attitude": 0.01,
    "stage_momentum": 0.01,
    "stage_torque": 1.0,
    "terminal_attitude": 0.01,
    "terminal_momentum": 0.01,
}
FACTORS = np.logspace(-1.5, 1.5, 25)
HORIZONS = (2, 3, 4, 5, 6, 8, 10, 12, 15, 20, 25, 30, 40, 50, 60)


def scenario(**controller: Any) -> Scenario:
    """Return the slew with defaults, except for the given values."""
    start = controller.pop("start", TURN)
    plant = {"inertia": INERTIA, "initial_rotation_vector": start, "time_step": 0.5}
    plant["duration"] = controller.pop("duration", 150.0)
    return from_sections({"plant": plant, "nmpc_controller": {"max_torque": LIMIT, **controller}})


def settled(**controller: Any) -> float:
    """Return the predicted settling time [s] to 0.1 deg; NaN: never."""
    found = predict(scenario(**controller))
    return np.nan if found is None or np.isinf(found.settling_time) else found.settling_time


def draw_settling(axes: Any) -> None:
    """Fly the slew with several settling times."""
    print("settling_time  flown to 0.1 deg  predicted")
    for wanted, color in zip((20.0, 40.0, 80.0), style.RUN_COLORS, strict=False):
        built = scenario(settling_time=wanted, duration=130.0)
        flight = built.build().run()
        error = series.settling_error_deg(flight)
        axes.semilogy(series.state_times(flight), error, color=color, label=f"{wanted:g} s")
        late = np.flatnonzero(error >= 0.1)[-1] + 1
        print(f"{wanted:10g} s  {late * built.period:14g} s  {settled(settling_time=wanted):7g} s")
    axes.axhline(0.1, color=style.MUTED, linewidth=0.8)
    axes.set(xlabel="time [s]", ylabel="attitude error [deg]", ylim=(1e-3, 50.0), xlim=(0, 130))
    axes.set_title("settling_time, everything else default")
    axes.legend()


def draw_weights(axes: Any, horizon: int) -> None:
    """Multiply one weight at a time."""
    plain = scenario(horizon=horizon).controller.weights
    print(f"horizon {horizon}: factor {FACTORS[0]:.3g} to {FACTORS[-1]:.3g} on one weight")
    for name, color in zip(WEIGHTS, style.RUN_COLORS, strict=False):
        base = {each: getattr(plain, each).ravel() for each in WEIGHTS}
        times = [
            settled(horizon=horizon, weights=base | {name: factor * base[name]})
            for factor in FACTORS
        ]
        axes.loglog(FACTORS, times, color=color, label=name)
        print(f"  {name:18s} {times[0]:7g} s to {times[-1]:7g} s")
    axes.set(xlabel="factor on one weight", ylabel="settles after [s]", ylim=(15.0, 1200.0))
    axes.set_title(f"Each weight alone, horizon {horizon} steps of 0.5 s")
    axes.legend(loc="upper center", ncols=2)


def draw_horizon(axes: Any) -> None:
    """Change the horizon alone, with weights that follow from it and with those of Case I."""
    fixed = {each: getattr(scenario().controller.weights, each).ravel() for each in WEIGHTS}
    kinds = {
        "weights left to their formulas": {},
        "the same weights at every horizon (those of 20)": {"weights": fixed},
        "weights of Gupta et al. 2015, Case I": {"weights": CASE_1, "torque_penalty": 1.0e10},
    }
    print(f"horizons {HORIZONS}")
    for (label, controller), color in zip(kinds.items(), style.RUN_COLORS, strict=False):
        times = [settled(horizon=n, **controller) for n in HORIZONS]
        axes.semilogy(HORIZONS, times, "o-", markersize=3.5, color=color, label=label)
        print(f"  {label}: {', '.join(f'{time:g}' for time in times)} s")
    axes.set(xlabel="horizon [steps of 0.5 s]", ylabel="settles after [s]", ylim=(15.0, 1200.0))
    axes.set_title("horizon alone")
    axes.legend()


def print_turns() -> None:
    """Fly longer slews with half, one and two times the default settling time."""
    print("settling_time, turn: settled, overshoot, excess of the torque limit")
    for wanted in (20.0, 40.0, 80.0):
        for angle in (30.0, 90.0, 170.0):
            start = TURN * angle / 30.0
            built = scenario(settling_time=wanted, duration=300.0, start=start)
            flight = built.build().run()
            error = series.settling_error_deg(flight)
            late = (np.flatnonzero(error >= 0.1)[-1] + 1) * built.period
            over = (error - np.minimum.accumulate(error)).max()
            torque = np.linalg.norm(flight.torque, axis=1).max()
            excess = max(0.0, torque / LIMIT - 1.0)
            print(f"{wanted:g} s, {angle:g} deg: {late:g} s, {over:.2f} deg, {excess:.1e}")


def main() -> None:
    """Draw the four panels."""
    print_turns()
    with style.applied():
        figure, axes = plt.subplots(2, 2, figsize=(10.0, 7.6), layout="constrained")
        draw_settling(axes[0, 0])
        draw_horizon(axes[0, 1])
        draw_weights(axes[1, 0], 5)
        draw_weights(axes[1, 1], 40)
        figure.savefig(PICTURE, dpi=110)
    print(f"written: {PICTURE.name}")


if __name__ == "__main__":
    main()
