"""Random problems for the solver tests, also for the independent implementation."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st
from independent import Problem
from strategies import inertias, rotations, vectors, weights

from spacecraft_gnc import lie
from spacecraft_gnc.ocp import AttitudeOcp, PointingZone, Status, Weights
from spacecraft_gnc.ocp import _shooting_kernels as kernels
from spacecraft_gnc.ocp._stage_kernels import work_size
from spacecraft_gnc.ocp.reference import as_reference
from spacecraft_gnc.ocp.rollout import track_of
from spacecraft_gnc.types import Reference


def independent(ocp, reference=None):
    """The same problem for the independent implementation."""
    reference = as_reference(reference)
    w = ocp.weights
    zones = [
        (z.body_axis, -z.sign * z.inertial_axis, -z.sign * math.cos(z.half_angle), z.penalty)
        for z in ocp.zones
    ]
    return Problem(
        ocp.inertia, ocp.time_step, ocp.horizon, w.stage_attitude, w.stage_momentum, w.stage_torque,
        w.terminal_attitude, w.terminal_momentum, ocp.max_torque**2, ocp.torque_penalty, zones,
        *reference,
    )  # fmt: skip


def kernel_arguments(ocp, attitude, momentum, reference):
    """Constants (body, data, zones, track) and arrays (R, Pi, u, lam, W) that the kernels take."""
    n = ocp.horizon
    R, Pi = np.empty((n + 1, 3, 3)), np.empty((n + 1, 3))
    u, lam = np.empty((n, 3)), np.empty((n, 6))
    R[0], Pi[0] = attitude, momentum
    constants = (ocp.body.packed, ocp.data, ocp.zone_rows, track_of(ocp, reference))
    return constants, (R, Pi, u, lam, np.zeros((n, work_size(ocp.n_controls))))


def shoot(ocp, attitude, momentum, reference, multipliers):
    """Residual (44) and its derivative from the kernels."""
    constants, horizon = kernel_arguments(ocp, attitude, momentum, reference)
    horizon[3][0] = multipliers
    T, E = np.empty((6, 12)), np.empty((6, 6))
    status, E1, E2 = kernels.propagate_horizon(*constants, *horizon)
    assume(status != Status.UNSOLVABLE_STEP)  # such multipliers rotate the body too far in a step
    assert status == Status.CONVERGED
    kernels.shooting_jacobian(*constants, *horizon, T, E, False)
    return np.array([*E1, *E2]), E


@st.composite
def references(draw):
    """An attitude at rest or in motion, with a torque that may be unrelated to the motion."""
    attitude = draw(rotations())
    if draw(st.booleans()):
        return attitude
    return Reference(attitude, draw(vectors(0.5)), draw(vectors(0.2)))


@st.composite
def problems(draw, penalties=(10.0, 1e4)):
    """A problem with full matrices, and a zone and a torque limit that are often active."""
    axis = draw(rotations())[:, 0]
    zone = PointingZone(
        draw(st.sampled_from(["exclusion", "inclusion"])), draw(rotations())[:, 0], axis,
        draw(st.floats(0.3, 2.0)), draw(st.floats(0.01, 1.0)),
    )  # fmt: skip
    return AttitudeOcp(
        draw(inertias()), draw(st.floats(0.05, 0.4)), draw(st.integers(1, 8)),
        Weights(*(draw(weights(smallest)) for smallest in (0.0, 0.0, 0.1, 0.0, 0.0))),
        max_torque=draw(st.sampled_from([0.0, 0.1, 0.3])),
        torque_penalty=draw(st.floats(*penalties)), zones=(zone,),
    )  # fmt: skip


def random_weight(rng, smallest, largest):
    """A full symmetric weight with eigenvalues between two powers of ten."""
    axes = random_rotation(rng)
    weight = axes @ np.diag(10.0 ** rng.uniform(smallest, largest, 3)) @ axes.T
    return 0.5 * (weight + weight.T)


def random_rotation(rng):
    """A rotation, uniform over the group."""
    return lie.from_quaternion_xyzw(rng.normal(size=4))


def random_problem(rng, largest_horizon=50, penalties=(4.0, 10.0)):
    """A problem with full matrices, up to two zones, usually a limit; attitude and momentum."""
    a, b, c = rng.uniform(0.2, 1.0, 3)
    axes = random_rotation(rng)
    inertia = axes @ np.diag([b + c, a + c, a + b]) @ axes.T
    zones = tuple(
        PointingZone(
            "exclusion", rng.normal(size=3), rng.normal(size=3), float(rng.uniform(0.1, 0.6)),
            float(10.0 ** rng.uniform(0.0, 3.0)),
        )
        for _ in range(rng.integers(0, 3))
    )  # fmt: skip
    ocp = AttitudeOcp(
        0.5 * (inertia + inertia.T), float(rng.choice([0.1, 0.2, 0.4])),
        int(rng.integers(2, largest_horizon + 1)),
        Weights(
            random_weight(rng, -3, 0), random_weight(rng, -3, 0), random_weight(rng, -1, 1),
            random_weight(rng, -3, 0), random_weight(rng, -3, 0),
        ),
        max_torque=float(rng.choice([0.0, 0.01, 0.1, 0.5])),
        torque_penalty=float(10.0 ** rng.uniform(*penalties)), zones=zones,
    )  # fmt: skip
    momentum = rng.normal(size=3)
    momentum *= rng.uniform(0.0, 0.5) / np.linalg.norm(momentum)
    return ocp, random_rotation(rng), momentum
