"""Seeded random problems without units, and their form in given units of mass, time and cost.

A problem is drawn with the time step, the largest moment of inertia and the weight of the attitude
equal to one, so that its difficulty does not depend on its units. `in_units` writes it in kg m^2,
s and N m: J m, h t, Pi m/t, u m/t^2, and the weights so that the cost is multiplied by the unit c.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.ocp import AttitudeOcp, PointingZone, Weights

Vector = np.ndarray

VERSION = 1  # of the drawing: results of another version are not of these problems
LONGEST = 60  # [steps]
MOST_ZONES = 4


@dataclass(frozen=True)
class Drawn:
    """One problem without units; weights are (3, 3), Q1, Q2, Q3, P1, P2 of the paper.

    ``limit`` is 0 where there is none; ``control_scale`` is the limit or what would be a fitting
    one. A zone is a body axis, an inertial axis, a half-angle, a sign (1: exclusion), a penalty.
    ``units`` are (mass, time, cost), ``other_units`` those to solve the problem in once more.
    """

    seed: int
    horizon: int
    inertia: Vector
    stage_attitude: Vector
    stage_momentum: Vector
    stage_torque: Vector
    terminal_attitude: Vector
    terminal_momentum: Vector
    actuators: Vector
    limit: float
    control_scale: float
    penalty: float
    zones: list[tuple[Vector, Vector, float, float, float]]
    attitude: Vector
    momentum: Vector
    reference: Vector
    units: tuple[float, float, float]
    other_units: tuple[float, float, float] | None

    def plain(self) -> dict[str, Any]:
        """Return the problem as what JSON holds."""
        return {name: _plain(value) for name, value in asdict(self).items()}

    @classmethod
    def of(cls, plain: dict[str, Any]) -> Drawn:
        """Return the problem that `plain` wrote."""
        kept = {"zones", "units", "other_units"}
        arrays = {
            name: np.array(value) if isinstance(value, list) and name not in kept else value
            for name, value in plain.items()
        }
        return cls(**arrays)


def _plain(value: Any) -> Any:
    if isinstance(value, (list, tuple)):
        return [_plain(part) for part in value]
    return value.tolist() if isinstance(value, np.ndarray) else value


def draw(seed: int) -> Drawn:
    """Return the problem of a seed."""
    rng = np.random.default_rng([VERSION, seed])
    inertia, smallest = _inertia(rng)
    reach = smallest * _power(rng, -4.0, -0.5)  # torque that turns by 1e-4 .. 0.3 rad in a step
    limited = rng.random() < 0.8
    actuators, equal = _actuators(rng)
    horizon = round(math.exp(rng.uniform(0.0, math.log(LONGEST))))
    # Small turns want a torque of about wanted * reach * (angle): a saturated one, or a small one.
    wanted = _power(rng, -1.5, 2.0) if limited else _power(rng, -2.0, 0.3)
    effort = horizon**2 / (2.0 * wanted * reach * smallest)
    damping = _power(rng, -4.0, 1.0) / (reach * smallest)
    attitude, momentum = _state(rng, inertia)
    # On the target the torque is zero only where the product of the two rotations is exact.
    plain = rng.random() < 0.5 or bool((attitude == np.eye(3)).all())
    reference = np.eye(3) if plain else _rotation(rng)
    return Drawn(
        seed,
        horizon,
        inertia,
        _weight(rng, float(rng.random() < 0.95)),
        _weight(rng, damping * float(rng.random() < 0.95)),
        effort * np.eye(3) if equal else _weight(rng, effort),
        _weight(rng, _power(rng, -1.0, 2.0)),
        _weight(rng, damping * _power(rng, -1.0, 2.0)),
        actuators,
        reach if limited else 0.0,
        reach,
        effort / reach**2 * _power(rng, 1.0, 7.5),
        [_zone(rng) for _ in range(rng.integers(0, MOST_ZONES + 1))],
        reference @ attitude,
        momentum,
        reference,
        *_units(rng, reach, seed),
    )


def _power(rng: np.random.Generator, least: float, most: float) -> float:
    return float(10.0 ** rng.uniform(least, most))


def _rotation(rng: np.random.Generator) -> Vector:
    return lie.from_quaternion_xyzw(rng.normal(size=4))


def _direction(rng: np.random.Generator) -> Vector:
    vector = rng.normal(size=3)
    return vector / np.linalg.norm(vector)


def _turned(rng: np.random.Generator, diagonal: Vector) -> Vector:
    """Return a matrix with given eigenvalues in a random frame."""
    axes = _rotation(rng)
    matrix = axes @ np.diag(diagonal) @ axes.T
    return 0.5 * (matrix + matrix.T)


def _inertia(rng: np.random.Generator) -> tuple[Vector, float]:
    """Return an inertia whose largest moment is one, and its smallest: spheres, rods and plates."""
    a, b, c = 10.0 ** rng.uniform(-2.0 if rng.random() < 0.3 else -0.5, 0.0, 3)
    moments = np.array([b + c, a + c, a + b])
    moments /= moments.max()
    inertia = np.diag(moments) if rng.random() < 0.5 else _turned(rng, moments)
    return inertia, float(moments.min())


def _weight(rng: np.random.Generator, size: float) -> Vector:
    """Return a weight: a number times I, or one over two decades in a frame of its own."""
    if rng.random() < 0.5:
        return size * np.eye(3)
    return _turned(rng, size * 10.0 ** rng.uniform(-1.0, 1.0, 3))


def _actuators(rng: np.random.Generator) -> tuple[Vector, bool]:
    """Return B (3, m), and whether its controls need one weight: all but three."""
    if rng.random() < 0.85:
        return np.eye(3), False
    m = int(rng.integers(2, 5))
    return np.stack([_direction(rng) for _ in range(m)], axis=1), m != 3


def _state(rng: np.random.Generator, inertia: Vector) -> tuple[Vector, Vector]:
    """Return the attitude off the reference, and a momentum that one step can hold."""
    kind = rng.random()
    at_rest = rng.random() < 0.4
    nonstandard = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    direction = _direction(rng)
    largest = 2.0 / np.linalg.norm(lie.hat(direction) @ np.linalg.inv(nonstandard), 2)
    momentum = float(not at_rest) * rng.uniform(0.0, 0.5) * largest * direction
    if kind < 0.55:
        return _rotation(rng), momentum
    if kind < 0.70:
        return lie.exp(rng.uniform(0.1, 1.5) * _direction(rng)), momentum
    if kind < 0.83:
        small = _power(rng, -5.0, -1.0)
        return lie.exp(small * _direction(rng)), small * momentum
    if kind < 0.98:
        return lie.exp((math.pi - _power(rng, -6.0, -1.0)) * _direction(rng)), momentum
    return np.eye(3), np.zeros(3)


def _zone(rng: np.random.Generator) -> tuple[Vector, Vector, float, float, float]:
    inside = rng.random() < 0.3
    half_angle = float(rng.uniform(0.3, 2.0) if inside else rng.uniform(0.1, 0.7))
    axes = (_direction(rng), _direction(rng))
    return *axes, half_angle, -1.0 if inside else 1.0, _power(rng, -1.0, 3.0)


def _units(
    rng: np.random.Generator, reach: float, seed: int
) -> tuple[tuple[float, float, float], tuple[float, float, float] | None]:
    """Return two sets of units; of the odd seeds the second are powers of two times the first."""
    mass, torque = _power(rng, -6.0, 8.0), _power(rng, -6.0, 3.0)
    units = (mass, math.sqrt(reach * mass / torque), _power(rng, -9.0, 9.0))
    other = (_power(rng, -6.0, 8.0), _power(rng, -3.0, 4.0), _power(rng, -12.0, 12.0))
    exact = [2.0 ** int(rng.integers(-10, 11)) for _ in range(3)]
    mass, time, cost = units
    if seed % 2 == 0:
        return units, None
    if seed % 4 == 1:
        return units, other
    return units, (mass * exact[0], time * exact[1], cost * exact[2])


def in_units(
    problem: Drawn, units: tuple[float, float, float]
) -> tuple[AttitudeOcp, tuple[Vector, Vector, Vector]]:
    """Return the problem in units of mass (times length squared), time and cost, and its state."""
    mass, time, cost = units
    # Products: pow() rounds otherwise where a number is a power of two larger.
    momentum, torque = mass / time, mass / (time * time)
    torque_2, momentum_2 = torque * torque, momentum * momentum
    weights = Weights(
        problem.stage_attitude * (cost / time),
        problem.stage_momentum * (cost / time / momentum_2),
        problem.stage_torque * (cost / time / torque_2),
        problem.terminal_attitude * cost,
        problem.terminal_momentum * (cost / momentum_2),
    )
    zones = tuple(
        PointingZone(
            "exclusion" if sign > 0.0 else "inclusion", body, inertial, half_angle,
            penalty * (cost / time),
        )
        for body, inertial, half_angle, sign, penalty in problem.zones
    )  # fmt: skip
    plain = problem.actuators.shape == (3, 3) and bool((problem.actuators == np.eye(3)).all())
    ocp = AttitudeOcp(
        problem.inertia * mass, time, problem.horizon, weights, problem.limit * torque,
        problem.penalty * (cost / time / (torque_2 * torque_2)), zones,
        None if plain else problem.actuators,
    )  # fmt: skip
    return ocp, (problem.attitude, problem.momentum * momentum, problem.reference)
