"""The set of references: angles to the zones, membership, refusals."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from kalabic_loop import EARTH, REFERENCES
from strategies import rotations

from spacecraft_gnc import lie
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.governors.reference_set import ReferenceSet
from spacecraft_gnc.ocp import PointingZone

SUN = PointingZone("exclusion", [1, 0, 0], [0, 1, 0], 0.3, 1.0)
BOTH = ReferenceSet((EARTH, SUN), 0.1, ("earth", "sun"))


@given(rotations())
def test_the_margin_is_the_least_angle_to_a_zone(attitude):
    angle, name = BOTH.margin(attitude)
    angles = {"earth": float(EARTH.margin(attitude)), "sun": float(SUN.margin(attitude))}
    assert angle == pytest.approx(min(angles.values()), abs=1e-7)  # acos near 1
    assert angles[name] == pytest.approx(angle, abs=1e-7)
    assert BOTH.margins(attitude[None])[0] == min(angles.values())
    assert BOTH.contains(attitude) == (angle >= 0.1)


def test_without_zones_every_attitude_belongs():
    free = ReferenceSet()
    assert free.margin(np.eye(3)) == (math.inf, "")
    assert free.contains(lie.exp(np.array([0.0, math.pi, 0.0])))
    assert np.array_equal(free.margins(np.zeros((2, 3, 3))), [math.inf, math.inf])


def test_an_attitude_outside_is_refused_with_zone_and_margin():
    tilted = lie.exp(np.array([math.radians(59.95), 0.0, 0.0]))
    with pytest.raises(
        ParameterError, match=r"target: .* margin of 0\.05 deg to zone 'earth'; req"
    ):
        REFERENCES.require("target", tilted)
    REFERENCES.require("target", lie.exp(np.array([math.radians(59.89), 0.0, 0.0])))


def test_what_is_no_attitude_is_outside():
    for references in (REFERENCES, BOTH, ReferenceSet((SUN,), 0.1)):
        assert not references.contains(np.full((3, 3), math.nan))


def test_bad_arguments_are_refused():
    with pytest.raises(ParameterError, match="steady_margin"):
        ReferenceSet((EARTH,), 0.0)
    with pytest.raises(ParameterError, match="names: received 1 for 2 zones"):
        ReferenceSet((EARTH, SUN), 0.1, ("earth",))
    assert ReferenceSet((EARTH, SUN), 0.1).names == ("zone 1", "zone 2")
