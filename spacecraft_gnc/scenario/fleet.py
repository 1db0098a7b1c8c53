"""The agents of one graph: a scenario for each, and what they have in common."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeVar

from spacecraft_gnc.arguments import require_path
from spacecraft_gnc.parameters.problems import InvalidScenario, Problem, shown, suggestion
from spacecraft_gnc.parameters.sections import LauncherParameters, RecorderParameters
from spacecraft_gnc.parameters.yaml_file import read
from spacecraft_gnc.scenario.agents import agents_in, incomplete, nodes_of
from spacecraft_gnc.scenario.craft import craft_names, craft_of
from spacecraft_gnc.scenario.load import load_nodes, load_one
from spacecraft_gnc.scenario.node_sections import agent_nodes, has_craft, unread
from spacecraft_gnc.scenario.overrides import Overrides, apply
from spacecraft_gnc.scenario.scenario import STATED, Scenario, sections_to_yaml
from spacecraft_gnc.scenario.schema import OF_AGENT, OF_GRAPH, ROLES
from spacecraft_gnc.scenario.shipped import find

if TYPE_CHECKING:  # the cores need numba, a check of a file does not
    from spacecraft_gnc.loop.closed_loop import ClosedLoop

_Made = TypeVar("_Made")
_PLANT, _CONTROLLER, _ = OF_AGENT
_HOSTED: Final = ("mode", "real_time_factor", "command_timeout", "max_held_steps", "peers")
"""Parameters of a plant that its node reads once for all agents."""


@dataclass(frozen=True, slots=True, eq=False)
class Fleet:
    """The agents of a graph, which share one plant node, one clock and one recorder.

    Attributes
    ----------
    agents : mapping
        Scenario of each agent by its namespace, without the first slash; the only agent of a graph
        in the root namespace has an empty one.
    further_warnings : tuple of str
        Those that are of no agent alone, one line each.

    Raises
    ------
    InvalidScenario
        If the agents disagree on what they share: period, duration, pace, nodes.
    """

    agents: Mapping[str, Scenario]
    further_warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Have the agents agree."""
        problems = [*self._disagreements(), *self._unknown_nodes()]
        if problems:
            raise InvalidScenario(problems)

    def __repr__(self) -> str:
        """Return what would fly, an agent after the other."""
        told = (f"/{agent}: {one!r}" for agent, one in self.agents.items())
        return f"Fleet({', '.join(told)})"

    @property
    def leading(self) -> Scenario:
        """The first agent's, whose values of what all share are those of all."""
        return next(iter(self.agents.values()))

    @property
    def path(self) -> str:
        """Where it comes from."""
        return self.leading.path

    @property
    def plant(self) -> Any:
        """Parameters of the plant, of which the pace, the duration and the peers are shared."""
        return self.leading.plant

    @property
    def recorder(self) -> RecorderParameters:
        """Parameters of the recorder."""
        return self.leading.recorder

    @property
    def launcher(self) -> LauncherParameters:
        """Parameters of the launcher."""
        return self.leading.launcher

    @property
    def period(self) -> float:
        """Control period of every agent [s]."""
        return self.leading.period

    @property
    def n_steps(self) -> int:
        """Control steps of every agent."""
        return self.leading.n_steps

    @property
    def craft(self) -> dict[str, str]:
        """Agent of each craft, by its namespace without the first slash, in the vehicle's order.

        An agent that is one craft, in its own namespace, is not among them.
        """
        agents = self.agents.items()
        return {name.strip("/"): agent for agent, one in agents for name in craft_names(one, agent)}

    def craft_of(self, agent: str) -> tuple[str, ...]:
        """Return the craft of an agent, likewise."""
        return tuple(name for name, host in self.craft.items() if host == agent)

    @property
    def nodes(self) -> tuple[str, ...]:
        """Nodes to start, named relative to the graph: ``plant``, ``sc1/nmpc_controller``."""
        return self.expanded(self.launcher.nodes)

    @property
    def peers(self) -> tuple[str, ...]:
        """Nodes that the plant waits for before step 0, likewise."""
        return self.expanded(self.plant.peers)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What to know before it flies, one line each."""
        own = (
            f"/{agent}: {text}" if agent else text
            for agent, one in self.agents.items()
            for text in one.warnings
        )
        return (*self.further_warnings, *own)

    def build(self) -> dict[str, ClosedLoop]:
        """Return the closed loop of each agent, as `Scenario.build`; they fly independently."""
        return self._for_each(Scenario.build)

    def check_cores(self) -> None:
        """Have the cores of every agent refuse what no value shows (`Scenario.check_cores`)."""
        self._for_each(Scenario.check_cores)

    def to_yaml(self, defaults: bool = False) -> str:
        """Return a ROS 2 parameter file that loads as this fleet (`Scenario.to_yaml`)."""
        return sections_to_yaml(dict(self._named_sections(lambda one: one.nested(defaults))))

    def stated_defaults(self) -> str:
        """Return, likewise, the defaults that formulas gave (`Scenario.stated_defaults`)."""
        return STATED + sections_to_yaml(dict(self._named_sections(Scenario.nested_defaults)))

    def _named_sections(
        self, read: Callable[[Scenario], Mapping[str, Mapping[str, Any]]]
    ) -> Iterator[tuple[str, Mapping[str, Any]]]:
        for agent, one in self.agents.items():
            for section, values in read(one).items():
                if not agent or section in OF_AGENT:
                    yield _section(agent, section, one), values
        if "" not in self.agents:
            yield from ((s, v) for s, v in read(self.leading).items() if s in OF_GRAPH)

    def expanded(self, names: Iterable[str]) -> tuple[str, ...]:
        """Return names of nodes relative to the graph.

        A governor without an agent stands for that of each; a controller likewise, and where an
        agent has several craft for that of each craft.
        """
        found: dict[str, None] = {}
        for name in names:
            spaces = self._spaces(name) if name in OF_AGENT and name != _PLANT else [""]
            found |= dict.fromkeys(f"{space}/{name}".strip("/") for space in spaces)
        return tuple(found)

    def _spaces(self, role: str) -> Iterator[str]:
        """Yield the namespaces of the nodes of a role."""
        for agent in self.agents:
            craft = self.craft_of(agent) if role == _CONTROLLER else ()
            yield from craft or (agent,)

    def _for_each(self, make: Callable[[Scenario], _Made]) -> dict[str, _Made]:
        return _gathered({agent: partial(make, one) for agent, one in self.agents.items()}, [])

    def _disagreements(self) -> Iterator[Problem]:
        (first, leading), *others = self.agents.items()
        for agent, one in others:
            for key, ours, theirs in _shared_values(leading, one):
                need = f"{ours} as of /{first}, for one clock leads all agents"
                remedy = "make them equal: what section plant in the root states holds for all"
                yield Problem(self.path, None, f"/{agent}/{key}", theirs, need, remedy)

    def _unknown_nodes(self) -> Iterator[Problem]:
        own = [f"{space}/{role}" for role in OF_AGENT[1:] for space in self._spaces(role) if space]
        known = [*ROLES[:-1], *own]
        for name in self.launcher.nodes:
            if name not in known:
                need = f"one of {', '.join(known)}"
                remedy = suggestion(name, known)
                yield Problem(self.path, None, "launcher.nodes", shown(name), need, remedy)


def load_fleet(path: str | Path, overrides: Overrides = (), namespace: str | None = None) -> Fleet:
    """Read and check a scenario file of one or several agents.

    Parameters
    ----------
    path : str or Path
        ROS 2 parameter file, or the name of a scenario that comes with the package.
    overrides : mapping or sequence of str
        As for `load`; ``/sc1/nmpc_controller.horizon`` is that of one agent, without a namespace
        it is that of all.
    namespace : str, optional
        Of the one agent to take; by default all.

    Raises
    ------
    InvalidScenario
        With every problem of the file and of the overrides at once.
    """
    file = str(find(require_path("path", path)))
    sections, problems = read(Path(file), ROLES)
    agents = agents_in(sections)
    if namespace is not None or not agents:
        return Fleet({"": load_one(sections, file, problems, overrides, namespace)})
    hosts = [agent for agent in agents if has_craft(sections, agent_nodes(agent))]
    laid_over = apply(overrides, problems, agents, hosts)
    problems += incomplete(sections, file)
    makers = {
        agent: partial(load_nodes, sections, agent_nodes(agent), file, [], laid_over[agent])
        for agent in agents
        if not any(problem.key == f"/{agent}" for problem in problems)
    }
    known = {name: role for agent in agents for name, role in nodes_of(sections, agent).items()}
    names = ", ".join(unread(sections, known))
    warnings = (f"{file}: {names}: not read, no node of the graph matches",) if names else ()
    return Fleet(_gathered(makers, problems), warnings)


def gather(makers: Mapping[str, Callable[[], Scenario]]) -> Fleet:
    """Return the fleet of agents, each made by a call, with the problems of all.

    Raises
    ------
    InvalidScenario
        If one is refused, or they disagree.
    """
    return Fleet(_gathered(makers, []))


def _section(agent: str, role: str, scenario: Scenario) -> str:
    """Return the name of a section; that of a controller holds for each craft."""
    place = f"/{agent}" if agent else ""
    if role == _CONTROLLER and craft_of(scenario):
        return f"{place}/**/{role}"
    return f"{place}/{role}" if place else role


def _shared_values(first: Scenario, other: Scenario) -> Iterator[tuple[str, str, str]]:
    """Yield name and both values of what two agents had to share and do not."""
    if other.period != first.period:
        yield "nmpc_controller.time_step", f"{first.period:g} s", f"{other.period:g} s"
    elif other.n_steps != first.n_steps:
        yield "plant.duration", f"{first.n_steps} control steps", f"{other.n_steps} control steps"
    for name in _HOSTED:
        ours, theirs = (one.values[_PLANT][name] for one in (first, other))
        if ours != theirs:
            yield f"plant.{name}", shown(ours), shown(theirs)


def _gathered(
    makers: Mapping[str, Callable[[], _Made]], problems: list[Problem]
) -> dict[str, _Made]:
    """Return what is made for each agent; raise all problems at once, each naming its agent."""
    made, refused = {}, {}
    for agent, make in makers.items():
        try:
            made[agent] = make()
        except InvalidScenario as error:
            refused[agent] = error.problems
    counts = Counter(problem for found in refused.values() for problem in found)
    for agent, found in refused.items():
        for problem in found:
            common = len(makers) == counts[problem] and (len(makers) > 1 or not agent)
            problems.append(problem if common else _of_agent(problem, agent))
    if problems:
        raise InvalidScenario(sorted(dict.fromkeys(problems), key=_place))
    return made


def _of_agent(problem: Problem, agent: str) -> Problem:
    is_named = problem.key.startswith(OF_AGENT)
    return replace(problem, key=f"/{agent}/{problem.key}") if agent and is_named else problem


def _place(problem: Problem) -> tuple[str, int]:
    return problem.file, problem.line or 0
