"""What `gnc check` refuses of a docking scenario, with which words, and the hold behind it."""

from __future__ import annotations

import math
import re
import sys
from typing import Any

import numpy as np
import pytest

from spacecraft_gnc import lie
from spacecraft_gnc.scenario import InvalidScenario, from_sections
from spacecraft_gnc.vehicles.docking.admissible import MOST_STEPS
from spacecraft_gnc.vehicles.docking.holding import (
    DOCKED,
    PHASES,
    Limits,
    Pose,
    hold_wrench,
    largest_spin_rate,
    use_of,
)

TILTED = {
    "chief_spin_axis": [1.0, 0.5, 2.0],
    "chief_initial_rotation_vector": [0.4, -0.2, 0.7],
    "inertia": [12.0, 1.0, -0.5, 1.0, 9.0, 0.3, -0.5, 0.3, 8.0],
}
EARTH = 3.986004418e14  # [m^3/s^2]


def sections(**changes: Any) -> dict[str, dict[str, Any]]:
    """Return a scenario without sets, by section; a name may begin with ``governor_``."""
    governor = {
        key.removeprefix("governor_"): value
        for key, value in changes.items()
        if key.startswith("governor_")
    }
    plant = {key: value for key, value in changes.items() if not key.startswith("governor_")}
    return {
        "plant": {"vehicle": "docking", **plant},
        "reference_governor": {"governor": "periodic", **governor},
    }


def problems(**changes: Any) -> list[str]:
    """Return what is refused, "key: received ..." by line."""
    with pytest.raises(InvalidScenario) as refused:
        from_sections(sections(**changes))
    told = [str(problem).removeprefix("parameters: ") for problem in refused.value.problems]
    assert all(len(line.splitlines()) == 1 for line in told)
    return told


def plant_of(**changes: Any) -> Any:
    return from_sections(sections(**changes)).plant


@pytest.mark.parametrize(
    ("changes", "key", "words"),
    [
        ({"chief_port": [0.5, 0.0, 0.2]}, "plant.chief_port", "0.02 m behind that face"),
        ({"chief_port": [0.52, 0.7, 0.2]}, "plant.chief_port", "outside the body by 0.125 m"),
        ({"chief_port": [-0.52, 0.0, 0.2]}, "plant.chief_port", "1.04 m behind that face"),
        ({"deputy_port": [0.0, 0.0, 0.0]}, "plant.deputy_port", "0.3 m behind that face"),
        ({"deputy_port": [0.3, 0.0, 0.1]}, "plant.deputy_port", "face -x of the deputy"),
        ({"max_force": 0.0}, "plant.max_force", "> 0"),
        ({"max_moment": 0.0}, "plant.max_moment", "> 0"),
        ({"max_force": 1e-6}, "plant.max_force", "raise it"),
        (
            {"initial_port_offset": [2.0, 4.0, 0.0]},
            "plant.initial_port_offset",
            "leaves by 2.795 m",
        ),
        ({"initial_port_offset": [-1.0, 0.0, 0.0]}, "plant.initial_port_offset", "0.98 m"),
        (
            {"initial_port_offset": [0.1, 0.0, 0.0], "initial_rotation_vector": [0.0, 0.0, 0.5]},
            "plant.initial_port_offset",
            "every vertex of the deputy",
        ),
        (
            {"governor_target_port_offset": [1.0, 2.0, 0.0]},
            "reference_governor.target_port_offset",
            "line-of-sight",
        ),
        (
            {"governor_hold_port_offset": [0.0, 0.0, 3.0]},
            "reference_governor.hold_port_offset",
            "line-of-sight",
        ),
        (
            {"governor_target_port_offset": [800.0, 0.0, 0.0]},
            "reference_governor.target_port_offset",
            "to hold",
        ),
        ({"governor_force_margin": 1.0}, "reference_governor.force_margin", "less than max_force"),
        (
            {"governor_distance_margin": 0.03},
            "reference_governor.distance_margin",
            "less than clearance_tolerance",
        ),
        ({"thruster_lost_at": 3.0}, "plant.thruster_lost_at", "thruster_lost beside it"),
        (
            {"thruster_lost": "+x", "thruster_lost_at": 600.0},
            "plant.thruster_lost_at",
            "last control step (595 s)",
        ),
        ({"chief_spin_rate": 1e-6}, "plant.chief_spin_rate", f"at most {MOST_STEPS} control"),
    ],
)
def test_what_cannot_fly_is_refused_in_a_line(
    changes: dict[str, Any], key: str, words: str
) -> None:
    told = problems(**changes)
    assert all(line.startswith(f"{key}: received ") for line in told)
    assert any(words in line for line in told)


def test_a_rotation_of_no_whole_number_of_periods_is_refused_with_rates_that_are() -> None:
    (told,) = problems(chief_spin_rate=0.0065)
    rates = [float(rate) for rate in re.findall(r"(\d\.\d+) \(\d+ control periods\)", told)]
    assert len(rates) == 2
    assert rates[0] > 0.0065 > rates[1]
    for rate in rates:
        assert plant_of(chief_spin_rate=rate).chief_spin_rate == rate


def test_too_fast_a_chief_is_refused_with_a_rate_that_works() -> None:
    (told,) = problems(chief_spin_rate=0.2)
    assert "4.316 N of 0.99 N" in told
    rate = float(re.findall(r"lower it to (\S+) or less, or raise max_force", told)[0])
    most = float(re.findall(r"at most (\S+) rad/s", told)[0])
    assert rate <= most
    (warned,) = from_sections(sections(chief_spin_rate=rate)).warnings
    assert "initial_port_offset" in str(warned)  # the start is farther out than the hold point


def test_the_largest_rate_is_where_the_limit_is_met() -> None:
    plant, limits = plant_of(chief_spin_axis=[0.0, 0.3, 1.0]), Limits(0.5, 0.02)
    fast = from_sections(sections()).plant
    object.__setattr__(fast, "chief_spin_rate", 0.5)
    most = largest_spin_rate(fast, DOCKED, limits)
    assert most is not None
    assert max(use_of(limits, hold_wrench(fast, DOCKED, most))) == pytest.approx(1.0, abs=1e-9)
    assert largest_spin_rate(plant, DOCKED, limits) == plant.chief_spin_rate
    assert largest_spin_rate(plant, DOCKED, Limits(1e-9, 1.0)) is None


def test_warnings_of_what_may_be_flown_on_purpose() -> None:
    lost = {"thruster_lost": "+x", "thruster_lost_at": 60.0}
    for changes, words in (
        ({**lost, "governor_aborts": False}, "aborts: false"),
        ({"position_noise": 0.01}, "with no margin"),
        ({"initial_port_offset": [200.0, 0.0, 0.0]}, "to hold"),
    ):
        (warning,) = from_sections(sections(**changes)).warnings
        assert words in warning
    assert not from_sections(sections(**lost)).warnings
    assert not from_sections(sections(position_noise=0.01, governor_force_margin=0.1)).warnings


@pytest.mark.parametrize("gravity_gradient", [False, True])
def test_the_hold_is_that_of_motion_in_an_inertial_frame(gravity_gradient: bool) -> None:
    plant = plant_of(gravity_gradient=gravity_gradient, **TILTED)
    pose = Pose(np.array([2.0, 0.4, -0.3]), np.array([0.3, -0.2, 0.25]))
    n, w = plant.mean_motion, plant.chief_spin_rate
    axis = plant.chief_spin_axis / np.linalg.norm(plant.chief_spin_axis)
    first, radius = lie.exp(plant.chief_initial_rotation_vector), (EARTH / n**2) ** (1.0 / 3.0)
    R_CD = lie.exp(pose.rotation_vector)
    center = plant.chief_port + pose.port_offset - R_CD @ plant.deputy_port
    z = np.array([0.0, 0.0, 1.0])

    def inertial(t: float) -> Any:
        return lie.exp(n * t * z) @ lie.exp(w * t * axis) @ first

    def chief(t: float) -> Any:
        return radius * lie.exp(n * t * z)[:, 0]

    def spin(t: float) -> Any:
        return n * z + lie.exp(n * t * z) @ (w * axis)

    def momentum(t: float) -> Any:
        J = inertial(t) @ R_CD @ plant.inertia @ R_CD.T @ inertial(t).T
        return J @ spin(t)

    held = hold_wrench(plant, pose)
    for phase in (0, 37, 200):
        t, h = phase / PHASES * 2.0 * math.pi / w, 2.0
        attitude, at = inertial(t), chief(t)
        around = [inertial(t + k * h) @ center for k in (-2, -1, 0, 1, 2)]
        acceleration = np.array([-1.0, 16.0, -30.0, 16.0, -1.0]) @ around / (12.0 * h**2)
        away = at + attitude @ center
        gravity = EARTH * (at / radius**3 - away / np.linalg.norm(away) ** 3)
        force = plant.mass * attitude.T @ (acceleration - gravity)
        turned = [momentum(t + k * h) for k in (-2, -1, 1, 2)]
        moment = attitude.T @ (np.array([1.0, -8.0, 8.0, -1.0]) @ turned / (12.0 * h))
        if gravity_gradient:
            x = attitude.T @ at / radius
            J = R_CD @ plant.inertia @ R_CD.T
            moment -= 3.0 * n**2 * np.cross(x, J @ x)
        np.testing.assert_allclose(held[phase, :3], force, atol=2e-7)
        np.testing.assert_allclose(held[phase, 3:], moment, atol=1e-11)


def test_a_check_loads_no_kernels() -> None:
    """The modules of the checks import none; `gnc check` itself may build a governor."""
    import subprocess

    code = (
        "import sys; from spacecraft_gnc.scenario import from_sections;"
        "from spacecraft_gnc.vehicles.docking.facts import facts;"
        "facts(from_sections({'plant': {'vehicle': 'docking'}}), None);"
        "print('numba' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"


@pytest.mark.parametrize(
    ("governor", "method", "fits"),
    [
        ("periodic", "periodic_lqr", True),
        ("time_invariant", "time_invariant_lqr", True),
        ("none", "time_invariant_lqr", True),
        ("periodic", "time_invariant_lqr", False),
        ("time_invariant", "periodic_lqr", False),
    ],
)
def test_a_governor_of_another_law_is_warned_of(governor, method, fits) -> None:
    scenario = sections(governor_governor=governor) | {"nmpc_controller": {"method": method}}
    told = [line for line in from_sections(scenario).warnings if "of whose loop" in str(line)]
    assert len(told) == (not fits)
