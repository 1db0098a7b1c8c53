"""Invalid controller sections and infeasible flights, as changes of the valid scenario.

`bad_scenarios` has the scenario, and all cases together.
"""

from __future__ import annotations

from typing import NamedTuple


class Bad(NamedTuple):
    old: str
    new: str
    key: str
    required: str
    remedy: str


def beside_star(
    kind: str,
    inertial_axis: list[float],
    half_angle_deg: float,
    *,
    body_axis: list[float] | None = None,
    blamed: str = "moon",
) -> tuple[str, str, str]:
    """Return the replacement that adds the zone ``moon`` to ``star``, and the key at fault."""
    zone = (
        f"{{kind: {kind}, body_axis: {body_axis or [1.0, 0.0, 0.0]}, "
        f"inertial_axis: {inertial_axis}, half_angle_deg: {half_angle_deg}}}"
    )
    new = f"zone_names: [star, moon]\n    zones:\n      moon: {zone}\n"
    key = f"nmpc_controller.zones.{blamed}.half_angle_deg"
    return "zone_names: [star]\n    zones:\n", new, key


CONTROLLER_CASES = {
    "weight on the commands of four actuators": Bad(
        "weights: {stage_torque: 1.0}",
        "actuators: [1.0, 0.0, 0.0, 0.5, 0.0, 1.0, 0.0, 0.5, 0.0, 0.0, 1.0, 0.5]\n"
        "    weights: {stage_torque: [1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 1.0]}",
        "nmpc_controller.weights.stage_torque",
        "one number, as the actuator matrix has 4 columns",
        "write for example 1.0",
    ),
    **{
        f"weight {name} {fault}": Bad(
            "stage_torque: 1.0", f"{name}: {matrix}", f"nmpc_controller.weights.{name}", need,
            remedy,
        )
        for name in (
            "stage_momentum", "stage_torque", "terminal_attitude", "terminal_momentum",
        )
        for fault, matrix, need, remedy in (
            ("indefinite", [1.0, 2.0, 0.0, 2.0, 1.0, 0.0, 0.0, 0.0, 1.0], "definite", "eigenval"),
            ("skew", [1.0, 0.0, 0.1, 0.0, 1.0, 0.0, -0.1, 0.0, 1.0], "a symmetric", "mirror"),
            ("negative", -1.0, "> 0" if name == "stage_torque" else "0 to 1e+60", "raise it"),
            ("enormous", 1e61, "1e+60", "lower it"),
            ("huge", [1e61, 0.0, 0.0, 0.0, 1e61, 0.0, 0.0, 0.0, 1e61], "1e+60", "lower it"),
        )
    },
    "actuators no whole columns": Bad(
        "horizon: 5", "actuators: [1.0, 0.0, 0.0, 1.0]", "nmpc_controller.actuators",
        "3 m numbers (3 x m, row-major)", "write 3 rows of equal length",
    ),
    "actuators of one axis": Bad(
        "horizon: 5", "actuators: [1.0, 2.0, 1.0, 2.0, 0.0, 0.0]", "nmpc_controller.actuators",
        "rank 2 or 3", "add an actuator of another axis",
    ),
    "one actuator": Bad(
        "horizon: 5", "actuators: [1.0, 0.0, 0.0]", "nmpc_controller.actuators", "about two axes",
        "add an actuator",
    ),
    "actuator without torque": Bad(
        "horizon: 5", "actuators: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0]",
        "nmpc_controller.actuators", "a torque from every actuator", "remove the column",
    ),
    "actuators of no torque at all": Bad(
        "horizon: 5", "actuators: [0.0, 0.0, 0.0]", "nmpc_controller.actuators",
        "a torque from every actuator", "remove the column",
    ),
    "actuators not finite": Bad(
        "horizon: 5", "actuators: [1.0, .nan, 0.0]", "nmpc_controller.actuators", "finite",
        "replace NaN",
    ),
    "formulation unknown": Bad(
        "horizon: 5", "formulation: backwards_sweep", "nmpc_controller.formulation",
        "one of auto, backward_sweep, single_shooting", "did you mean 'backward_sweep'?",
    ),
    **{
        f"method {word}": Bad(
            "horizon: 5", f"method: {word}", "nmpc_controller.method", "a string", f'write "{word}"'
        )
        for word in ("no", "off", "On", "Y", "1e3", "010", "0x1p3", "5")
    },
    "horizon too long to examine": Bad(
        "horizon: 5", "horizon: 1001\n    method: terminal_set", "nmpc_controller.horizon",
        "at most 1000 steps of method: terminal_set", "shorten it",
    ),
    "step rule unknown": Bad(
        "horizon: 5", "step_rule: backtrack", "nmpc_controller.step_rule",
        "one of backtracking, full, damped, chord", "did you mean 'backtracking'?",
    ),
    "continuation unknown": Bad(
        "horizon: 5", "continuation: homotopy", "nmpc_controller.continuation",
        "one of none, auto, penalty, state, horizon, effort", "use one of none, auto, penalty",
    ),
    "damping above 1": Bad(
        "horizon: 5", "damping: 1.5", "nmpc_controller.damping", "> 0 and <= 1", "lower it"
    ),
    "damping 0": Bad(
        "horizon: 5", "damping: 0.0", "nmpc_controller.damping", "> 0 and <= 1", "raise it"
    ),
    "standstill error negative": Bad(
        "horizon: 5", "standstill_error_deg: -0.1", "nmpc_controller.standstill_error_deg", ">= 0",
        "raise it",
    ),
    "nominal start of two numbers": Bad(
        "horizon: 5", "nominal_rotation_vector: [0.0, 0.5]",
        "nmpc_controller.nominal_rotation_vector", "3 numbers [rad]", "exactly 3",
    ),
    "nominal momentum empty": Bad(
        "horizon: 5", "nominal_momentum: []", "nmpc_controller.nominal_momentum",
        "3 numbers [N m s]", "exactly 3",
    ),
    "exact solves in negative numbers": Bad(
        "horizon: 5", "exact_every: -1", "nmpc_controller.exact_every", ">= 0", "raise it"
    ),
    "tolerance of the neighboring solution 0": Bad(
        "horizon: 5", "ne_tolerance: 0.0", "nmpc_controller.ne_tolerance", "> 0", "raise it"
    ),
    "age of the neighboring solution 0": Bad(
        "horizon: 5", "ne_max_age: 0", "nmpc_controller.ne_max_age", ">= 1", "raise it"
    ),
    "parameter of another method": Bad(
        "horizon: 5", "ne_tolerance: 0.01", "nmpc_controller.ne_tolerance",
        "a method that reads it (neighboring_extremal), not shooting", "remove it",
    ),
    "nominal run of another method": Bad(
        "horizon: 5", "nominal_rotation_vector: [0.0, 0.0, 0.5]",
        "nmpc_controller.nominal_rotation_vector", "a method that reads it", "remove it",
    ),
    "governed start inside an exclusion zone": Bad(
        "launcher:",
        "reference_governor:\n  ros__parameters:\n    governor: attitude\n"
        "/**/plant:\n  ros__parameters:\n    initial_rotation_vector: [0.0, -1.5, 0.0]\nlauncher:",
        "plant.initial_rotation_vector", "at least 5 deg (exclusion zone 'star')",
        "choose another start, or shrink the cone",
    ),
    "target inside an exclusion zone": Bad(
        "launcher:",
        "reference_governor:\n  ros__parameters:\n"
        "    target_rotation_vector: [0.0, -1.6, 0.0]\nlauncher:",
        "reference_governor.target_rotation_vector",
        "at least 5 deg (exclusion zone 'star')",
        "choose another target, or shrink the cone",
    ),
    "default target outside an inclusion zone": Bad(
        "kind: exclusion", "kind: inclusion", "nmpc_controller.zones.star.half_angle_deg",
        "at most 5 deg (inclusion zone 'star')", "choose another target, or widen the cone",
    ),
    "inclusion inside exclusion": Bad(
        *beside_star("inclusion", [0.0, 0.0, 1.0], 3.0), "one attitude that both zones allow",
        "shrink an exclusion cone, widen an inclusion cone, or remove one of the two",
    ),
    "exclusions that cover the sphere": Bad(
        *beside_star("exclusion", [0.0, 0.0, -1.0], 176.0), "one attitude that both zones allow",
        "shrink an exclusion cone, or remove one of the two",
    ),
    "exclusion inside exclusion": Bad(
        *beside_star("exclusion", [0.0, 0.01, 1.0], 3.0), "a zone that forbids what 'star' does",
        "remove 'moon', or mend its axes",
    ),
    "exclusion inside exclusion, of the opposite axis": Bad(
        *beside_star("exclusion", [0.0, 0.0, -1.0], 5.0, body_axis=[-2.0, 0.0, 0.0]),
        "a zone that forbids what 'star' does not forbid already", "remove 'moon'",
    ),
    "exclusion around exclusion": Bad(
        *beside_star("exclusion", [0.0, 0.01, 1.0], 30.0, blamed="star"),
        "a zone that forbids what 'moon' does not forbid already", "remove 'star'",
    ),
    "zones of two axes at odds": Bad(
        *beside_star("inclusion", [0.0, 0.0, 1.0], 1.0, body_axis=[1.0, 0.01, 0.0]),
        "one attitude that both zones allow", "widen an inclusion cone",
    ),
    "out of reach": Bad(
        "max_torque: 1.0", "max_torque: 0.01", "plant.duration",
        "at least 10 s, the shortest time from 0 deg and |Pi| 0.1 N m s to rest", "lengthen it",
    ),
    "out of reach of weak actuators": Bad(
        "horizon: 5", "actuators: [0.01, 0.0, 0.0, 0.0, 0.01, 0.0, 0.0, 0.0, 0.005]",
        "plant.duration", "with 0.01 N m at the most", "raise nmpc_controller.max_torque",
    ),
}  # fmt: skip
