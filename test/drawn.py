"""Distributions read from a text, and numbers drawn from them."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import strategies as st

from spacecraft_gnc.campaign.distributions.distribution import Target
from spacecraft_gnc.campaign.distributions.read import read_distribution
from spacecraft_gnc.parameters.parameter import Kind, MatrixRule, ParameterSpec
from spacecraft_gnc.parameters.yaml_node import compose
from spacecraft_gnc.plant.random_numbers import uniforms

N = 20_000
SURE = 5.0 / math.sqrt(N)  # five deviations of the mean of N numbers of variance 1
UNIT = st.floats(0.0, 1.0, exclude_max=True)
POINTS3 = st.tuples(UNIT, UNIT, UNIT).map(np.array)
FINITE = st.floats(-1e9, 1e9)


def spec(kind=Kind.DOUBLE, shape=(), **options):
    return ParameterSpec(kind=kind, default=0.0, description="", shape=shape, **options)


SCALAR = spec()
VECTOR = spec(Kind.DOUBLE_ARRAY, (3,))
INERTIA = spec(Kind.DOUBLE_ARRAY, (3, 3), matrix=MatrixRule.INERTIA)


def read(text, target=SCALAR, nominal=(), name="plant.x"):
    """Return the distribution that a text describes, and what is wrong with it."""
    problems = []
    nominal = list(nominal) if isinstance(nominal, tuple) else nominal
    node = compose(text)
    found = read_distribution(node, Target(name, target, nominal), "v.yaml", problems)
    assert (found is None) == bool(problems)
    return found, [str(problem) for problem in problems]


def made(*arguments, **options):
    distribution, problems = read(*arguments, **options)
    assert not problems
    return distribution


def draws(distribution, seed=1, n=N):
    d = distribution.dimensions
    points = uniforms(seed, 0, "test", 0, n * d).reshape(n, d)
    return np.array([distribution.value(point) for point in points])
