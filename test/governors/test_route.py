"""The way round: every leg keeps the steady margin, wherever the zones are."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from strategies import rotations, unit_vectors

from spacecraft_gnc import lie
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.governors._geodesics import closest_approach, geodesics, spread
from spacecraft_gnc.governors.reference_set import ReferenceSet
from spacecraft_gnc.governors.route import RoutePlanner
from spacecraft_gnc.ocp import PointingZone

STEADY, CLEARANCE = math.radians(0.1), math.radians(2.0)
X, Y, Z = np.eye(3)


@st.composite
def zones(draw):
    """One to four cones for different body axes; now and then the last one is to stay in."""
    made = [
        PointingZone(
            "exclusion", draw(unit_vectors()), draw(unit_vectors()), draw(st.floats(0.1, 0.6)), 1.0
        )
        for _ in range(draw(st.integers(1, 3)))
    ]
    if draw(st.booleans()):
        axes = draw(unit_vectors()), draw(unit_vectors())
        made.append(PointingZone("inclusion", *axes, draw(st.floats(0.6, 1.4)), 1.0))
    return tuple(made)


def sampled(start, end):
    """Attitudes along the geodesic, by exp and log."""
    vector = lie.log(start.T @ end)
    n = max(2, math.ceil(np.linalg.norm(vector) / math.radians(0.25)))
    return np.array([start @ lie.exp(s * vector) for s in np.linspace(0.0, 1.0, n + 1)])


def smallest_margin(reference_set, attitudes):
    """Zone margin by arctangents, not by the code under test."""
    found = math.inf
    for zone in reference_set.zones:
        axis, d = attitudes @ zone.body_axis, np.asarray(zone.inertial_axis)
        angle = np.arctan2(np.linalg.norm(np.cross(axis, d), axis=1), axis @ d)
        found = min(found, float((zone.sign * (angle - zone.half_angle)).min()))
    return found


def length(path):
    return sum(lie.angle_between(a, b) for a, b in pairwise(path))


@settings(max_examples=40, deadline=None)
@given(zones(), rotations(), rotations())
def test_every_leg_of_a_route_keeps_the_steady_margin(found, start, end):
    reference_set = ReferenceSet(found, STEADY)
    assume(reference_set.contains(start) and reference_set.contains(end))
    planner = RoutePlanner(reference_set, CLEARANCE)
    route = planner.plan(start, end)
    direct = smallest_margin(reference_set, sampled(start, end))
    if direct < STEADY - 1e-9:
        assert route != ()
    if route is None:
        return
    path = [start, *route, end]
    if route:
        assert not planner.is_clear(start, end)
        assert length(path) < 2.0 * math.pi
    margins = [smallest_margin(reference_set, sampled(a, b)) for a, b in pairwise(path)]
    assert min(margins) >= STEADY - 1e-9
    if len(route) > 1:  # legs between intermediate references keep the clearance
        assert min(margins[1:-1]) >= CLEARANCE - 1e-9
    again = RoutePlanner(reference_set, CLEARANCE).plan(start, end)
    assert again is not None
    assert np.array_equal(np.array(again), np.array(route))


@settings(max_examples=60, deadline=None)
@given(zones(), rotations(), rotations())
def test_the_closest_approach_is_the_smallest_sampled_margin(found, start, end):
    axes, angles = geodesics(start, end[None])
    assume(angles[0] < math.pi - 1e-3)
    reference_set = ReferenceSet(found, STEADY)
    closest = closest_approach(found, start, axes, angles)[0]
    sampled_one = smallest_margin(reference_set, sampled(start, end))
    # An axis turns by no more than the body: half a sample's spacing at the most is missed.
    assert closest <= sampled_one + 1e-7
    assert closest >= sampled_one - math.radians(0.125)


def test_the_spread_attitudes_are_rotations_that_leave_no_large_gap():
    attitudes, quaternions = spread(1200)
    assert np.abs(np.swapaxes(attitudes, 1, 2) @ attitudes - np.eye(3)).max() < 1e-12
    assert np.allclose(lie.from_quaternion_xyzw(quaternions[7]), attitudes[7], atol=1e-12)
    for seed in range(50):
        anywhere = lie.orthonormalize(np.random.default_rng(seed).normal(size=(3, 3)))
        assert np.degrees(lie.angles_between(attitudes, anywhere[None]).min()) < 25.0


def across(half_angle_deg):
    """A cone for body x across a turn of 90 deg about z, from 90 deg to 0."""
    axis = [math.cos(math.pi / 4), math.sin(math.pi / 4), 0.0]
    zone = PointingZone("exclusion", X, axis, math.radians(half_angle_deg), 1.0)
    return ReferenceSet((zone,), STEADY), lie.exp(0.5 * math.pi * Z), np.eye(3)


@pytest.mark.parametrize("half_angle_deg", [1.0, 10.0, 25.0])
def test_a_detour_is_little_longer_than_it_has_to_be(half_angle_deg):
    reference_set, start, end = across(half_angle_deg)
    route = RoutePlanner(reference_set, CLEARANCE).plan(start, end)
    assert route
    # Body x goes along tangents and round the cone at the least; the body turns no less.
    rim = math.radians(half_angle_deg)
    tangent = math.acos(math.cos(math.pi / 4) / math.cos(rim))
    arc = math.sin(rim) * 2.0 * math.asin(min(1.0, math.tan(rim) / math.tan(math.pi / 4)))
    way = length([start, *route, end])
    assert 2.0 * tangent + arc <= way < 1.2 * (2.0 * tangent + arc)


def test_half_a_turn_counts_as_clear_only_if_both_ways_are():
    zone = PointingZone("exclusion", X, Y, 0.2, 1.0)  # on the way of body x about +z only
    planner = RoutePlanner(ReferenceSet((zone,), STEADY), CLEARANCE)
    start, end = np.eye(3), lie.exp(math.pi * Z)
    assert not planner.is_clear(start, end)
    assert not planner.is_clear(end, start)
    assert planner.is_clear(start, lie.exp(-0.9 * math.pi * Z))
    for a, b in ((start, end), (end, start)):
        route = planner.plan(a, b)
        assert route
        legs = zip([a, *route], [*route, b], strict=True)
        assert all(lie.angle_between(*leg) < math.radians(151.0) for leg in legs)


def test_a_start_beside_a_zone_leaves_without_coming_nearer():
    reference_set, start, end = across(20.0)
    start = lie.exp(math.radians(45.0 + 20.0 + 0.2) * Z)
    route = RoutePlanner(reference_set, CLEARANCE).plan(start, end)
    assert route
    first = smallest_margin(reference_set, sampled(start, route[0]))
    assert first >= math.radians(0.2) - 1e-8


def test_no_way_is_found_where_there_is_none():
    def cone(kind, y, half_angle):
        axis = [math.cos(math.radians(y)), math.sin(math.radians(y)), 0.0]
        return PointingZone(kind, X, axis, math.radians(half_angle), 1.0)

    # Body x stays in a disc that two others cut in two: from the upper half none leads down.
    found = (cone("inclusion", 0, 30), cone("exclusion", 15, 16), cone("exclusion", -15, 16))
    planner = RoutePlanner(ReferenceSet(found, STEADY), CLEARANCE)
    up, down = lie.exp(math.radians(-26.0) * Y), lie.exp(math.radians(26.0) * Y)
    assert planner.plan(up, down) is None
    assert planner.plan(up, up @ lie.exp(0.3 * X)) == ()
    # Outside the set of references nothing is planned.
    assert planner.plan(np.eye(3), down) is None


def test_no_attitude_that_keeps_the_clearance_leaves_no_roadmap():
    found = (
        PointingZone("inclusion", X, X, math.radians(1.0), 1.0),
        PointingZone("inclusion", Y, Y, math.radians(1.0), 1.0),
        PointingZone("exclusion", Z, Z, math.radians(0.5), 1.0),
    )
    planner = RoutePlanner(ReferenceSet(found, STEADY), CLEARANCE)
    planner.warm_up()
    start, end = lie.exp(0.015 * X), lie.exp(-0.015 * X)
    assert planner.plan(start, end) is None


def test_a_clearance_below_the_steady_margin_is_refused():
    with pytest.raises(ParameterError, match=r"clearance.*at least the steady margin"):
        RoutePlanner(ReferenceSet((), STEADY), 0.5 * STEADY)
