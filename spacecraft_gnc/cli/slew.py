"""``gnc slew``: command a new attitude while a graph flies."""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np
import typer

from spacecraft_gnc import lie
from spacecraft_gnc.cli._common import JsonOption, QuietOption, RunFailed, print_json
from spacecraft_gnc.cli._domain import (
    AgentOption,
    DomainOption,
    agents_on,
    choose_domain,
    require_namespace,
)
from spacecraft_gnc.errors import GncError, ParameterError
from spacecraft_gnc.extras import require_ros
from spacecraft_gnc.types import Array, unit_vector

AxisOption = Annotated[
    tuple[float, float, float] | None,
    typer.Option("--axis", metavar="X Y Z", help="Axis of the rotation from inertial to target."),
]
AngleOption = Annotated[
    float | None, typer.Option("--angle-deg", metavar="A", help="Angle about that axis [deg].")
]
QuaternionOption = Annotated[
    tuple[float, float, float, float] | None,
    typer.Option("--quaternion", metavar="X Y Z W", help="Target, body to inertial."),
]
ToleranceOption = Annotated[
    float,
    typer.Option("--tolerance-deg", metavar="A", min=0.0, help="0: the governor's default [deg]."),
]


class TargetRefused(GncError):
    """The governor does not take the target; the last one stays."""


def slew(
    axis: AxisOption = None,
    angle_deg: AngleOption = None,
    quaternion: QuaternionOption = None,
    tolerance_deg: ToleranceOption = 0.0,
    namespace: AgentOption = "",
    domain_id: DomainOption = None,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Slew to an attitude and wait until it is reached; Ctrl-C cancels."""
    target = _target(axis, angle_deg, quaternion)
    require_ros()
    from spacecraft_gnc.ros.graph import GraphView
    from spacecraft_gnc.ros.slew_client import slew as fly

    def show(step: int, error: float, alpha: float) -> None:
        if not quiet and not as_json:
            text = f"  step {step}: {math.degrees(error):.4g} deg to go, alpha {alpha:.3g}"
            print(text, flush=True)

    chosen = choose_domain(domain_id)
    require_namespace(namespace, chosen)
    _require_one(namespace, chosen)
    with GraphView(chosen) as view:
        result = fly(view, target, math.radians(tolerance_deg), show, namespace)
    error_deg = math.degrees(result.final_error)
    if as_json:
        values = {"reached": result.reached, "final_error_deg": error_deg, "step": result.step}
        print_json(values | {"refused": result.refused, "message": result.message})
    elif result.reached and not quiet:
        print(f"{result.message} at step {result.step}, {error_deg:.4g} deg off")
    if result.refused:
        raise TargetRefused(result.message)
    if not result.reached:
        raise RunFailed(f"slew: not reached ({result.message})")


def _require_one(namespace: str, domain_id: int) -> None:
    """Refuse to command a spacecraft that was not named, where there are several."""
    agents = agents_on(domain_id)
    if not namespace and len(agents) > 1:
        listed = ", ".join(f"/{agent}" for agent in agents)
        raise ParameterError(
            f"--namespace: received nothing while several spacecraft fly ({listed}); required the "
            f"one to slew; add --namespace {agents[0]}"
        )


def _target(
    axis: tuple[float, float, float] | None,
    angle_deg: float | None,
    quaternion: tuple[float, float, float, float] | None,
) -> Array:
    """Return the target quaternion (4,) x, y, z, w from one of the two ways to give it."""
    if quaternion is not None and axis is None and angle_deg is None:
        norm = float(np.linalg.norm(quaternion))
        if not (math.isfinite(norm) and norm > 0.0):
            raise ParameterError(
                f"--quaternion: received {list(quaternion)}; required four finite numbers, not all "
                "zero; correct them"
            )
        return np.array(quaternion) / norm
    if quaternion is None and axis is not None and angle_deg is not None:
        direction = unit_vector("--axis", list(axis))
        if not math.isfinite(angle_deg):
            raise ParameterError(f"--angle-deg: received {angle_deg}; required a finite angle")
        return lie.to_quaternion_xyzw(lie.exp(math.radians(angle_deg) * direction))
    raise ParameterError(
        "slew: received no target, or two; required --axis X Y Z with --angle-deg A, or "
        "--quaternion X Y Z W; give one of them"
    )
