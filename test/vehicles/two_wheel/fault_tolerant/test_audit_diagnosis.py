"""An audit passes the diagnoses that were flown, and names the one that was changed."""

from __future__ import annotations

import math

import numpy as np
import pytest
from flown_bags import edited, first_of, messages_of
from wheel_bags import fly, rewrite
from wheel_losses import scenario_sections

from spacecraft_gnc.analysis.audit import audit_bag

PERIOD = 10_000_000_000  # [ns]
LINES = {
    "residuals of the wheels", "bounds of the residuals", "wheels excluded by the residual test",
    "no wheel excluded that answers", "mode of flight", "rest or rotation that is held",
    "pointing that is lost", "rest at the target", "attitude that is held is a rotation",
}  # fmt: skip
FLIGHTS = {
    "friction": {},
    "spinning": {"wheel_loss": "spinning"},
    "momentum": {"initial_total_momentum": [0.5, 0.2, -0.3]},
    "both": {"wheel_loss": "spinning", "initial_total_momentum": [0.2, 0.1, -0.1]},
    "rubbing": {"wheel_viscous_friction": [1e-4] * 3, "wheel_coulomb_friction": [1e-3] * 3},
}


@pytest.fixture(scope="module")
def bags(tmp_path_factory):
    return {
        name: fly(tmp_path_factory.mktemp(name), scenario_sections(duration=300.0, **plant))[0]
        for name, plant in FLIGHTS.items()
    }


@pytest.mark.parametrize("name", FLIGHTS)
def test_what_was_flown_passes(bags, name):
    audit = audit_bag(bags[name])
    assert audit.passed, audit.first
    verdicts = {check.name: check.verdict for check in audit.checks}
    expected = dict.fromkeys(LINES, "pass")
    if name == "both":
        assert verdicts.keys() >= LINES
    else:
        assert expected.items() <= verdicts.items()


def flipped(index):
    def change(values):
        changed = np.array(values)
        changed[index] ^= True
        return changed

    return change


def shifted(index, by):
    def change(values):
        changed = np.array(values)
        changed[index] += by
        return changed

    return change


CHANGES = [
    ("friction", 5, "healthy", flipped(0), "wheels excluded by the residual test"),
    ("friction", 20, "healthy", flipped(2), "wheels excluded by the residual test"),
    ("friction", 5, "residual", shifted(1, 1e-9), "residuals of the wheels"),
    ("friction", 5, "threshold", shifted(1, 1e-9), "bounds of the residuals"),
    ("friction", 5, "response", shifted(1, 1e-6), "residuals of the wheels"),
    ("friction", 5, "mode", 2, "mode of flight"),
    ("friction", 20, "mode", -1, "mode of flight"),
    ("friction", 5, "held_attitude", shifted(1, 1e-15), "rest at the target"),
    ("friction", 5, "pointing_loss", 1e-6, "pointing that is lost"),
    ("spinning", 20, "held_attitude", shifted(3, 1e-3), "attitude that is held is a rotation"),
    ("momentum", 20, "held_attitude", shifted(2, 1e-3), "rest or rotation that is held"),
    ("momentum", 20, "pointing_loss", 1e-6, "pointing that is lost"),
]


@pytest.mark.parametrize(("name", "step", "field", "change", "line"), CHANGES)
def test_what_was_changed_is_named(bags, tmp_path, name, step, field, change, line):
    change = edited("WheelDiagnosis", **{field: change})
    topic, stamp = "/wheel_diagnosis", step * PERIOD
    changed = [
        (found, time, change(data) if (found, time) == (topic, stamp) else data)
        for found, time, data in messages_of(bags[name])
    ]
    audit = audit_bag(rewrite(bags[name], tmp_path / "bag", changed))
    assert not audit.passed
    failed = {check.name: check.first for check in audit.checks if check.first}
    assert line in failed
    assert first_of(audit)[1] in (step, step + 1)
    assert failed[line].field.startswith("wheel_diagnosis.")


def test_a_slower_rotation_than_there_is_fails(bags, tmp_path):
    def slower(rate):
        rate.z *= 0.9
        return rate

    change, stamp = edited("WheelDiagnosis", remaining_rate=slower), 20 * PERIOD
    changed = [
        (found, time, change(data) if (found, time) == ("/wheel_diagnosis", stamp) else data)
        for found, time, data in messages_of(bags["spinning"])
    ]
    audit = audit_bag(rewrite(bags["spinning"], tmp_path / "bag", changed))
    check, step, field = first_of(audit)
    assert (check, step) == ("rest or rotation that is held", 20)
    assert field.startswith("wheel_diagnosis.remaining_rate")
    assert math.isfinite(next(c.worst for c in audit.checks if c.name == check))
