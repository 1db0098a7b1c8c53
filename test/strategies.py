"""Hypothesis strategies and reference formulas shared by the tests."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import strategies as st

from spacecraft_gnc import lie

# Angles that break naive formulas: zero, denormal-small, near the half turn, and ordinary ones.
ANGLES = st.one_of(
    st.sampled_from([0.0, 1e-300, 1e-12, 1e-8, 1e-7, math.pi - 1e-7, math.pi - 1e-12, math.pi]),
    st.floats(0.0, math.pi),
    st.floats(0.0, 1e-4),
    st.floats(math.pi - 1e-4, math.pi),
)
COMPONENTS = st.floats(-1.0, 1.0)


@st.composite
def unit_vectors(draw):
    """A direction, approximately uniform, never degenerate."""
    seed = draw(st.integers(0, 2**32 - 1))
    vector = np.random.default_rng(seed).normal(size=3)
    return vector / np.linalg.norm(vector)


@st.composite
def rotation_vectors(draw):
    """A rotation vector of length at most pi, often near 0 or pi."""
    return draw(ANGLES) * draw(unit_vectors())


@st.composite
def rotations(draw):
    """A rotation matrix."""
    return lie.exp(draw(rotation_vectors()))


@st.composite
def vectors(draw, largest=1.0):
    """A vector of length up to ``largest``."""
    return largest * draw(st.floats(0.0, 1.0)) * draw(unit_vectors())


@st.composite
def inertias(draw):
    """A full inertia matrix of a body with volume."""
    a, b, c = (draw(st.floats(0.2, 1.0)) for _ in range(3))  # integrals of x^2, y^2, z^2
    axes = draw(rotations())
    inertia = axes @ np.diag([b + c, a + c, a + b]) @ axes.T
    return 0.5 * (inertia + inertia.T)


@st.composite
def weights(draw, smallest=0.0):
    """A full symmetric positive (semi-)definite weight of size about 1."""
    axes = draw(rotations())
    diagonal = [draw(st.floats(smallest, 1.0)) for _ in range(3)]
    weight = axes @ np.diag(diagonal) @ axes.T
    return 0.5 * (weight + weight.T)
