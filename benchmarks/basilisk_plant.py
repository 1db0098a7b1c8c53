"""Compare the integrator with Basilisk's spacecraft, once, on the same free and driven motion.

Basilisk is no dependency: make an environment of its own (`python3 -m venv /tmp/bsk &&
/tmp/bsk/bin/pip install bsk numba scipy`) and run `PYTHONPATH=. /tmp/bsk/bin/python
benchmarks/basilisk_plant.py`. The figures in docs/dynamics.md come from here. The truth is scipy's
DOP853 at a tolerance of 1e-13.
"""

from __future__ import annotations

import time

import numpy as np
from Basilisk.simulation import extForceTorque, spacecraft
from Basilisk.utilities import RigidBodyKinematics as Kinematics
from Basilisk.utilities import SimulationBaseClass, macros
from scipy.integrate import solve_ivp

from spacecraft_gnc import lie
from spacecraft_gnc.dynamics import RigidBody

INERTIA = np.array([[1.0, 0.05, -0.1], [0.05, 0.8, 0.02], [-0.1, 0.02, 0.9]])  # [kg m^2]
ATTITUDE = lie.exp(np.array([0.25, 0.5, 0.5]))
MOMENTUM = np.array([0.3, -0.5, 0.8])  # [N m s]
DURATION = 100.0  # [s]
TORQUES = {"free": np.zeros(3), "driven": np.array([0.005, -0.002, 0.003])}  # [N m]


def truth(torque):
    """DOP853 on R' = R hat(omega), Pi' = Pi x omega + u."""
    inverse = np.linalg.inv(INERTIA)

    def rate(_, x):
        omega = inverse @ x[9:]
        turned = x[:9].reshape(3, 3) @ lie.hat(omega)
        return np.concatenate([turned.ravel(), np.cross(x[9:], omega) + torque])

    start = np.concatenate([ATTITUDE.ravel(), MOMENTUM])
    x = solve_ivp(rate, (0.0, DURATION), start, method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    return lie.orthonormalize(x[:9].reshape(3, 3)), x[9:]


def basilisk(torque, step):
    """Basilisk's rigid hub with its default integrator (RK4 on MRPs)."""
    simulation = SimulationBaseClass.SimBaseClass()
    process = simulation.CreateNewProcess("dynamics")
    process.addTask(simulation.CreateNewTask("task", macros.sec2nano(step)))
    body = spacecraft.Spacecraft()
    body.hub.mHub = 100.0
    body.hub.IHubPntBc_B = INERTIA.tolist()
    body.hub.sigma_BNInit = Kinematics.C2MRP(ATTITUDE.T).reshape(3, 1).tolist()
    body.hub.omega_BN_BInit = np.linalg.solve(INERTIA, MOMENTUM).reshape(3, 1).tolist()
    effector = extForceTorque.ExtForceTorque()
    effector.extTorquePntB_B = torque.reshape(3, 1).tolist()
    body.addDynamicEffector(effector)
    for model in (effector, body):
        simulation.AddModelToTask("task", model)
    simulation.InitializeSimulation()
    simulation.ConfigureStopTime(macros.sec2nano(DURATION))
    begun = time.perf_counter()
    simulation.ExecuteSimulation()
    elapsed = time.perf_counter() - begun
    message = body.scStateOutMsg.read()
    attitude = Kinematics.MRP2C(np.array(message.sigma_BN)).T
    return attitude, INERTIA @ np.array(message.omega_BN_B), elapsed


def ours(torque, step):
    """Run the integrator, the torque in half kicks at both ends to read the same instant."""
    body, n = RigidBody(INERTIA, step), round(DURATION / step)
    body.step(ATTITUDE, MOMENTUM, torque)
    begun = time.perf_counter()
    attitude, momentum = body.step(ATTITUDE, MOMENTUM + 0.5 * step * torque, torque, n)
    elapsed = time.perf_counter() - begun
    return attitude, momentum - 0.5 * step * torque, elapsed


def main():
    """Print the table of docs/dynamics.md."""
    print("| motion | step [s] | integrator | attitude error [rad] | momentum error, relative "
          "| inertial momentum drift, relative | us/step |")  # fmt: skip
    print("|---|---|---|---|---|---|---|")
    for motion, torque in TORQUES.items():
        attitude, momentum = truth(torque)
        for step in (0.1, 0.01):
            for name, method in (("ours (LGVI)", ours), ("Basilisk (RK4)", basilisk)):
                R, Pi, elapsed = method(torque, step)
                error = lie.angle_between(R, attitude)
                relative = np.abs(Pi - momentum).max() / np.linalg.norm(momentum)
                drift = np.abs(R @ Pi - ATTITUDE @ MOMENTUM).max() / np.linalg.norm(MOMENTUM)
                shown = f"{drift:.1e}" if motion == "free" else "-"
                print(f"| {motion} | {step} | {name} | {error:.1e} | {relative:.1e} | {shown} "
                      f"| {elapsed / (DURATION / step) * 1e6:.2f} |")  # fmt: skip


if __name__ == "__main__":
    main()
