"""A valid scenario with a governor, and changes that make it invalid."""

from __future__ import annotations

from bad_controllers import Bad

GOOD = """\
plant:
  ros__parameters:
    inertia: [10.0, 0.0, 0.0, 0.0, 8.0, 0.0, 0.0, 0.0, 8.0]
    time_step: 0.1
    duration: 60.0
    initial_rotation_vector: [0.5, 0.0, 0.0]
    initial_momentum: [0.0, 0.0, 0.0]
nmpc_controller:
  ros__parameters:
    method: feedback
    max_torque: 0.0
    feedback_attitude_gain: [0.1, 0.0, 0.0, 0.0, 0.2, 0.0, 0.0, 0.0, 0.3]
    feedback_momentum_gain: [0.2, 0.0, 0.0, 0.0, 0.2, 0.0, 0.0, 0.0, 0.2]
    zone_names: [earth]
    zones:
      earth: {kind: inclusion, body_axis: [0.0, 0.0, 1.0], inertial_axis: [0.0, 0.0, 1.0],
              half_angle_deg: 60.0}
reference_governor:
  ros__parameters:
    governor: attitude
    target_rotation_vector: [0.0, 0.0, 0.0]
    max_torque: 0.02
    max_momentum: 0.5
    steady_margin_deg: 0.1
"""

_MOMENTUM = "initial_momentum: [0.0, 0.0, 0.0]"
_TARGET = "target_rotation_vector: [0.0, 0.0, 0.0]"
_EARTH = "half_angle_deg: 60.0}"
_HALF_ANGLE = "nmpc_controller.zones.earth.half_angle_deg"


def _exclusions(**zones: tuple[list[float], float]) -> tuple[str, str]:
    """Return the replacement that adds exclusion zones of the body z axis."""
    new = f"zone_names: [earth, {', '.join(zones)}]\n    zones:\n"
    for name, (inertial_axis, half_angle_deg) in zones.items():
        new += f"      {name}: {{kind: exclusion, body_axis: [0.0, 0.0, 1.0], "
        new += f"inertial_axis: {inertial_axis}, half_angle_deg: {half_angle_deg}}}\n"
    return "zone_names: [earth]\n    zones:\n", new


CASES = {
    "target in a zone": Bad(
        _TARGET, "target_rotation_vector: [0.0, 1.2, 0.0]",
        "reference_governor.target_rotation_vector", "at most 60 deg (inclusion zone 'earth')",
        "choose another target, or widen the cone",
    ),
    "target within the steady margin": Bad(
        _TARGET, "target_rotation_vector: [0.0, 1.0468, 0.0]",
        "reference_governor.target_rotation_vector",
        "at least 0.1 deg at rest (reference_governor.steady_margin_deg)",
        "choose another target, or lower steady_margin_deg",
    ),
    "default target within the steady margin": Bad(
        GOOD[GOOD.index("inertial_axis") : GOOD.index("    max_torque: 0.02")],
        "inertial_axis: [0.8655770, 0.0, 0.5007684],\n              half_angle_deg: 60.0}\n"
        "reference_governor:\n  ros__parameters:\n    governor: attitude\n",
        _HALF_ANGLE, "at least 0.1 deg at rest", "choose another target",
    ),
    "start in a zone": Bad(
        "initial_rotation_vector: [0.5, 0.0, 0.0]", "initial_rotation_vector: [1.2, 0.0, 0.0]",
        "plant.initial_rotation_vector", "at most 60 deg (inclusion zone 'earth')",
        "choose another start, or widen the cone",
    ),
    "start within the steady margin": Bad(
        "initial_rotation_vector: [0.5, 0.0, 0.0]", "initial_rotation_vector: [1.0468, 0.0, 0.0]",
        "plant.initial_rotation_vector", "at least 0.1 deg at rest",
        "give initial_reference_rotation_vector",
    ),
    "initial reference in a zone": Bad(
        _TARGET, f"{_TARGET}\n    initial_reference_rotation_vector: [1.2, 0.0, 0.0]",
        "reference_governor.initial_reference_rotation_vector", "at least 0.1 deg at rest",
        "choose another initial reference",
    ),
    "start with too much momentum": Bad(
        _MOMENTUM, "initial_momentum: [0.0, 0.0, 0.6]", "plant.initial_momentum",
        "at most 0.5 N m s (reference_governor.max_momentum)",
        "start slower, or raise max_momentum",
    ),
    "start that moves too fast for the torque": Bad(
        _MOMENTUM, "initial_momentum: [0.0, 0.0, 0.2]", "reference_governor.max_torque",
        "a limit that the start keeps", "start slower",
    ),
    "start too far from its reference": Bad(
        _TARGET, f"{_TARGET}\n    initial_reference_rotation_vector: [0.0, 0.0, 0.0]",
        "reference_governor.max_torque", "a limit that the start keeps",
        "give initial_reference_rotation_vector near the start",
    ),
    "start that drifts out of a zone": Bad(
        f"initial_rotation_vector: [0.5, 0.0, 0.0]\n    {_MOMENTUM}",
        "initial_rotation_vector: [1.04, 0.0, 0.0]\n    initial_momentum: [0.05, 0.0, 0.0]",
        "reference_governor (start)", "a start from which every constraint is kept", "start slower",
    ),
    "inclusion cone within the steady margin": Bad(
        _EARTH, "half_angle_deg: 0.09}", _HALF_ANGLE, "steady_margin_deg to every zone",
        "widen the cone, or lower steady_margin_deg",
    ),
    "exclusion cone that leaves less than the steady margin": Bad(
        f"kind: inclusion, body_axis: [0.0, 0.0, 1.0], inertial_axis: [0.0, 0.0, 1.0],\n"
        f"              {_EARTH}",
        "kind: exclusion, body_axis: [0.0, 0.0, 1.0], inertial_axis: [0.0, 0.0, -1.0],\n"
        "              half_angle_deg: 179.95}",
        _HALF_ANGLE, "steady_margin_deg to every zone",
        "shrink the cone, or lower steady_margin_deg",
    ),
    "zones that leave nothing": Bad(
        *_exclusions(star=([0.0, 0.0, 1.0], 61.0)), "nmpc_controller.zones.star.half_angle_deg",
        "at least one attitude that both zones allow", "widen an inclusion cone",
    ),
    "three zones that leave nothing, though each pair does": Bad(
        *_exclusions(star=([0.766, 0.0, 0.643], 75.0), moon=([-0.766, 0.0, 0.643], 75.0)),
        "reference_governor.target_rotation_vector", "at least 75 deg (exclusion zone 'star')",
        "choose another target, or shrink the cone",
    ),
    "zones that leave less than the steady margin": Bad(
        *_exclusions(star=([0.0, 0.0, 1.0], 59.85)), "nmpc_controller.zones.star.half_angle_deg",
        "an attitude that keeps reference_governor.steady_margin_deg to every zone",
        "shrink the cone, or lower steady_margin_deg",
    ),
    "duration too short for the torque": Bad(
        "duration: 60.0", "duration: 28.0", "plant.duration", "at least 28.28 s",
        "lengthen it, or raise reference_governor.max_torque",
    ),
    "way round nearer than a reference may be": Bad(
        _TARGET, f"{_TARGET}\n    route_clearance_deg: 0.05",
        "reference_governor.route_clearance_deg",
        "at least 0.1 deg (reference_governor.steady_margin_deg)", "raise it",
    ),
    "steady margin beyond that of the way round": Bad(
        "steady_margin_deg: 0.1", "steady_margin_deg: 2.5",
        "reference_governor.steady_margin_deg",
        "at most 2 deg (reference_governor.route_clearance_deg)", "raise route_clearance_deg",
    ),
    "gain that is not positive definite": Bad(
        "feedback_attitude_gain: [0.1, 0.0, 0.0, 0.0, 0.2,",
        "feedback_attitude_gain: [0.1, 0.0, 0.0, 0.0, -0.2,",
        "nmpc_controller.feedback_attitude_gain", "a symmetric positive definite matrix",
        "make every eigenvalue positive",
    ),
    "level of an unstable equilibrium": Bad(
        _TARGET, f"{_TARGET}\n    lyapunov_level: 0.6", "reference_governor.lyapunov_level",
        "less than 0.6 J, the level of the lowest unstable equilibrium", "lower it",
    ),
}  # fmt: skip
