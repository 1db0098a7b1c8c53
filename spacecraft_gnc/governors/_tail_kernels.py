"""Kernels that test the nominal loop at sampled states; `tail` documents them."""

from __future__ import annotations

from spacecraft_gnc._kernels import kernel
from spacecraft_gnc.dynamics._lgvi_kernels import held
from spacecraft_gnc.governors._feedback_kernels import feedback_torque
from spacecraft_gnc.governors._geodesic_kernels import exponential, logarithm
from spacecraft_gnc.governors._prediction_kernels import cosine_of, in_tail, quadratic_form
from spacecraft_gnc.lie._mat3_kernels import load3


@kernel
def worst_growth(body, h, substeps, law, tail, samples):
    """Largest ratio of x . P x over one period, at samples x (n, 6) of the nonlinear loop."""
    worst = 0.0
    for k in range(samples.shape[0]):
        eta, Pi = load3(samples, k), load3(samples, k, 3)
        before = quadratic_form(tail, eta, Pi)
        E = exponential(eta)
        E, Pi, done = held(body, h, E, Pi, feedback_torque(law, E, Pi), substeps)
        after = quadratic_form(tail, logarithm(E), Pi)
        if done != substeps or not after <= worst * before:  # NaN counts
            worst = after / before if done == substeps else 1e300
    return worst


@kernel
def longest_arrival(body, h, substeps, law, tail, c, samples, most):
    """Most steps that a sample x (n, 6) needs to the tail set of level c; -1: more than ``most``.

    The reference is I.
    """
    longest, cosine = 0, cosine_of(tail, c)
    for k in range(samples.shape[0]):
        E, Pi = exponential(load3(samples, k)), load3(samples, k, 3)
        steps = 0
        while not in_tail(tail, c, cosine, E, Pi):
            E, Pi, done = held(body, h, E, Pi, feedback_torque(law, E, Pi), substeps)
            steps += 1
            if done != substeps or steps > most:
                return -1
        longest = max(longest, steps)
    return longest
