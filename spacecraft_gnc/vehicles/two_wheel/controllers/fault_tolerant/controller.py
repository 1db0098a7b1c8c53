"""NMPC that notices the loss of a wheel and flies on with those that are left."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc import lie
from spacecraft_gnc.loop.protocols import Command, Reference, Source
from spacecraft_gnc.types import Array, Matrix3
from spacecraft_gnc.vehicles.two_wheel.build import believed_gyrostat
from spacecraft_gnc.vehicles.two_wheel.controllers.fault_tolerant.elsewhere import PlannedRest
from spacecraft_gnc.vehicles.two_wheel.controllers.fault_tolerant.holding import (
    TwoWheels,
    brake,
    go_to_rest,
    keep_turning,
)
from spacecraft_gnc.vehicles.two_wheel.controllers.fault_tolerant.run_down import RunDown
from spacecraft_gnc.vehicles.two_wheel.controllers.report import (
    Diagnosis,
    Mode,
    Rest,
    WheelReport,
    solve_of,
)
from spacecraft_gnc.vehicles.two_wheel.controllers.shooting.pilot import ShootingPilot
from spacecraft_gnc.vehicles.two_wheel.controllers.underactuated.pilot import TwoWheelPilot
from spacecraft_gnc.vehicles.two_wheel.dynamics import Gyrostat
from spacecraft_gnc.vehicles.two_wheel.hold import Held, holdable, is_negligible
from spacecraft_gnc.vehicles.two_wheel.monitor import Reading, ResidualTest, WheelMonitor
from spacecraft_gnc.vehicles.two_wheel.scenario import Scenario
from spacecraft_gnc.vehicles.two_wheel.state import WheelState
from spacecraft_gnc.vehicles.two_wheel.wheels import span_of


class _Expected(NamedTuple):
    """What the wheels that do not answer will do."""

    speeds: Array
    """(N + 1, m) over the horizon; of the others: as they are [rad/s]."""
    final: Array
    """(m,) speeds that are kept: zero of a wheel that stops within the horizon [rad/s]."""


class FaultTolerantController:
    """``method: fault_tolerant``.

    With all wheels, and with fewer that span three dimensions, the bus is flown by `ShootingPilot`.
    With two it is flown by NMPC of the underactuated spacecraft where rest at the target is
    possible (`hold.holdable`), and by the laws of `holding` where it is not. Wheels that do not
    answer are commanded to stop, which those that answer in part do.

    Parameters
    ----------
    gyrostat : Gyrostat
        As believed, with its limits; its ``time_step`` is the control period.
    test : ResidualTest
        When a wheel counts as lost.
    pilot_of : callable
        Returns the pilot of healthy wheels (m,) that span three dimensions.
    two_wheel_pilot_of : callable
        Returns the pilot of healthy wheels (m,) that span two.
    """

    name = "fault_tolerant"
    slow = True

    def __init__(
        self,
        gyrostat: Gyrostat,
        test: ResidualTest,
        pilot_of: Callable[[NDArray[np.bool_]], ShootingPilot],
        two_wheel_pilot_of: Callable[[NDArray[np.bool_]], TwoWheelPilot],
    ) -> None:
        self.gyrostat = gyrostat
        self.period = gyrostat.time_step
        self._monitor = WheelMonitor(test)
        self._pilot_of, self._two_wheel_pilot_of = pilot_of, two_wheel_pilot_of
        self._all = pilot_of(np.ones(gyrostat.n_wheels, dtype=bool))
        self.reset()

    @classmethod
    def from_scenario(cls, scenario: Scenario) -> FaultTolerantController:
        """Build the controller of a scenario's section ``nmpc_controller``.

        Raises
        ------
        GncError
            If the axes of all wheels do not span three dimensions.
        """
        c, gyrostat = scenario.controller, believed_gyrostat(scenario)

        def pilot_of(healthy: NDArray[np.bool_]) -> ShootingPilot:
            return ShootingPilot(
                gyrostat, c.feedback_bandwidth, c.feedback_damping_ratio, c.torque_horizon, healthy
            )

        def two_wheel_pilot_of(healthy: NDArray[np.bool_]) -> TwoWheelPilot:
            return TwoWheelPilot(gyrostat, c, healthy)

        none = np.zeros(gyrostat.n_wheels)
        test = ResidualTest(
            scenario.period,
            gyrostat.wheel_inertias,
            c.wheel_viscous_friction if c.wheel_viscous_friction.size else none,
            c.wheel_coulomb_friction if c.wheel_coulomb_friction.size else none,
            gyrostat.max_speed,
            gyrostat.max_acceleration,
            scenario.substeps,
        )
        return cls(gyrostat, test, pilot_of, two_wheel_pilot_of)

    def warm_up(self) -> None:
        """Compile or load the kernels of every way to fly."""
        self.reset()
        self._all.warm_up()
        two = _most_independent(self.gyrostat.wheel_axes, self._healthy)
        self._two_wheel_pilot_of(two).warm_up()
        self.reset()

    def reset(self) -> None:
        """Trust every wheel again, and forget the plans."""
        self._monitor.reset()
        self._all.reset()
        self._healthy = np.ones(self.gyrostat.n_wheels, dtype=bool)
        self._used = self._healthy
        self._pilot: ShootingPilot | TwoWheelPilot | None = self._all
        self._wheels: TwoWheels | None = None
        self._elsewhere: PlannedRest | None = None
        self._dead: dict[int, RunDown] = {}
        self._last: WheelState | None = None

    def memory(self) -> tuple[Any, ...]:
        """Return which wheels answer, what the others did, and that of the pilots."""
        pilot = None if self._pilot in (None, self._all) else self._pilot.memory()
        elsewhere = None if self._elsewhere is None else self._elsewhere.memory()
        dead = tuple((i, wheel.memory()) for i, wheel in self._dead.items())
        return (
            self._monitor.memory(),
            self._healthy,
            pilot,
            elsewhere,
            dead,
            self._last,
            (self._all.memory()),
        )

    def recall(self, memory: tuple[Any, ...]) -> None:
        """Go on as the controller did whose `memory` it is."""
        monitor, healthy, pilot, elsewhere, dead, last, of_all = memory
        self._monitor.recall(monitor)
        self._all.recall(of_all)
        if not healthy.all():
            self._switch(healthy)
        if pilot is not None and self._pilot is not None:
            self._pilot.recall(pilot)
        if elsewhere is not None and self._elsewhere is not None:
            self._elsewhere.recall(elsewhere)
        for i, wheel in dead:
            self._dead[i].recall(wheel)
        self._last = None if last is None else WheelState(*last)

    def command(self, state: WheelState, reference: Reference) -> Command:
        """Wheel accelerations (m,) [rad/s^2] for the control step that starts at ``state``."""
        reading = self._monitor.observe(state)
        if not np.array_equal(reading.healthy, self._healthy):
            self._switch(reading.healthy)
        self._follow(state)
        target = reference.attitude
        if not _is_finite(state, target):
            nothing = np.zeros(self.gyrostat.n_wheels)
            return Command(nothing, Source.ZERO, WheelReport(None, self._unknown(reading)))
        command, mode, held = self._fly(state, target, reading)
        report = WheelReport(solve_of(command), _told(reading, mode, held))
        acceleration = command.control.copy()
        for i, dead in self._dead.items():
            acceleration[i] = dead.stop(float(state.wheel_speed[i]))
        return Command(acceleration, command.source, report)

    def _switch(self, healthy: NDArray[np.bool_]) -> None:
        """Fly on with fewer wheels: those of them that are not used are brought to rest as well."""
        self._healthy = healthy
        axes = self.gyrostat.wheel_axes
        rank = span_of(axes[:, healthy])
        self._used = healthy if rank != 2 else _most_independent(axes, healthy)
        most = self.gyrostat.max_acceleration or math.inf
        idle = np.flatnonzero(~self._used).tolist()
        self._dead = {i: self._dead.get(i) or RunDown(self.period, most) for i in idle}
        self._pilot = self._wheels = self._elsewhere = None
        if rank == 3:
            self._pilot = self._pilot_of(healthy)
        elif rank == 2:
            self._pilot = self._two_wheel_pilot_of(self._used)
            self._wheels = TwoWheels(self.gyrostat, self._used)
            self._elsewhere = PlannedRest(self._wheels, self._pilot)

    def _follow(self, state: WheelState) -> None:
        """Take in what the wheels that do not answer did over the last step."""
        last, self._last = self._last, state
        if last is None or state.applied is None or state.step != last.step + 1:
            return
        for i, dead in self._dead.items():
            told = float(state.applied[i])
            numbers = float(last.wheel_speed[i]), told, float(state.wheel_speed[i])
            if math.isfinite(sum(numbers)):
                dead.observe(*numbers)

    def _fly(
        self, state: WheelState, target: Matrix3, reading: Reading
    ) -> tuple[Command, Mode, Held]:
        """Return the command for the wheels that answer, how it is flown, and what is held."""
        expected, pilot = self._expect(state), self._pilot
        if isinstance(pilot, ShootingPilot):
            mode = Mode.REALLOCATED if self._dead else Mode.NOMINAL
            command = pilot.command(state, target, self._own(expected, reading))
            return command, mode, Held(Rest.AT_TARGET, target, np.zeros(3), 0.0)
        if self._wheels is None or self._elsewhere is None or pilot is None:
            acceleration, held = brake(self.gyrostat, self._used, state, target)
            return Command(acceleration), Mode.HOLDING, held
        held = self._holdable(state, expected, target)
        if held.rest is Rest.AT_TARGET and self._is_free(state):
            drift = self._drift(expected)
            return pilot.command(state, target, drift), Mode.UNDERACTUATED, held
        if held.rest is Rest.NOWHERE:
            u = keep_turning(self._wheels, state, held, expected.speeds[1])
            return Command(u), Mode.HOLDING, held
        planned = self._elsewhere.accelerations(state, held, expected.speeds)
        if planned is None:
            pilot.reset()
            planned = go_to_rest(self._wheels, state, held, expected.speeds[1])
        return Command(planned), Mode.HOLDING, held

    def _own(self, expected: _Expected, reading: Reading) -> Array | None:
        """Return the accelerations (m,) that the wheels have beside those commanded; None: none.

        Of those that answer: what friction took from them over the last step. One that sticks is
        thus commanded more and more until it moves.
        """
        rubs = bool(self._monitor.test.offset.any() or self._monitor.test.slope.any())
        if not (self._dead or rubs):
            return None
        own = (expected.speeds[1] - expected.speeds[0]) / self.period
        known = self._healthy & np.isfinite(reading.residual)
        taken = np.where(known, reading.residual, 0.0) / self.period
        return np.asarray(own + taken if rubs else own)

    def _expect(self, state: WheelState) -> _Expected:
        """Predict the wheels that do not answer."""
        steps = getattr(self._pilot, "horizon", 1)
        speeds = np.tile(state.wheel_speed, (steps + 1, 1))
        final = state.wheel_speed.copy()
        for i, dead in self._dead.items():
            speeds[:, i], final[i] = dead.predict(float(state.wheel_speed[i]), steps)
        return _Expected(speeds, final)

    def _holdable(self, state: WheelState, expected: _Expected, target: Matrix3) -> Held:
        g = self.gyrostat
        return holdable(
            g.inertia, g.wheel_axes, g.wheel_inertias, self._used, expected.final,
            state.total_momentum, target,
        )  # fmt: skip

    def _is_free(self, state: WheelState) -> bool:
        """Tell whether there is no total momentum."""
        return is_negligible(self.gyrostat.inertia, state.total_momentum)

    def _drift(self, expected: _Expected) -> Array:
        """Return the rate (N + 1, 3) that wheels which do not answer give the bus."""
        dead = ~self._used
        momentum = expected.speeds[:, dead] @ self.gyrostat.wheels[:, dead].T
        return np.asarray(-np.linalg.solve(self.gyrostat.inertia, momentum.T).T)

    def _unknown(self, reading: Reading) -> Diagnosis:
        nothing = Held(Rest.NOWHERE, np.eye(3), np.zeros(3), 0.0)
        return _told(reading, Mode.HOLDING, nothing)


def _most_independent(axes: Array, healthy: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the two wheels (m,) of ``healthy`` whose axes are nearest to a right angle."""
    pairs = combinations(np.flatnonzero(healthy).tolist(), 2)
    best = max(pairs, key=lambda pair: float(np.linalg.norm(np.cross(*axes[:, pair].T))))
    return np.asarray(np.isin(np.arange(len(healthy)), best))


def _told(reading: Reading, mode: Mode, held: Held) -> Diagnosis:
    return Diagnosis(
        reading.healthy, reading.residual, reading.threshold, reading.response, mode, held.rest,
        held.rate, held.attitude, held.pointing_loss,
    )  # fmt: skip


def _is_finite(state: WheelState, target: Matrix3) -> bool:
    """Tell whether a state and its target are rotations and finite numbers."""
    numbers = (state.angular_velocity, state.wheel_speed, state.total_momentum)
    finite = all(np.isfinite(part).all() for part in numbers)
    return finite and lie.is_rotation(state.attitude) and lie.is_rotation(target)
