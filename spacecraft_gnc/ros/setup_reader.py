"""Scenario of a live graph, read from the parameters of its nodes without blocking."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final

from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient

from spacecraft_gnc.errors import GncError
from spacecraft_gnc.ros.parameters import AGENTS, ROS_OWN, of_agent
from spacecraft_gnc.ros.remote import NOT_SET
from spacecraft_gnc.scenario import Scenario, from_sections
from spacecraft_gnc.scenario.craft import craft_of
from spacecraft_gnc.signals.graph import CONTROLLER, GOVERNOR, PLANT
from spacecraft_gnc.signals.members import Place

_RETRY: Final = 1.0  # [s] wall: an answer may be lost, and parameters are declared on configure
_PROOF: Final = {PLANT: "duration", CONTROLLER: "method", GOVERNOR: "governor"}
"""A parameter of each node that is there once the node is configured."""
_SHARED_PLANT: Final = f"/{PLANT}"
"""The plant of all agents."""


class SetupReader:
    """Asks plant, controller and governor for their parameters; never waits.

    Parameters
    ----------
    node
        The observer's.
    agent
        Namespace of the spacecraft, without the first slash; empty: the root.
    """

    def __init__(self, node: Node, agent: str) -> None:
        self._node, self._agent = node, agent
        self._place = Place(f"/{agent}" if agent else "")
        self._questions = {
            name: _Question(node, self._place.node(name), _PROOF[name]) for name in _PROOF
        }
        self._of_craft: dict[str, _Question] = {}
        if agent:  # its plant may be that of all agents
            self._questions[_SHARED_PLANT] = _Question(node, _SHARED_PLANT, AGENTS)
        self._told = False

    def restart(self) -> None:
        """Ask anew: another flight begins."""
        self._told = False
        for question in (*self._questions.values(), *self._of_craft.values()):
            question.restart()

    def poll(self, now: float) -> Scenario | None:
        """Return the scenario, once; None as long as it is not known. ``now``: wall time [s]."""
        if self._told:
            return None
        for question in self._questions.values():
            question.poll(now)
        sections = {name: q.values for name, q in self._questions.items() if q.values}
        if _SHARED_PLANT in sections:
            sections[PLANT] = of_agent(sections.pop(_SHARED_PLANT), self._agent)
        if PLANT in sections and CONTROLLER not in sections:
            sections |= self._ask_craft(sections[PLANT], now)
        if PLANT not in sections or CONTROLLER not in sections:
            return None
        if GOVERNOR not in sections and self._questions[GOVERNOR].is_there:
            return None
        self._told = True
        try:
            return from_sections(sections)
        except GncError:  # of another version: what it means is not known here
            return None

    def _ask_craft(self, plant: dict[str, Any], now: float) -> dict[str, dict[str, Any]]:
        """Return the section of the first craft's controller that answers: one law serves all."""
        try:
            craft = craft_of(from_sections({PLANT: plant}))
        except GncError:
            return {}
        for name in craft:
            node = self._place._replace(craft=name).node(CONTROLLER)
            question = self._of_craft.setdefault(
                name, _Question(self._node, node, _PROOF[CONTROLLER])
            )
            question.poll(now)
            if question.values:
                return {CONTROLLER: question.values}
        return {}


class _Question:
    """One node's parameters: first their names, then their types, then their values."""

    def __init__(self, node: Node, name: str, proof: str) -> None:
        self._client = AsyncParameterClient(node, name)
        self._proof = proof
        self.restart()

    def restart(self) -> None:
        self.values: dict[str, Any] = {}
        self._asked = -math.inf
        self._answer: Any = None
        self._take: Callable[[Any], None] = self._take_names

    @property
    def is_there(self) -> bool:
        return bool(self._client.services_are_ready())

    def poll(self, now: float) -> None:
        if self.values or not self.is_there:
            return
        if self._answer is not None and self._answer.done():
            # First: who polls once a retry only would else never take an answer.
            self._asked = now
            answer, self._answer = self._answer.result(), None
            self._take(answer)
        elif now - self._asked >= _RETRY:
            self._asked = now
            self._ask(self._client.list_parameters(), self._take_names)

    def _ask(self, question: Any, take: Callable[[Any], None]) -> None:
        self._answer, self._take = question, take

    def _take_names(self, answer: Any) -> None:
        self._names = sorted(set(answer.result.names) - set(ROS_OWN))
        if self._proof in self._names:  # else it is not configured yet
            self._ask(self._client.get_parameter_types(self._names), self._take_types)

    def _take_types(self, answer: Any) -> None:
        # One that is declared but not set makes a node answer nothing at all.
        known = zip(self._names, answer.types, strict=False)
        self._names = [name for name, kind in known if kind != NOT_SET]
        self._ask(self._client.get_parameters(self._names), self._take_values)

    def _take_values(self, answer: Any) -> None:
        values = map(parameter_value_to_python, answer.values)
        found = zip(self._names, values, strict=False)
        self.values = {n: v for n, v in found if not n.startswith("qos_overrides.")}
