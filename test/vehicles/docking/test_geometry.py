"""Cuboids, ports and the two constraints, against rotated vertices and hand-worked cases."""

from __future__ import annotations

import math

import numpy as np
import pytest
from docking_pair import CHIEF, DEPUTY, pair
from hypothesis import given
from strategies import rotations, vectors

from spacecraft_gnc.errors import ParameterError, ShapeError
from spacecraft_gnc.vehicles.docking.geometry import Cuboid, clearance, line_of_sight_margin

TANGENT = math.tan(math.radians(30.0))


def test_vertices_are_the_corners_of_the_cuboid():
    assert len({tuple(vertex) for vertex in DEPUTY.vertices}) == 8
    assert np.array_equal(np.abs(DEPUTY.vertices), np.tile([0.3, 0.3, 0.4], (8, 1)))


@pytest.mark.parametrize(
    ("port", "depth", "on_surface", "on_front"),
    [
        ([0.52, 0.0, 0.2], 0.0, True, True),
        ([0.52, 0.575, 0.785], 0.0, True, True),
        ([0.0, -0.575, 0.3], 0.0, True, False),
        ([-0.52, 0.0, 0.2], 0.0, True, False),
        ([0.5, 0.0, 0.2], 0.02, False, False),
        ([0.0, 0.0, 0.0], 0.52, False, False),
        ([0.62, 0.0, 0.2], -0.1, False, False),
        ([0.52, 0.6, 0.0], -0.025, False, False),
    ],
)
def test_ports_below_on_and_above_the_surface(port, depth, on_surface, on_front):
    body = Cuboid(CHIEF.size, port)
    assert math.isclose(body.port_depth, depth, abs_tol=1e-15)
    assert (body.has_port_on_surface, body.has_port_on_front) == (on_surface, on_front)


def test_inertia_is_that_of_the_mass_distribution():
    points = DEPUTY.vertices / math.sqrt(3.0)  # Gauss nodes: exact for squares
    expected = sum(130.0 / 8.0 * (x @ x * np.eye(3) - np.outer(x, x)) for x in points)
    assert np.allclose(DEPUTY.inertia(130.0), expected, rtol=1e-14, atol=1e-14)


def test_line_of_sight_margin_of_hand_worked_offsets():
    offsets = [[0.0, 0.0, 0.0], [1.0, 0.2, -0.5], [1.0, -0.7, 0.1], [-1.0, 0.0, 0.0]]
    expected = [0.05, TANGENT + 0.05 - 0.5, TANGENT + 0.05 - 0.7, 0.05 - TANGENT]
    assert np.allclose(line_of_sight_margin(offsets, TANGENT, 0.05), expected, atol=1e-15)


@given(vectors(), rotations())
def test_clearance_is_that_of_the_lowest_vertex(offset, attitude):
    center = CHIEF.port + offset - attitude @ DEPUTY.port
    lowest = (center + DEPUTY.vertices @ attitude.T)[:, 0].min()
    found = clearance(offset, attitude, DEPUTY, CHIEF)
    assert abs(found - (lowest - 0.52)) < 1e-14
    kernel = pair().margins(offset, attitude)
    sight = line_of_sight_margin(offset, TANGENT, 0.05)
    assert np.allclose(kernel, (sight, found), rtol=0.0, atol=1e-14)


def test_constraints_take_stacks_and_vanish_when_docked():
    stack = clearance(np.zeros((4, 3)), np.broadcast_to(np.eye(3), (4, 3, 3)), DEPUTY, CHIEF)
    assert stack.shape == (4,)
    assert np.abs(stack).max() < 1e-15


@pytest.mark.parametrize(
    ("size", "error", "message"),
    [
        ([0.6, 0.0, 0.8], ParameterError, "size: received.*three positive edges"),
        ([0.6, 0.6], ShapeError, "size: received"),
    ],
)
def test_a_body_without_volume_is_refused(size, error, message):
    with pytest.raises(error, match=message):
        Cuboid(size, [0.0, 0.0, 0.0])
