"""Order of the integrator toward the continuous motion, free and under a torque held in each step.

python benchmarks/integrator_order.py

The body of benchmarks/basilisk_plant.py tumbles for 4 s at about 60 deg/s. The truth is scipy's
DOP853 on the continuous equations, to 1e-13. The error is the angle of the attitude and the
distance of the momentum at the end, and the order the logarithm to base 2 of what it falls by as
the step is halved.
"""

from __future__ import annotations

import sys

import numpy as np
from scipy.integrate import solve_ivp

from spacecraft_gnc import lie
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.types import Array

INERTIA = np.array([[1.0, 0.05, -0.1], [0.05, 0.8, 0.02], [-0.1, 0.02, 0.9]])  # [kg m^2]
ATTITUDE = lie.exp(np.array([0.25, 0.5, 0.5]))
MOMENTUM = np.array([0.3, -0.5, 0.8])  # [N m s]
TORQUE = np.array([0.05, -0.02, 0.03])  # [N m]
DURATION = 4.0  # [s]
STEPS = (50, 100, 200, 400, 800, 1600, 3200)
MOTIONS = {"free": 0.0, "torque held": 1.0, "torque held, half a kick first": 1.0}


def truth(torque: Array) -> tuple[Array, Array]:
    """DOP853 on R' = R hat(omega), Pi' = Pi x omega + u."""
    inverse = np.linalg.inv(INERTIA)

    def rate(_: float, x: Array) -> Array:
        omega = inverse @ x[9:]
        turned = x[:9].reshape(3, 3) @ lie.hat(omega)
        return np.concatenate([turned.ravel(), np.cross(x[9:], omega) + torque])

    start = np.concatenate([ATTITUDE.ravel(), MOMENTUM])
    x = solve_ivp(rate, (0.0, DURATION), start, method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    return x[:9].reshape(3, 3), x[9:]


def errors(n: int, torque: Array, kick: float, end: tuple[Array, Array]) -> tuple[float, float]:
    """Error of attitude [rad] and momentum [N m s] after n steps, ``kick`` of one moved ahead."""
    h = DURATION / n
    R, Pi = RigidBody(INERTIA, h).step(ATTITUDE, MOMENTUM + kick * h * torque, torque, n)
    momentum = Pi - kick * h * torque
    return lie.angle_between(R, end[0]), float(np.linalg.norm(momentum - end[1]))


def main() -> int:
    """Print errors and orders."""
    for name, share in MOTIONS.items():
        torque, kick = share * TORQUE, 0.5 if "half" in name else 0.0
        end, last = truth(torque), None
        for n in STEPS:
            found = errors(n, torque, kick, end)
            line = f"{name:31s} h {DURATION / n:8.5f} s  {found[0]:.2e} rad {found[1]:.2e} N m s"
            if last is not None:
                line += "  order {:.2f} {:.2f}".format(*np.log2(np.array(last) / np.array(found)))
            print(line)
            last = found
    return 0


if __name__ == "__main__":
    sys.exit(main())
