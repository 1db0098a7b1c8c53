"""Figures of docs/two_wheel.md, which gives the command."""

from __future__ import annotations

import time

import numpy as np
from test_dynamics import Bodies
from test_feedback import TARGET, at_rest, fly
from test_friction import FRICTION
from wheeled import ATTITUDE, ORTHOGONAL, PYRAMID, RATE, SPEEDS, afrl, momentum, small, start

from spacecraft_gnc import lie
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.vehicles.two_wheel.controllers.feedback.law import WheelFeedback
from spacecraft_gnc.vehicles.two_wheel.dynamics import Gyrostat
from spacecraft_gnc.vehicles.two_wheel.metrics import summarize


def timed(call, *arguments, repeat=1):
    call(*arguments)
    began = time.perf_counter()
    for _ in range(repeat):
        result = call(*arguments)
    return result, 1e6 * (time.perf_counter() - began) / repeat


def invariants():
    print("# a million steps of 0.01 s, four wheels: worst relative drift")
    smooth, n = small(PYRAMID, 0.01, max_speed=200.0), 1_000_000
    rubbing = small(PYRAMID, 0.01, max_speed=200.0, **FRICTION)
    commands = np.random.default_rng(0).normal(scale=20.0, size=(n, 4))
    for name, gyrostat, given in (
        ("held", smooth, np.zeros((n, 4))),
        ("driven", smooth, commands),
        ("driven, with friction", rubbing, commands),
    ):
        motion, spent = timed(gyrostat.simulate, start(gyrostat), given)
        total = momentum(gyrostat, *motion)
        drift = np.abs(total - total[0]).max() / np.linalg.norm(total[0])
        energy = 0.5 * np.einsum("ni,ni->n", motion[1], motion[1] @ gyrostat.inertia)
        swing = np.abs(energy / energy[0] - 1.0).max()
        print(f"{name}: momentum {drift:.1e}, bus energy {swing:.1e}, {spent / n:.2f} us a step")


def accuracy():
    print("# 4 s, four wheels accelerating, against DOP853: error of attitude [rad], rate [rad/s]")
    bodies, driven = Bodies(np.random.default_rng(2), PYRAMID), np.array([9.0, -4.0, 6.0, -7.0])
    turned, turning, _ = bodies.fly(ATTITUDE, RATE, SPEEDS, driven, 4.0)
    for n in (20, 40, 80, 160):
        gyrostat = Gyrostat(bodies.locked(), PYRAMID, bodies.axial, 4.0 / n)
        state = gyrostat.step(gyrostat.state_from_rate(ATTITUDE, RATE, SPEEDS), driven, n)
        off = np.linalg.norm(state.angular_velocity - turning)
        print(f"{4.0 / n:.3f} s: {lie.angle_between(state.attitude, turned):.1e} {off:.1e}")
    print("# the same with friction, c = 2e-3 N m s, tau = 0.02 N m, of which no wheel stops")
    friction, driven = (2e-3, 0.02), 0.1 * driven
    turned, turning, _ = bodies.fly(ATTITUDE, RATE, SPEEDS, driven, 4.0, friction)
    rub = dict(zip(FRICTION, np.outer(friction, np.ones(4)), strict=True))
    for n in (20, 40, 80, 160):
        gyrostat = Gyrostat(bodies.locked(), PYRAMID, bodies.axial, 4.0 / n, **rub)
        state = gyrostat.step(gyrostat.state_from_rate(ATTITUDE, RATE, SPEEDS), driven, n)
        off = np.linalg.norm(state.angular_velocity - turning)
        print(f"{4.0 / n:.3f} s: {lie.angle_between(state.attitude, turned):.1e} {off:.1e}")
    rest, n = np.zeros(3), 40
    inertia = bodies.locked()
    turned, turning, _ = bodies.fly(ATTITUDE, RATE, np.zeros(4), np.zeros(4), 4.0)
    attitude, _ = RigidBody(inertia, 4.0 / n).step(ATTITUDE, inertia @ RATE, rest, n)
    gyrostat = Gyrostat(inertia, PYRAMID, bodies.axial, 4.0 / n)
    state = gyrostat.step(gyrostat.state_from_rate(ATTITUDE, RATE, np.zeros(4)), np.zeros(4), n)
    errors = [lie.angle_between(a, turned) for a in (state.attitude, attitude)]
    print(f"locked, 0.1 s: this {errors[0]:.1e}, LGVI {errors[1]:.1e}")


def feedback():
    print("# report's spacecraft, three wheels, w = 0.012 rad/s, period 10 s: settle time [s], ...")
    gyrostat = afrl(ORTHOGONAL)
    law = WheelFeedback(gyrostat, 0.012)
    axis = np.array([0.5, 0.3, -0.4])
    for degrees in (40.5, 90.0, 135.0, 175.0, 179.9):
        error = np.radians(degrees) * axis / np.linalg.norm(axis)
        found = summarize(*fly(gyrostat, law, at_rest(gyrostat, error), 400, 10), TARGET)
        print(f"{degrees} deg:", {name: found[name] for name in list(found)[:4]})
    state = at_rest(gyrostat, axis)
    print(f"command {timed(law.acceleration, state, TARGET, repeat=10000)[1]:.0f} us,", end=" ")
    print(f"10 substeps {timed(gyrostat.step, state, np.ones(3), 10, repeat=10000)[1]:.0f} us")


if __name__ == "__main__":
    invariants()
    accuracy()
    feedback()
