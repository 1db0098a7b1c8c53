"""Facts of a formation scenario, for ``gnc check``, without kernels."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from spacecraft_gnc.vehicles.formation import admissible, hill
from spacecraft_gnc.vehicles.formation.orbit import mean_motion, orbital_period, samples_of_orbit
from spacecraft_gnc.vehicles.formation.parameters.plant import PlantParameters
from spacecraft_gnc.vehicles.formation.scenario import Scenario
from spacecraft_gnc.vehicles.vehicle import Facts, Outlook

_TRUTHS = {
    "hill": "Hill's equations, as the laws assume",
    "two_body": "two-body motion, of which the laws do not know",
    "two_body_j2": "two-body motion with J2, of which the laws do not know",
}


def facts(scenario: Scenario, expected: Outlook) -> Facts:
    """Return what a scenario would fly."""
    del expected
    p, g = scenario.plant, scenario.governor
    samples, orbit = samples_of_orbit(p.altitude, scenario.period), orbital_period(p.altitude)
    positions = admissible.start(p, samples)[:, :3]
    natural = hill.natural_states(mean_motion(p.altitude), p.radial_semi_axis, samples)
    away = np.linalg.norm(positions - natural[np.array(g.phase) % samples, :3], axis=1)
    begun, apart = admissible.nearest(positions), admissible.desired(p, g.phase, samples)
    return Facts(
        body=f"{len(p.spacecraft)} spacecraft: {', '.join(p.spacecraft)}",
        start=(
            f"up to {away.max():.4g} m from their places, {begun.told(p.spacecraft)} "
            f"{begun.distance:.4g} m apart"
        ),
        controller=", ".join(_weights(scenario)),
        rows=(
            ("orbit", f"{p.altitude / 1e3:g} km high, {orbit:.7g} s, {samples} control steps"),
            ("formation", _formation(p, g.phase, apart)),
            ("limits", _limits(p)),
            ("motion", _motion(p)),
        ),
        governor=", ".join(_margins(scenario)),
        numbers={
            "spacecraft": list(p.spacecraft),
            "orbital_period": orbit,
            "orbit_samples": samples,
            "initial_position_error": float(away.max()),
            "initial_separation": begun.distance,
            "formation_separation": apart.distance,
            "max_delta_v_limit": p.max_delta_v,
            "min_separation_limit": p.min_separation,
            "max_communication_angle_deg_limit": p.max_communication_angle_deg,
        },
    )


def _formation(p: PlantParameters, phases: tuple[int, ...], apart: admissible.Nearest) -> str:
    a = p.radial_semi_axis / 1e3
    axes = f"ellipse of semi-axes {a:g} km radial, {2.0 * a:g} km along the track"
    places = ", ".join(map(str, phases))
    return f"{axes}, places {places}, {apart.distance / 1e3:.4g} km apart or more"


def _limits(p: PlantParameters) -> str:
    told = f"delta-v {p.max_delta_v:g} m/s, separation {p.min_separation:g} m"
    if p.max_communication_angle_deg < 180.0:
        told += f", communication angle {p.max_communication_angle_deg:g} deg"
    return told


def _motion(p: PlantParameters) -> str:
    told = _TRUTHS[p.motion]
    if not p.saturates:
        told += "; delta-v without its limit"
    if p.spacecraft_lost:
        told += f"; {p.spacecraft_lost} lost at {p.spacecraft_lost_at:g} s"
    return told


def _weights(scenario: Scenario) -> Iterator[str]:
    w = scenario.controller.weights
    yield f"Q = diag({w.position:g}, {w.velocity:g})"
    yield f"R = diag({w.delta_v:g}), three of each"


def _margins(scenario: Scenario) -> Iterator[str]:
    """Yield what the governor is asked for, in words."""
    g = scenario.governor
    if g.governor == "none":
        yield "every craft straight to its place"
        return
    yield f"{g.horizon} steps ahead"
    margins = (
        (g.delta_v_margin, "m/s"),
        (g.separation_margin, "m"),
        (g.communication_angle_margin_deg, "deg"),
    )
    kept = [f"{value:g} {unit}" for value, unit in margins if value]
    if kept:
        yield f"margins {', '.join(kept)}"
    if g.resolves_deadlocks:
        yield "resolves deadlocks"
