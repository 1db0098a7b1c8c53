"""Distributions on the sphere and on SO(3): direction and rotation."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Final

import numpy as np
import yaml

from spacecraft_gnc import lie
from spacecraft_gnc.campaign.distributions.discrete import Choice
from spacecraft_gnc.campaign.distributions.distribution import Distribution, Target
from spacecraft_gnc.campaign.distributions.options import Options
from spacecraft_gnc.parameters.parameter import Kind, MatrixRule, ParameterSpec, Value
from spacecraft_gnc.types import Array, Vector3

_ANGLE: Final = ParameterSpec(
    kind=Kind.DOUBLE, default=180.0, description="", unit="deg", above=0.0, maximum=180.0
)
_AXIS: Final = ParameterSpec(
    kind=Kind.DOUBLE_ARRAY, default=[0.0, 0.0, 1.0], description="", shape=(3,), nonzero=True
)
_LENGTH: Final = ParameterSpec(kind=Kind.DOUBLE, default=0.0, description="", minimum=0.0)
_FORMS: Final = {3: "a rotation vector", 4: "a quaternion x y z w", 9: "a rotation matrix"}
_ROUNDING: Final = 1e-15  # relative
_SERIES_BELOW: Final = 0.1  # [rad]; three terms leave less than 1e-16 of the first there


@dataclass(frozen=True, slots=True)
class Cone:
    """Directions uniform over the part of the sphere up to an angle from an axis."""

    axis: Vector3
    """(3,) unit vector."""
    first: Vector3
    second: Vector3
    """(3,) unit vectors that complete it to a right-handed frame."""
    angle: float
    """[rad]; pi: the whole sphere."""
    lowest: Vector3
    highest: Vector3
    """(3,) ends of each component."""

    @classmethod
    def about(cls, axis: Array, angle: float) -> Cone:
        """Return the cone of an axis (3,) of any length."""
        unit = axis / np.linalg.norm(axis)
        beside = np.eye(3)[int(np.argmin(np.abs(unit)))]
        first = np.cross(unit, beside)
        first /= np.linalg.norm(first)
        off = np.arccos(np.clip(unit, -1.0, 1.0))
        lowest = np.cos(np.minimum(math.pi, off + angle))
        highest = np.cos(np.maximum(0.0, off - angle))
        return cls(unit, first, np.cross(unit, first), angle, lowest, highest)

    def direction(self, u: float, v: float) -> Vector3:
        """Return the unit vector (3,) at two numbers in [0, 1]: height, angle about the axis."""
        fall = u * 2.0 * math.sin(0.5 * self.angle) ** 2  # 1 - cosine: keeps a narrow cone narrow
        sine, turn = math.sqrt(fall * (2.0 - fall)), 2.0 * math.pi * v
        sideways = math.cos(turn) * self.first + math.sin(turn) * self.second
        direction: Vector3 = (1.0 - fall) * self.axis + sine * sideways
        return np.clip(direction, self.lowest, self.highest)  # rounding aside, it is there already


@dataclass(frozen=True, slots=True)
class Direction:
    """Vectors of random direction and of a length that is a distribution itself."""

    cone: Cone
    length: Distribution

    @property
    def dimensions(self) -> int:
        """Two, and those of the length."""
        return 2 + self.length.dimensions

    @property
    def size(self) -> None:
        """A continuum."""
        return None

    def value(self, point: Array) -> Value:
        """Return the vector at a point: direction first, then length."""
        direction = self.cone.direction(float(point[0]), float(point[1]))
        vector: list[float] = (float(self.length.value(point[2:])) * direction).tolist()  # type: ignore[arg-type]
        return vector

    def extremes(self) -> Iterable[Value]:
        """Return vectors that reach the ends of each component, and the shortest one."""
        lengths = _lengths(self.length)
        for bound in (self.cone.lowest, self.cone.highest):
            for i in range(3):
                yield (max(lengths) * bound[i] * np.eye(3)[i]).tolist()
        yield (min(lengths) * self.cone.axis).tolist()


@dataclass(frozen=True, slots=True)
class Turn:
    """Rotation vectors of rotations uniform over SO(3), up to an angle."""

    angle: float
    """[rad], at most pi."""

    def vector(self, point: Array) -> Vector3:
        """Return the rotation vector (3,) at a point (3,): angle, then axis.

        The angle t has the density (1 - cos t) / (A - sin A) up to A, the invariant measure of
        SO(3); the axis is uniform and independent of it.
        """
        share = float(point[0]) * angle_less_sine(self.angle)
        axis = _SPHERE.direction(float(point[1]), float(point[2]))
        vector: Vector3 = min(_angle_of(share), self.angle) * axis
        return vector


_SPHERE: Final = Cone.about(np.array([0.0, 0.0, 1.0]), math.pi)


@dataclass(frozen=True, slots=True)
class Rotation:
    """Rotations in the form that a parameter has."""

    turn: Turn
    count: int
    """Numbers of the form: 3, 4 or 9."""

    @property
    def dimensions(self) -> int:
        """Three."""
        return 3

    @property
    def size(self) -> None:
        """A continuum."""
        return None

    def value(self, point: Array) -> Value:
        """Return the rotation at a point."""
        return self._formed(self.turn.vector(point))

    def extremes(self) -> Iterable[Value]:
        """Return the rotations that reach the ends of each number, in every form."""
        yield self._formed(np.zeros(3))
        for angle in (self.turn.angle, min(self.turn.angle, 0.5 * math.pi)):  # of cosine, of sine
            for axis in (*np.eye(3), *-np.eye(3)):
                yield self._formed(angle * axis)

    def _formed(self, vector: Vector3) -> list[float]:
        numbers: list[float]
        if self.count == 3:
            numbers = vector.tolist()
        elif self.count == 9:
            numbers = lie.exp(vector).ravel().tolist()
        else:
            numbers = lie.to_quaternion_xyzw(lie.exp(vector)).tolist()
        return numbers


def angle_less_sine(angle: float) -> float:
    """Return t - sin t without cancellation."""
    if angle >= _SERIES_BELOW:
        return angle - math.sin(angle)
    square = angle * angle
    terms = 1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0))
    return angle * square / 6.0 * terms


def _angle_of(share: float) -> float:
    """Return the t in [0, pi] at which t - sin t is ``share``.

    Newton's iteration from above: t - sin t is convex and at least t^3 / pi^2, so it only descends.
    """
    t = math.pow(math.pi**2 * share, 1.0 / 3.0)
    step = t
    while step > _ROUNDING * t:
        step = (angle_less_sine(t) - share) / (2.0 * math.sin(0.5 * t) ** 2)
        t -= step
    return t


def read_direction(
    options: Options, target: Target, read: Callable[..., Distribution | None]
) -> Direction:
    """Return directions times ``length``, ``around`` an axis up to ``max_angle_deg`` if given.

    ``read`` reads the distribution of a length.
    """
    axis, angle = options.value("around", _AXIS), options.value("max_angle_deg", _ANGLE)
    if options.has("max_angle_deg") and not options.has("around"):
        options.complain("around", "nothing", "the axis of the cone of max_angle_deg", "add it")
    length = _length(options, target, read)
    if not options.is_valid or length is None:
        return Direction(_SPHERE, Choice(()))
    return Direction(Cone.about(np.array(axis), math.radians(angle)), length)


def _length(
    options: Options, target: Target, read: Callable[..., Distribution | None]
) -> Distribution | None:
    spec = target.spec
    node = options.node("length", "a number >= 0, or a distribution")
    if spec.kind is not Kind.DOUBLE_ARRAY or _count(target) != 3:
        what, need = f"a direction for {target.name}", "a parameter that takes 3 numbers"
        options.complain("distribution", what, need, "choose another distribution")
    elif isinstance(node, yaml.MappingNode):
        inner = Target(f"{target.name}.length", _LENGTH, [])
        return read(node, inner, options.file, options.problems)
    elif node is not None:
        constant = options.converted("length", node, _LENGTH)
        return None if constant is None else Choice((constant,))
    return None


def read_rotation(options: Options, target: Target) -> Rotation:
    """Return rotations up to ``max_angle_deg``, in the form that the parameter has."""
    angle = math.radians(options.value("max_angle_deg", _ANGLE))
    return Rotation(Turn(min(angle, math.pi)), _numbers_of_form(options, target))


def _numbers_of_form(options: Options, target: Target) -> int:
    spec = target.spec
    count = _count(target)
    is_one = spec.kind is Kind.DOUBLE_ARRAY and spec.matrix is MatrixRule.NONE and count in _FORMS
    if count == 3 and not target.is_plugin:  # three angles or another vector are no rotation
        is_one = is_one and target.name.endswith("rotation_vector")
    if not is_one:
        need = f"a parameter that takes {' or '.join(_FORMS.values())}"
        remedy = "vary such a one, or choose another distribution"
        options.complain("distribution", f"a rotation for {target.name}", need, remedy)
    return count


def _count(target: Target) -> int:
    """Return how many numbers a list has that the parameter takes, 0 where that is not known."""
    known = len(target.nominal) if isinstance(target.nominal, list) else 0
    return target.spec.length if target.spec.length > 0 else known


def _lengths(length: Distribution) -> list[float]:
    if isinstance(length, Choice):
        return [float(value) for value in length.values]  # type: ignore[arg-type]
    return [float(value) for value in length.extremes()]  # type: ignore[arg-type]
