"""Navigation: what the controllers are told of the relative motion, with white noise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from spacecraft_gnc import lie
from spacecraft_gnc.arguments import as_limit
from spacecraft_gnc.plant.random_numbers import standard_normals
from spacecraft_gnc.types import Matrix3, Vector3, read_only
from spacecraft_gnc.vehicles.docking.state import Navigation

_STREAMS: Final = {
    part: f"navigation.{part}" for part in ("position", "velocity", "attitude", "rate")
}


@dataclass(frozen=True, slots=True, kw_only=True)
class NavigationNoise:
    """White noise of each quantity, from streams of their own: ``navigation.position`` and so on.

    Attributes
    ----------
    position, velocity : float
        Standard deviation of each component of the port offset [m] and its rate [m/s].
    attitude : float
        Of each component of the rotation vector by which the measured attitude is off [rad].
    rate : float
        Of each component of the relative angular velocity [rad/s].
    seed, run : int
        Of `plant.random_numbers`.
    """

    position: float = 0.0
    velocity: float = 0.0
    attitude: float = 0.0
    rate: float = 0.0
    seed: int = 0
    run: int = 0

    def __post_init__(self) -> None:
        for part in _STREAMS:
            object.__setattr__(self, part, as_limit(f"{part}_noise", getattr(self, part)))

    def measure(self, step: int, truth: Navigation) -> Navigation:
        """Return what is measured at a control step; what has no noise is the truth itself."""
        turn = self._noise("attitude", step)
        return Navigation(
            self._added("position", step, truth.port_offset),
            self._added("velocity", step, truth.port_velocity),
            truth.attitude if turn is None else _turned(turn, truth.attitude),
            self._added("rate", step, truth.angular_velocity),
        )

    def _noise(self, part: str, step: int) -> Vector3 | None:
        deviation: float = getattr(self, part)
        if not deviation:
            return None
        return deviation * standard_normals(self.seed, self.run, _STREAMS[part], step, 3)

    def _added(self, part: str, step: int, value: Vector3) -> Vector3:
        noise = self._noise(part, step)
        return value if noise is None else read_only(value + noise)


def _turned(rotation_vector: Vector3, attitude: Matrix3) -> Matrix3:
    """Return exp(hat(.)) R, the error in the chief frame."""
    return read_only(lie.exp(rotation_vector) @ attitude)
