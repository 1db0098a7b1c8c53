"""Flights of a body whose actuators have a limit: bits, reports, audits, forgeries, checks."""

from __future__ import annotations

import numpy as np
import pytest
from flown_bags import edited, first_of, fly, messages_of, rewrite, sections

from spacecraft_gnc.analysis.audit import audit_bag
from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.analysis.reader import read_flight
from spacecraft_gnc.cli.main import main
from spacecraft_gnc.cli.simulate import summary_rows
from spacecraft_gnc.loop.closed_loop import ClosedLoop
from spacecraft_gnc.scenario import load
from spacecraft_gnc.scenario.fingerprint import fingerprint
from spacecraft_gnc.vehicles.rigid_body.flight import RigidBodyFlight

NS = 400_000_000  # control period [ns]
LIMIT = 0.004  # [N m]
RARE = 0.0075  # [N m] acts at about half of the recorded steps
CHECK = "applied torque = command"
ARRAYS = ("attitude", "momentum", "torque", "cost", "residual", "final_attitude")


def case_1(*limit: float) -> ClosedLoop:
    return load("gupta2015_case1", [f"plant.max_torque={value}" for value in limit]).build()


def same(first: RigidBodyFlight, second: RigidBodyFlight) -> bool:
    return all(getattr(first, name).tobytes() == getattr(second, name).tobytes() for name in ARRAYS)


def test_a_limit_that_is_the_controllers_changes_no_bit():
    free, limited = case_1(), case_1(0.01)
    assert same(limited.run(), free.run())
    assert limited.plant.actuators.shortfalls == 0


def test_a_smaller_limit_acts_is_counted_and_told():
    loop = case_1(LIMIT)
    flight = loop.run()
    cut = loop.plant.actuators.shortfalls
    assert np.abs(flight.torque).max() == LIMIT
    on_it = int((np.abs(flight.torque) == LIMIT).any(axis=1).sum())
    assert on_it == cut > 50
    told = summarize(flight, load("gupta2015_case1", [f"plant.max_torque={LIMIT}"]))
    rows = dict(summary_rows(told))
    assert rows["warning"] == (
        f"the actuators gave all they can, 0.004 N m about an axis, at {cut} of 375 steps"
    )
    assert same(loop.run(), flight)
    assert loop.plant.actuators.shortfalls == cut


def test_no_limit_is_no_part_of_a_scenario():
    plain = load("gupta2015_case1")
    assert fingerprint(load("gupta2015_case1", ["plant.max_torque=0.0"])) == fingerprint(plain)
    assert fingerprint(load("gupta2015_case1", ["plant.max_torque=1.0"])) != fingerprint(plain)
    assert "actuator_limit" not in summarize(plain.build().run(), plain)


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """A recorded flight with a limit that acts on some steps and not on others."""
    said = sections(plant={"max_torque": RARE})
    bag = fly(tmp_path_factory.mktemp("limited"), said)
    return bag, messages_of(bag)


def test_the_audit_passes_and_says_what_was_cut(flown):
    audit = audit_bag(flown[0])
    assert audit.passed, audit.first
    check = next(check for check in audit.checks if check.name == CHECK)
    torque = read_flight(flown[0]).trajectory.torque
    cut = int((np.abs(torque) == RARE).any(axis=1).sum())
    assert 0 < cut < 12
    assert check.note == f"cut to plant.max_torque, 0.0075 N m, at {cut} steps"


def test_a_bag_holds_the_torques_of_the_simulation(flown):
    recorded = read_flight(flown[0])
    simulated = recorded.info.scenario.build().run()
    for name in ("attitude", "momentum", "torque"):
        ours = getattr(recorded.trajectory, name)
        assert ours.tobytes() == getattr(simulated, name).tobytes(), name


def test_without_the_plants_word_the_limit_is_applied_to_the_commands(flown, tmp_path):
    bag, messages = flown
    kept = [each for each in messages if each[0] != "/plant_invariants"]
    silent = rewrite(bag, tmp_path / "bag", kept)
    torque = read_flight(bag).trajectory.torque
    assert read_flight(silent).trajectory.torque.tobytes() == torque.tobytes()
    integrated = [c for c in audit_bag(silent).checks if c.name == "integrator, from each state"]
    assert [check.verdict for check in integrated] == ["pass"]


def forged(flown, folder, topic, kind, step, **changes):
    bag, messages = flown
    change = edited(kind, **changes)
    changed = [
        (name, stamp, change(data) if (name, stamp) == (topic, step * NS) else data)
        for name, stamp, data in messages
    ]
    return audit_bag(rewrite(bag, folder / "bag", changed))


def first_cut(flown):
    torque = read_flight(flown[0]).trajectory.torque
    return int(np.flatnonzero((np.abs(torque) == RARE).any(axis=1))[0])


@pytest.mark.parametrize("share", [0.5, 1.0 + 1e-15, 3.0])
def test_a_forged_torque_fails_at_its_step(flown, tmp_path, share):
    step = first_cut(flown)
    axis = int(np.abs(read_flight(flown[0]).trajectory.torque[step]).argmax())

    def scaled(torque):
        name = "xyz"[axis]
        setattr(torque, name, share * getattr(torque, name))
        return torque

    audit = forged(
        flown, tmp_path, "/plant_invariants", "PlantInvariants", step + 1, applied_torque=scaled
    )
    found = {check.name: check.first for check in audit.checks if check.first is not None}
    assert found[CHECK] == (step, f"plant_invariants.applied_torque[{axis}]")
    assert first_of(audit)[1] == step


def test_a_limit_that_the_scenario_does_not_have_is_found(tmp_path):
    bag = fly(tmp_path, sections(plant={"max_torque": RARE}), claimed=sections())
    audit = audit_bag(bag)
    assert CHECK in {check.name for check in audit.checks if check.first is not None}
    assert audit.first[1].step == first_cut((bag,))


WARNED = "plant.max_torque: received 0.004 N m"


@pytest.mark.parametrize(
    ("scenario", "further", "told"),
    [
        ("gupta2015_case1", [], "at least 0.01 N m, which nmpc_controller.max_torque lets"),
        ("kalabic2014_governor", [], "0.02 N m, which reference_governor.max_torque lets"),
        ("phogat_figure4", [], "20 N m, which nmpc_controller.plan.torque_bounds lets"),
        ("sun_moon_pd", ["nmpc_controller.max_torque=0.0", "reference_governor.max_torque=0.0"],
         "beside a controller without a torque limit"),
    ],
)  # fmt: skip
def test_a_limit_below_what_may_be_asked_for_is_warned_of(scenario, further, told):
    (warning,) = [
        text for text in load(scenario, ["plant.max_torque=0.004", *further]).warnings
        if WARNED in text
    ]  # fmt: skip
    assert told in warning
    assert not [text for text in load(scenario, further).warnings if "plant.max_torque" in text]


def test_a_limit_that_leaves_room_is_not_warned_of():
    for limit in ("0.01", "0.02"):
        assert not load("gupta2015_case1", [f"plant.max_torque={limit}"]).warnings


@pytest.mark.parametrize("value", ["-0.01", ".nan", ".inf", "text", "[0.1, 0.1, 0.1]", "true"])
def test_what_is_no_limit_is_refused_in_one_line(value, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["check", "gupta2015_case1", "--set", f"plant.max_torque={value}"])
    assert ended.value.code == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("error: --set: plant.max_torque: received ")
    assert "N m" in line


def test_check_tells_the_limit(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["check", "gupta2015_case1", "--set", "plant.max_torque=0.01"])
    assert ended.value.code == 0
    assert "actuators     at most 0.01 N m about each axis, cut by the plant" in (
        capsys.readouterr().out
    )
