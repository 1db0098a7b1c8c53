"""Flight in formation with its scenario, as figures and report read it."""

from __future__ import annotations

import math
from itertools import combinations
from typing import TYPE_CHECKING, Final, Protocol

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.chart import held
from spacecraft_gnc.drawing.vehicle import FlownRun
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation.geometry import communication_angles_deg
from spacecraft_gnc.vehicles.formation.hill import natural_states, transition
from spacecraft_gnc.vehicles.formation.limits import all_separations
from spacecraft_gnc.vehicles.formation.metrics import healthy_pairs
from spacecraft_gnc.vehicles.formation.orbit import mean_motion
from spacecraft_gnc.vehicles.formation.summary import names

if TYPE_CHECKING:
    from spacecraft_gnc.vehicles.formation.flight import FormationFlight
    from spacecraft_gnc.vehicles.formation.scenario import Scenario
    from spacecraft_gnc.vehicles.formation.telemetry import Telemetry

KM: Final = 1e-3
"""Kilometers in a meter."""
ELLIPSE_COLOR: Final = "#8C97A5"
_ELLIPSE_POINTS: Final = 120
_FIRST_OF_PAIRS: Final = 3  # colors before it are those of the first craft


class Flown(FlownRun, Protocol):
    """One run."""

    @property
    def trajectory(self) -> FormationFlight:
        """What was flown."""

    @property
    def scenario(self) -> Scenario | None:
        """What flew; None: not known."""

    @property
    def telemetry(self) -> Telemetry:
        """What its bag tells."""


def craft_color(i: int) -> str:
    """Return the color of craft i."""
    return style.RUN_COLORS[i % len(style.RUN_COLORS)]


def pair_color(i: int) -> str:
    """Return the color of pair i, which few formations share with a craft."""
    return style.RUN_COLORS[(_FIRST_OF_PAIRS + i) % len(style.RUN_COLORS)]


def craft_names(run: Flown) -> tuple[str, ...]:
    """Return what the craft are called."""
    return names(run.trajectory, run.scenario)


def pair_names(run: Flown) -> list[str]:
    """Return what the pairs are called, in their order."""
    return ["-".join(pair) for pair in combinations(craft_names(run), 2)]


def limit_of(scenario: Scenario | None, name: str) -> float:
    """Return a limit of the plant; 0: not known."""
    return 0.0 if scenario is None else float(getattr(scenario.plant, name))


def angle_limit(scenario: Scenario | None) -> float:
    """Return the largest communication angle [deg]; 0: not known, or there is none."""
    most = limit_of(scenario, "max_communication_angle_deg")
    return most if most < 180.0 else 0.0


def ellipse(scenario: Scenario | None) -> Array:
    """Return the natural ellipse (k, 3), closed [m]; nothing where it is not known."""
    if scenario is None:
        return np.empty((0, 3))
    p = scenario.plant
    states = natural_states(mean_motion(p.altitude), p.radial_semi_axis, _ELLIPSE_POINTS)
    return np.vstack([states, states[:1]])[:, :3]


def positions(flight: FormationFlight) -> Array:
    """Return the positions (n + 1, m, 3) of the states, the last included [m]."""
    return np.concatenate([flight.position, flight.final_position[None]])


def places(run: Flown) -> Array:
    """Return where the craft are to be (n + 1, m, 3) [m].

    At the end they have moved on by themselves for a step (report, (15)); NaN without a scenario.
    """
    flight = run.trajectory
    last = np.full((1, flight.n_craft, 3), math.nan)
    if run.scenario is not None and flight.n_steps:
        over_step = transition(mean_motion(run.scenario.plant.altitude), flight.period)
        states = np.hstack([flight.reference_position[-1], flight.reference_velocity[-1]])
        last = (states @ over_step.T)[None, :, :3]
    return np.concatenate([flight.reference_position, last])


def widest(values: Array) -> Array:
    """Return the largest of each row (n, k) that is known; NaN: none is."""
    most = np.where(np.isnan(values), -math.inf, values).max(axis=-1, initial=-math.inf)
    return np.where(np.isfinite(most), most, math.nan)


def nearest(flight: FormationFlight) -> Array:
    """Return the least separation of a pair at each state (n + 1,) [m]; NaN: none is known."""
    return -widest(-all_separations(flight))


def errors(run: Flown) -> Array:
    """Return how far each craft is from where it is to be (n + 1, m) [m]."""
    return np.asarray(np.linalg.norm(positions(run.trajectory) - places(run), axis=-1))


def farthest(run: Flown) -> Array:
    """Return how far the farthest craft that answers is from its place (n + 1,) [m]."""
    return widest(np.where(held(run.trajectory.healthy), errors(run), math.nan))


def held_places(run: Flown) -> Array:
    """Return `places`; NaN of a craft from which nothing is expected any more."""
    gone = held(concluded_lost(run.trajectory))
    return np.where(gone[..., None], math.nan, places(run))


def angles_deg(run: Flown) -> Array:
    """Return the communication angle of each pair (n + 1, pairs) [deg]; NaN of a lost craft."""
    found = communication_angles_deg(positions(run.trajectory), places(run))
    return np.where(healthy_pairs(held(run.trajectory.healthy)), found, math.nan)


def pairs_kept(run: Flown) -> NDArray[np.bool_]:
    """Tell of each pair (n + 1, pairs) whether nothing known breaks a constraint between them."""
    nearer = all_separations(run.trajectory) < limit_of(run.scenario, "min_separation")
    most = angle_limit(run.scenario)
    return ~nearer & ~(angles_deg(run) > most if most else np.zeros_like(nearer))


def delta_v(flight: FormationFlight) -> Array:
    """Return the size of each delta-v commanded, held (n + 1, m) [m/s]; NaN of a lost craft."""
    size = np.linalg.norm(flight.delta_v, axis=-1)
    return held(np.where(flight.healthy, size, math.nan))


def spent(run: Flown) -> Array:
    """Return the delta-v that each craft has spent (n + 1, m) [m/s]; unknown ones are left out."""
    size = np.nan_to_num(delta_v(run.trajectory)[:-1])
    if run.scenario is not None and run.scenario.plant.saturates:
        size = np.minimum(size, run.scenario.plant.max_delta_v)
    return np.vstack([np.zeros(size.shape[1]), np.cumsum(size, axis=0)])


def shifts(flight: FormationFlight) -> Array:
    """Return the time shifts, held (n + 1, m) [control steps]; NaN where there is none."""
    known = (flight.time_shift >= 0) & ~concluded_lost(flight)
    return held(np.where(known, flight.time_shift, math.nan))


def room_percent(flight: FormationFlight) -> Array:
    """Return the least room (n,) along each prediction [% of its limit]; NaN: no constraint."""
    margin = flight.governor_margin
    return np.where(np.isfinite(margin), 100.0 * margin, math.nan)


def admissible(flight: FormationFlight) -> Array:
    """Return the admissible candidates (n,) of each step; NaN: not counted."""
    return np.where(flight.n_admissible >= 0, flight.n_admissible, math.nan)


def concluded_lost(flight: FormationFlight) -> NDArray[np.bool_]:
    """Tell of each craft (n, m) whether the governor concluded that it is lost."""
    told = flight.lost.shape == flight.healthy.shape  # a law that concludes nothing tells nothing
    return flight.lost if told else np.zeros_like(flight.healthy)


def governor_chose(flight: FormationFlight) -> bool:
    """Tell whether a governor weighed shifts."""
    return bool(np.isfinite(flight.cost).any())
