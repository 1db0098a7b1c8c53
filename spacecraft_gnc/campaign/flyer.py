"""One run of a campaign: its scenario, its flight and its row."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from time import perf_counter
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.errors import GncError
from spacecraft_gnc.parameters.parameter import Value
from spacecraft_gnc.status import Source

if TYPE_CHECKING:
    from spacecraft_gnc.campaign.spec import Spec
    from spacecraft_gnc.loop.flight import Flight
    from spacecraft_gnc.scenario import Scenario
    from spacecraft_gnc.types import Array

PASSED: Final = "passed"
FAILED: Final = "failed"
REFUSED: Final = "refused"
ERROR: Final = "error"
STATUSES: Final = (PASSED, FAILED, REFUSED, ERROR)
"""Flown and passed; flown and failed; refused before it flew; ended by an exception."""
REASON: Final = "reason"
HEAD: Final = ("run", "status", "passed", REASON)
"""First columns of a row; the parameters and the metrics follow."""
WALL_TIME: Final = "wall_time"
"""Last column of a row: wall time of the run with all that belongs to it [s]."""
_WALL: Final = ("wall_", "solve_time_")
_SEEDED: Final = ("seed", "run")  # parameters of a plant with random numbers
_COUNTS: Final = {"sources": tuple(source.name for source in Source)}
"""Metrics that leave out what did not occur: a column is 0 there, not without a value."""


class Flown(NamedTuple):
    """A run that was flown."""

    row: dict[str, Any]
    flight: Flight | None
    """None where it was refused, or raised."""
    scenario: Scenario | None
    """None where it was refused."""


class Flyer:
    """Flies single runs of a campaign.

    Parameters
    ----------
    spec
        The campaign.
    """

    def __init__(self, spec: Spec) -> None:
        self.spec = spec
        self._template = spec.template
        known = spec.scenario.values["plant"]
        self._seeded = {name for name in _SEEDED if name in known}

    def warm_up(self) -> None:
        """Load the kernels of the scenario as it stands, which is no part of a flight."""
        with suppress(GncError):  # it may be one that only its variations make fly
            loop = self.spec.scenario.build()
            for core in (loop.plant, loop.controller, loop.governor):
                core.warm_up()

    def overrides(self, run: int, point: Array | None = None) -> dict[str, Value]:
        """Return what a run lays over the scenario, as ``--set`` names it.

        Parameters
        ----------
        run
            From 0.
        point
            (d,) of the run in the design, if it is at hand.
        """
        if point is None:
            point = self.spec.design.points(run, 1)[0]
        seeds = {"seed": self.spec.seed, "run": run}
        return {
            **{f"plant.{name}": seeds[name] for name in _SEEDED if name in self._seeded},
            **self.spec.variations.values(point),
        }

    def scenario(self, run: int, point: Array | None = None) -> Scenario:
        """Return the scenario of a run.

        Raises
        ------
        InvalidScenario
            If it is refused.
        """
        return self._template.scenario(self.overrides(run, point))

    def fly(self, run: int, point: Array | None = None) -> Flown:
        """Fly a run; one that is refused or raises has a row with its reason."""
        return self._fly(run, self.overrides(run, point))

    def fly_nominal(self) -> Flown:
        """Fly the scenario as it stands."""
        return self._fly(-1, {})

    def row_without_flight(self, run: int, reason: str) -> dict[str, Any]:
        """Return the row of a run that cannot be flown at all."""
        return self._row(run, self.overrides(run), ERROR, reason)

    def row_of(self, run: int, flight: Flight, scenario: Scenario) -> dict[str, Any]:
        """Return the row of a run that was flown elsewhere; it has no wall time."""
        return self._row_of(run, self.overrides(run), flight, scenario)

    def _fly(self, run: int, values: Mapping[str, Value]) -> Flown:
        begun = perf_counter()
        flown = self._flown(run, values)
        flown.row[WALL_TIME] = perf_counter() - begun
        return flown

    def _flown(self, run: int, values: Mapping[str, Value]) -> Flown:
        scenario: Scenario | None = None
        try:
            scenario = self._template.scenario(values)
            loop = scenario.build()
        except GncError as error:
            return Flown(self._row(run, values, REFUSED, _reason(error)), None, scenario)
        except Exception as error:  # noqa: BLE001 - of a plug-in: a row, not the end of the campaign
            return Flown(self._row(run, values, ERROR, _reason(error)), None, scenario)
        try:
            flight = loop.run()
            row = self._row_of(run, values, flight, scenario)
        except Exception as error:  # noqa: BLE001 - likewise
            return Flown(self._row(run, values, ERROR, _reason(error)), None, scenario)
        return Flown(row, flight, scenario)

    def _row_of(
        self, run: int, values: Mapping[str, Value], flight: Flight, scenario: Scenario
    ) -> dict[str, Any]:
        metrics = dict(flat_metrics(summarize(flight, scenario)))
        passed = self.spec.variations.criterion.holds({**values, **metrics})
        return self._row(run, values, PASSED if passed else FAILED, None, metrics)

    def _row(
        self,
        run: int,
        values: Mapping[str, Value],
        status: str,
        reason: str | None,
        metrics: Mapping[str, Any] | None = None,
    ) -> dict[str, Any]:
        varied = {name: values.get(name) for name in self.spec.variations.names}
        head = dict(zip(HEAD, (run, status, status == PASSED, reason), strict=True))
        return {**head, **varied, **(metrics or {}), WALL_TIME: None}


def is_wall(name: str) -> bool:
    """Tell whether a column holds wall times, which no two flights share."""
    return name.startswith(_WALL)


def row_differences(stored: Mapping[str, Any], flown: Mapping[str, Any]) -> list[str]:
    """Return in what columns but the wall times two rows of a run differ, a text for each.

    A column without a value is the same as no such column.
    """
    names = dict.fromkeys((*stored, *flown))
    pairs = ((name, stored.get(name), flown.get(name)) for name in names if not is_wall(name))
    return [f"{name} {a!r} / {b!r}" for name, a, b in pairs if not _is_same(a, b)]


def _is_same(a: Any, b: Any) -> bool:
    """Compare bit for bit; a column of doubles may hold an integer as one."""
    if isinstance(a, list) and isinstance(b, list):
        return len(a) == len(b) and all(map(_is_same, a, b))
    if {type(a), type(b)} == {int, float}:
        a, b = float(a), float(b)
    return repr(a) == repr(b)  # tells 0.0 from -0.0, and no NaN from another


def flat_metrics(metrics: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the metrics of a flight by flat name, such as ``zone_margin_deg.sun``."""
    for key, value in metrics.items():
        name = f"{prefix}{key}"
        if isinstance(value, Mapping):
            counts = dict.fromkeys(_COUNTS.get(name, ()), 0)
            yield from flat_metrics({**counts, **value}, f"{name}.")
        else:
            yield name, _plain(value)


def _plain(value: Any) -> Any:
    """Return a value as a table holds it: of messages, one text."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, list | tuple):
        if all(isinstance(item, bool | int | float) for item in value) and value:
            return list(value)
        texts = (item.get("text", item) if isinstance(item, Mapping) else item for item in value)
        return "; ".join(map(str, texts)) or None
    return value


def _reason(error: Exception) -> str:
    """Return in one line why a run was not flown, or not to its end."""
    text = "; ".join(str(error).splitlines())
    return text if isinstance(error, GncError) else f"{type(error).__name__}: {text}"
