"""Charts of the live view of a formation."""

from __future__ import annotations

from itertools import combinations
from typing import Final

from spacecraft_gnc.drawing.live import INK, WARN, Panel, Series, source_panel
from spacecraft_gnc.vehicles.formation.craft import craft
from spacecraft_gnc.vehicles.formation.decision import Answer
from spacecraft_gnc.vehicles.formation.events import Standing, standing_name
from spacecraft_gnc.vehicles.formation.flown import angle_limit, limit_of
from spacecraft_gnc.vehicles.formation.scenario import Scenario
from spacecraft_gnc.vehicles.formation.summary import answer_name

_GOOD, _BAD, _BLUE, _PINK, _GRAY = "#2fc79b", "#f0554a", "#58aef0", "#d58fd0", "#93a1b1"
_STANDINGS: Final = dict(zip(map(standing_name, Standing), (_BLUE, _BAD, WARN, _GOOD), strict=True))
"""Color of each standing, on a dark page."""
_ANSWERS: Final = dict(
    zip(map(answer_name, Answer), (_GOOD, _BAD, "#f58a45", _PINK, WARN, _GRAY), strict=True)
)
_FIRST_OF_PAIRS: Final = 3  # colors before it are those of the first craft


class PanelsOf:
    """Charts of a scenario.

    Parameters
    ----------
    scenario
        What flies; None: not known.
    """

    def __init__(self, scenario: Scenario | None) -> None:
        self._scenario = scenario
        self._craft = () if scenario is None else craft(scenario)
        self._pairs = ["-".join(pair) for pair in combinations(self._craft, 2)]

    def all(self) -> list[Panel]:
        """Return the charts."""
        scenario = self._scenario
        most = limit_of(scenario, "max_delta_v")
        charts = [
            Panel(
                kind="bars", name="delta-v", title="Delta-v now", unit="m/s", limit=most,
                series=[self._of_craft("delta_v")], numbered="craft ",
            ),
            self._strip("separation", "Separation", "m", self._of_pairs("separation"),
                        limit_of(scenario, "min_separation")),
            self._strip("angle", "Communication angle", "deg", self._of_pairs("angle_deg"),
                        angle_limit(scenario)),
            self._strip("delta_v", "Delta-v", "m/s", self._of_craft("delta_v"), most),
            Panel(
                kind="strip", name="error", title="Distance from the commanded place", unit="m",
                log=True, series=[self._of_craft("error")], numbered="craft ",
            ),
        ]  # fmt: skip
        if scenario is not None and scenario.governor.governor != "none":
            charts += [
                self._strip("shift", "Time shift", "steps", self._of_craft("shift")),
                Panel(
                    kind="strip", name="cost", title="Cost of the shifts", unit="-", log=True,
                    series=[
                        Series("shift_cost", ["W"], WARN), Series("state_cost", ["Omega"], INK)
                    ],
                ),
                _band("answer", "Governor", _ANSWERS),
            ]  # fmt: skip
        return [*charts, _band("standing", "Formation", _STANDINGS), source_panel("Command")]

    def _strip(self, name: str, title: str, unit: str, series: Series, most: float = 0.0) -> Panel:
        numbered = "craft " if series.first == 0 else "pair "
        return Panel(
            kind="strip", name=name, title=title, unit=unit, series=[series], limit=most,
            numbered=numbered,
        )  # fmt: skip

    def _of_craft(self, key: str) -> Series:
        return Series(key, self._craft)

    def _of_pairs(self, key: str) -> Series:
        return Series(key, self._pairs, first=_FIRST_OF_PAIRS)


def _band(key: str, title: str, colors: dict[str, str]) -> Panel:
    return Panel(kind="band", name=key, title=title, series=[Series(key)], colors=colors)
