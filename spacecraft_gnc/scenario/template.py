"""A scenario file that is read once and of which many scenarios are made."""

from __future__ import annotations

from pathlib import Path

from spacecraft_gnc.arguments import require_path
from spacecraft_gnc.parameters.problems import Problem
from spacecraft_gnc.parameters.yaml_file import Given, read
from spacecraft_gnc.scenario.agents import nodes_of_one
from spacecraft_gnc.scenario.load import lay_over, load_nodes
from spacecraft_gnc.scenario.node_sections import has_craft
from spacecraft_gnc.scenario.overrides import Overrides, apply
from spacecraft_gnc.scenario.scenario import Scenario
from spacecraft_gnc.scenario.schema import ROLES
from spacecraft_gnc.scenario.shipped import find


class Template:
    """A scenario file, read once, whose values are replaced time and again.

    Parameters
    ----------
    path : str or Path
        ROS 2 parameter file, or the name of a scenario that comes with the package.
    overrides : mapping or sequence of str
        Values that replace those of the file in every scenario, as for `load`.
    namespace : str, optional
        Of the nodes that the file is for, as for `load`.
    text : str, optional
        What the file says, if it is at hand; ``path`` then only tells where it stands.

    Raises
    ------
    InvalidScenario
        If the file cannot be read, or is about several spacecraft.
    """

    def __init__(
        self,
        path: str | Path,
        overrides: Overrides = (),
        namespace: str | None = None,
        text: str | None = None,
    ) -> None:
        source = require_path("path", path)
        self._file = str(source if text is not None else find(source))
        self._sections, self._problems = read(Path(self._file), ROLES, text)
        self._nodes, self._agent, self._warnings = nodes_of_one(
            self._sections, self._file, namespace
        )
        self._hosts = [self._agent] if has_craft(self._sections, self._nodes) else []
        self._base = self._applied(overrides, self._problems)

    def scenario(self, overrides: Overrides = ()) -> Scenario:
        """Return what `load` gives with these overrides behind those of the template.

        Raises
        ------
        InvalidScenario
            With every problem of the file and of all overrides at once.
        """
        problems = list(self._problems)
        laid_over = {section: dict(entries) for section, entries in self._base.items()}
        lay_over(laid_over, self._applied(overrides, problems))
        return load_nodes(
            self._sections, self._nodes, self._file, problems, laid_over, self._warnings
        )

    def _applied(self, overrides: Overrides, problems: list[Problem]) -> Given:
        return apply(overrides, problems, [self._agent], self._hosts)[self._agent]
