"""What `gnc check` refuses of a formation scenario, with which words."""

from __future__ import annotations

import re
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

from spacecraft_gnc.scenario import InvalidScenario, from_sections
from spacecraft_gnc.vehicles.formation.admissible import desired, start
from spacecraft_gnc.vehicles.formation.facts import facts
from spacecraft_gnc.vehicles.formation.orbit import orbital_period

PERIOD = orbital_period(350.0e3) / 50  # [s]
STATES = [0.0, 9e3, 0.0, 0.0, 5e3, 0.0, 0.0, 1e3, 0.0]  # [m]
PAIR = {"spacecraft": ["sc1", "sc2"], "governor_phase": [16, 0]}
LISTS = {
    "initial_phase": [45.0, 21.0],
    "initial_along_track_offset": [0.0, 5000.0],
    "initial_amplitude": [1.0, 1.0],
}


def sections(**changes: Any) -> dict[str, dict[str, Any]]:
    """Return a scenario by section; a name may begin with ``governor_`` or ``controller_``."""
    found: dict[str, dict[str, Any]] = {
        "plant": {
            "vehicle": "formation",
            "initial_along_track_offset": [6103.0, 8325.0, 5036.0],
            "initial_amplitude": [1.53, 1.705, 0.877],
        },
        "nmpc_controller": {},
        "reference_governor": {},
    }
    prefixes = {"governor_": "reference_governor", "controller_": "nmpc_controller"}
    for key, value in changes.items():
        prefix = next((p for p in prefixes if key.startswith(p)), "")
        section = found[prefixes.get(prefix, "plant")]
        section[key.removeprefix(prefix)] = value
        if value is None:
            del section[key]
    return found


def problems(**changes: Any) -> list[str]:
    """Return what is refused, "key: received ..." by line."""
    with pytest.raises(InvalidScenario) as refused:
        from_sections(sections(**changes))
    told = [str(problem).removeprefix("parameters: ") for problem in refused.value.problems]
    assert all(len(line.splitlines()) == 1 for line in told)
    return told


def warnings(**changes: Any) -> list[str]:
    return [str(line) for line in from_sections(sections(**changes)).warnings]


@pytest.mark.parametrize(
    ("changes", "key", "words"),
    [
        ({"spacecraft": ["sc1"]}, "plant.spacecraft", "two spacecraft or more; add another one"),
        ({"spacecraft": ["1a", "b", "c"]}, "plant.spacecraft", "of which no digit comes first"),
        ({"spacecraft": ["a-b", "b", "c"]}, "plant.spacecraft", "a ROS namespace"),
        ({"spacecraft": ["a//b", "b", "c"]}, "plant.spacecraft", "a ROS namespace"),
        ({"spacecraft": ["a", "/a", "c"]}, "plant.spacecraft", "'a' twice"),
        ({"initial_phase": [45.0, 21.0]}, "plant.initial_phase", "3, one for each of 3 craft"),
        ({"initial_amplitude": [1.0] * 4}, "plant.initial_amplitude", "4 numbers"),
        (
            {"initial_along_track_offset": [5.0]},
            "plant.initial_along_track_offset",
            "give as many, or change plant.spacecraft",
        ),
        ({"governor_phase": [16, 0]}, "reference_governor.phase", "3, one for each of 3 craft"),
        (
            {"governor_phase": [16, 0, 16]},
            "reference_governor.phase",
            "in which sc1 and sc3 share a place",
        ),
        (
            {"governor_phase": [16, 50, 0]},
            "reference_governor.phase",
            "modulo the 50 control steps",
        ),
        ({"max_delta_v": 0.0}, "plant.max_delta_v", "> 0"),
        ({"time_step": PERIOD / 2, "controller_time_step": PERIOD}, "plant.time_step", "at once"),
        (
            {"governor_delta_v_margin": 1.0},
            "reference_governor.delta_v_margin",
            "less than plant.max_delta_v (1 m/s)",
        ),
        (
            {"governor_communication_angle_margin_deg": 75.0},
            "reference_governor.communication_angle_margin_deg",
            "less than plant.max_communication_angle_deg (60 deg)",
        ),
        (
            {"governor_separation_margin": 699.0},
            "reference_governor.separation_margin",
            "at most 698.613 m",
        ),
        (
            {"spacecraft_lost_at": 3.0},
            "plant.spacecraft_lost_at",
            "spacecraft_lost beside it",
        ),
        ({"spacecraft_lost": "sc4"}, "plant.spacecraft_lost", "one of the craft sc1, sc2, sc3"),
        (
            {"spacecraft_lost": "sc2", "spacecraft_lost_at": 1000.0, "duration": 1000.0},
            "plant.spacecraft_lost_at",
            f"last control step ({8 * PERIOD:.10g} s)",
        ),
        (
            {"spacecraft": [f"sc{i}" for i in range(5)]},
            "plant.spacecraft",
            "50^5 = 3.12e+08 shifts",
        ),
        (
            {"initial_phase": [45.0, 45.0, 10.0], "initial_along_track_offset": [0.0] * 3},
            "plant.initial_phase",
            "sc1 and sc2 are",
        ),
    ],
)
def test_what_cannot_fly_is_refused_in_a_line(
    changes: dict[str, Any], key: str, words: str
) -> None:
    told = problems(**changes)
    assert any(line.startswith(f"{key}: received ") and words in line for line in told), told


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"initial_position": STATES}, "plant.initial_position"),
        ({"initial_velocity": [0.0] * 9}, "plant.initial_velocity"),
    ],
)
def test_positions_and_velocities_belong_together(changes: dict[str, Any], key: str) -> None:
    clean = {"initial_along_track_offset": None, "initial_amplitude": None}
    (told,) = problems(**clean, **changes)
    assert told.startswith(f"{key}: received ")
    assert "beside it; add it" in told


def test_positions_count_instead_of_places_on_ellipses() -> None:
    both = {"initial_position": STATES, "initial_velocity": [0.0] * 9}
    plant = from_sections(sections(**both)).plant
    assert plant.initial_position.ravel().tolist() == STATES
    np.testing.assert_array_equal(start(plant, 50)[:, :3], plant.initial_position)
    (told_of,) = problems(**(both | {"initial_velocity": [0.0] * 6}))
    assert told_of.startswith("plant.initial_velocity: received 6 numbers")
    assert "9, 3 for each of 3 craft" in told_of


@pytest.mark.parametrize("section", ["", "controller_"])
@pytest.mark.parametrize(("factor", "count"), [(1.0 + 1e-6, 50), (1.3, 38), (100.0, 3)])
def test_a_sampling_that_does_not_divide_the_orbit_is_refused_with_one_that_does(
    section: str, factor: float, count: int
) -> None:
    key, places = f"{section}time_step", {
        "initial_phase": [0.9 * count, 0.42 * count, 0.2 * count],
        "governor_phase": [count // 3, 0, 2 * count // 3],
        "duration": 1e5,
    }  # fmt: skip
    told = problems(**{key: factor * PERIOD}, **places)[0]
    name = "nmpc_controller" if section else "plant"
    assert told.startswith(f"{name}.time_step: received {factor * PERIOD!r} s, of which the orbit")
    remedy = float(re.findall(r"use (\S+) \(\d+ control steps\)", told)[0])
    assert remedy == pytest.approx(50 * PERIOD / count, rel=1e-15)
    assert from_sections(sections(**{key: remedy}, **places)).period == remedy


def test_a_sampling_with_ten_digits_divides_the_orbit() -> None:
    assert from_sections(sections(time_step=float(f"{PERIOD:.11g}"))).n_steps == 150
    assert problems(time_step=float(f"{PERIOD:.6g}"))


def test_a_formation_that_is_too_small_is_refused_with_a_size_that_is_not() -> None:
    (told,) = problems(radial_semi_axis=500.0)
    assert told.startswith("plant.radial_semi_axis: received 500.0 m, at which sc1 and sc2 come")
    assert "849.307 m" in told
    size = float(re.findall(r"raise it to (\S+) m", told)[0])
    plant = from_sections(sections(radial_semi_axis=size)).plant
    assert desired(plant, (16, 0, 33), 50).distance >= plant.min_separation
    assert problems(radial_semi_axis=size - 1.0)


def test_the_nearest_craft_of_the_formation_are_those_of_every_step() -> None:
    plant = from_sections(sections()).plant
    k = 2.0 * np.pi / 50.0 * (np.arange(50)[:, None] + [16, 0, 33])
    x, y = 1000.0 * np.cos(k), -2000.0 * np.sin(k)
    apart = {
        (i, j): np.hypot(x[:, i] - x[:, j], y[:, i] - y[:, j]).min()
        for i, j in ((0, 1), (0, 2), (1, 2))
    }
    found = desired(plant, (16, 0, 33), 50)
    assert found.distance == pytest.approx(min(apart.values()), rel=1e-12)
    assert apart[found.pair] == pytest.approx(found.distance, rel=1e-9)
    # Between the samples they come somewhat nearer.
    assert found.distance * 0.99 < desired(plant, (16, 0, 33), 50, 20).distance <= found.distance


def test_two_craft_fly_where_everything_is_given_for_two() -> None:
    assert len(from_sections(sections(**PAIR, **LISTS)).plant.spacecraft) == 2
    told = problems(spacecraft=["sc1", "sc2"])
    assert [line.partition(":")[0] for line in told] == [
        "plant.initial_phase",
        "plant.initial_along_track_offset",
        "plant.initial_amplitude",
        "reference_governor.phase",
    ]


def test_warnings_of_what_may_be_flown_on_purpose() -> None:
    lost = {"spacecraft_lost": "sc2", "spacecraft_lost_at": 1000.0}
    assert not warnings()
    assert not warnings(**lost)
    (told,) = warnings(**lost, governor_governor="none")
    assert "governor: none does not notice it" in told
    (told,) = warnings(motion="two_body_j2")
    assert "delta_v_margin, separation_margin, communication_angle_margin_deg" in told
    assert not warnings(motion="two_body_j2", governor_separation_margin=50.0)


def test_the_facts_of_the_start_of_the_report() -> None:
    scenario = from_sections(sections())
    told = facts(scenario, None)  # type: ignore[arg-type]
    assert told.numbers["orbital_period"] == pytest.approx(5492.287, abs=5e-4)
    assert told.numbers["orbit_samples"] == 50
    assert told.numbers["formation_separation"] == pytest.approx(1698.613, abs=1e-3)
    assert told.body == "3 spacecraft: sc1, sc2, sc3"
    rows = dict(told.rows)
    assert "50 control steps" in rows["orbit"]
    assert "1 km radial, 2 km along the track" in rows["formation"]


def test_a_check_loads_no_kernels() -> None:
    code = (
        "import sys; from spacecraft_gnc.scenario import from_sections;"
        "from spacecraft_gnc.vehicles.formation.facts import facts;"
        "facts(from_sections({'plant': {'vehicle': 'formation'}}), None);"
        "print('numba' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"
