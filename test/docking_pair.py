"""Deputy and chief of the AFRL report, and their relative motion written down independently.

The truth is Hill's equation with the two attractions as they stand, and Euler's equation in the
deputy frame: other frames and other formulas than the package's, integrated by DOP853.
"""

from __future__ import annotations

import math

import numpy as np
from independent import hat, vee
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from spacecraft_gnc.plant.earth import GRAVITATIONAL_PARAMETER as EARTH
from spacecraft_gnc.vehicles.docking.chief import ChiefMotion
from spacecraft_gnc.vehicles.docking.dynamics import RelativeMotion
from spacecraft_gnc.vehicles.docking.geometry import Cuboid

MASS, N, T = 130.0, 0.0012, 5.0
DEPUTY = Cuboid([0.6, 0.6, 0.8], [-0.3, 0.0, 0.1])
CHIEF = Cuboid([1.04, 1.15, 1.57], [0.52, 0.0, 0.2])
SPIN = 2.0 * math.pi / 1000.0
PERIOD = 200
FULL_INERTIA = np.array([[11.0, 0.6, -0.3], [0.6, 9.0, 0.4], [-0.3, 0.4, 7.5]])
Q = np.diag([0.01] * 3 + [1.0] * 3 + [0.1] * 3 + [10.0] * 3)
R = np.diag([1.0] * 3 + [100.0] * 3)
STARTS = (
    ([20.0, 4.0, -3.0], [0.3, -0.2, 0.25]),
    ([10.0, -3.0, 2.0], [-0.2, 0.3, 0.4]),
    ([30.0, 8.0, 6.0], [0.1, 0.5, -0.3]),
)


def pair(tilt=0.0, spin=SPIN, substeps=20, period=T, inertia=None, attitude=None, **options):
    """Deputy and chief, whose spin axis is tilted from the normal by an angle [rad]."""
    axis = [math.sin(tilt), 0.0, math.cos(tilt)]
    initial = np.eye(3) if attitude is None else attitude
    chief = ChiefMotion(N, spin, axis, initial)
    inertia = DEPUTY.inertia(MASS) if inertia is None else inertia
    return RelativeMotion(MASS, inertia, DEPUTY, CHIEF, chief, period, substeps, **options)


def rotation(vector):
    return Rotation.from_rotvec(vector).as_matrix()


def chief_attitude(motion, t):
    chief = motion.chief
    return rotation(chief.spin_rate * t * chief.spin_axis) @ chief.initial_attitude


def to_hill(motion, t, rho, velocity, R_CD, w):
    """Center of mass, its velocity seen in Hill's frame, R_HD and the inertial rate, deputy frame.

    By differentiating r_H = R_HC (c + rho - R_CD p).
    """
    R_HC, spin = chief_attitude(motion, t), motion.chief.spin_rate * motion.chief.spin_axis
    r_C = CHIEF.port + rho - R_CD @ DEPUTY.port
    v_C = velocity - hat(w) @ R_CD @ DEPUTY.port
    r_H = R_HC @ r_C
    R_HD = R_HC @ R_CD
    rate_H = R_HC @ w + spin + [0.0, 0.0, N]
    return r_H, R_HC @ v_C + np.cross(spin, r_H), R_HD, R_HD.T @ rate_H


def from_hill(motion, t, r_H, v_H, R_HD, rate_D):
    R_HC, spin = chief_attitude(motion, t), motion.chief.spin_rate * motion.chief.spin_axis
    R_CD = R_HC.T @ R_HD
    w = R_HC.T @ (R_HD @ rate_D - spin - [0.0, 0.0, N])
    arm = R_CD @ DEPUTY.port
    rho = R_HC.T @ r_H + arm - CHIEF.port
    return rho, R_HC.T @ (v_H - np.cross(spin, r_H)) + np.cross(w, arm), R_CD, w


def hill_slope(motion, t, y, force_C, moment_C, blocked=()):
    """Rate of (r_H, v_H, R_HD, rate_D); ``blocked`` are (axis, sign) of lost directions."""
    r, v, R_HD, rate = y[:3], y[3:6], y[6:15].reshape(3, 3), y[15:]
    R_DC = R_HD.T @ chief_attitude(motion, t)
    force, J = R_DC @ force_C, motion.inertia
    for axis, sign in blocked:
        force[axis] = sign * min(sign * force[axis], 0.0)
    gravity = N * N * np.array([2.0 * r[0], -r[1], -r[2]])
    if motion.two_body:
        a = (EARTH / N**2) ** (1.0 / 3.0)
        place = np.array([a, 0.0, 0.0]) + r
        gravity = np.array([EARTH / a**2, 0, 0]) - EARTH * place / np.linalg.norm(place) ** 3
    frame = 2.0 * N * np.array([v[1], -v[0], 0.0]) + N * N * np.array([r[0], r[1], 0.0])
    moment = R_DC @ moment_C
    if motion.gravity_gradient:
        moment = moment + 3.0 * N**2 * np.cross(R_HD[0], J @ R_HD[0])
    spin = np.linalg.solve(J, moment - np.cross(rate, J @ rate))
    R_dot = R_HD @ hat(rate) - hat([0.0, 0.0, N]) @ R_HD
    return np.concatenate([v, gravity + frame + R_HD @ force / MASS, R_dot.ravel(), spin])


def truth(motion, t, state, force, moment, duration, blocked=()):
    """State after a time with force and moment held, by DOP853."""
    y = np.concatenate([np.ravel(part) for part in to_hill(motion, t, *state)])
    solved = solve_ivp(
        lambda s, y: hill_slope(motion, t + s, y, force, moment, blocked),
        (0.0, duration), y, method="DOP853", rtol=1e-13, atol=1e-14,
    )  # fmt: skip
    y = solved.y[:, -1]
    return from_hill(motion, t + duration, y[:3], y[3:6], y[6:15].reshape(3, 3), y[15:])


def difference(one, other):
    """Largest difference of two states."""
    return max(float(np.abs(a - b).max()) for a, b in zip(one[:4], other[:4], strict=True))


def turned(first, second):
    """Rotation vector from one nearby rotation to another, chief frame."""
    return vee(second @ first.T)


def fly(motion, model, gains, start, steps, reference=None):
    """Fly U = U0 + Gamma v - K (x - E v), unlimited: x, U, line of sight and clearance by step."""
    from spacecraft_gnc.vehicles.docking.linear import coordinates

    v = np.zeros(6) if reference is None else reference
    state = (np.array(start[0]), np.zeros(3), rotation(start[1]), np.zeros(3))
    margins = [motion.margins(state[0], state[2])]
    x, wrenches = [coordinates(*state)], []
    for k in range(steps):
        wrenches.append(model.wrench(k, x[-1], v, gains))
        done = motion.advance(T * k, *state, wrenches[-1][:3], wrenches[-1][3:])
        state = done[:4]
        x.append(coordinates(*state))
        margins.append(done[4:])
    return np.array(x), np.array(wrenches), *np.array(margins).T
