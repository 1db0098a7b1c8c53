"""A recorded flight, from a bag or from a file of ``gnc simulate``."""

from __future__ import annotations

from pathlib import Path
from typing import Final, NamedTuple

from spacecraft_gnc.analysis.plan_file import refuse_plan
from spacecraft_gnc.analysis.run_info import RunInfo
from spacecraft_gnc.analysis.vehicle import part, require_vehicle
from spacecraft_gnc.audit.evidence import Progress
from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.loop.flight import Flight, agents_in
from spacecraft_gnc.recording.bag import open_bag
from spacecraft_gnc.recording.steps import flight_namespace
from spacecraft_gnc.scenario.craft import craft_names
from spacecraft_gnc.scenario.recorded import parse_scenario, scenario_texts
from spacecraft_gnc.vehicles import registry
from spacecraft_gnc.vehicles.known_signals import state_signals

NPZ_SUFFIX: Final = ".npz"


class RecordedRun(NamedTuple):
    """A recorded run."""

    trajectory: Flight
    info: RunInfo


def is_npz(path: Path) -> bool:
    """Tell whether a run is a file of ``gnc simulate``; a folder of such a name holds a bag."""
    return path.suffix == NPZ_SUFFIX and not path.is_dir()


def load_run(
    path: Path | str,
    *,
    namespace: str | None = None,
    allow_unfinished: bool = False,
    progress: Progress | None = None,
) -> RecordedRun:
    """Read a run: bag folder, .mcap file, or .npz file of ``gnc simulate --out``.

    Parameters
    ----------
    path
        What to read.
    namespace
        Of the spacecraft, where a bag holds several.
    allow_unfinished
        Read what is whole of a bag that was cut off, instead of refusing it.
    progress
        Called with the bytes read so far and in all.

    Raises
    ------
    RecordingError
        If it is none of these, or damaged; or if it holds a plan, no flight.
    """
    path = Path(path)
    if is_npz(path):
        refuse_plan(path)
        return _read_npz(path, namespace)
    return read_flight(
        path, namespace=namespace, allow_unfinished=allow_unfinished, progress=progress
    )


def _read_npz(path: Path, namespace: str | None) -> RecordedRun:
    agent = _agent_in_npz(path, namespace)
    text, defaults = Flight.load_scenario(path), Flight.load_defaults(path)
    scenario, problem = parse_scenario(text, path, agent or None, defaults)
    kind = registry.flight_of(None if scenario is None else scenario.vehicle)
    info = RunInfo(
        path=path,
        scenario=scenario,
        scenario_text=text,
        scenario_problem=problem,
        namespace=agent or None,
    )
    return RecordedRun(kind.load(path, agent), info)


def _agent_in_npz(path: Path, namespace: str | None) -> str:
    """Return the agent to read; a craft means the agent that it is one of.

    A file of one flight has no agent, whatever is asked for, unless its craft are known.
    """
    known = agents_in(path)
    asked = "" if namespace is None else namespace.strip("/")
    if known == ("",):
        craft = _craft_in_npz(path, "") if asked else ()
        if craft and f"/{asked}" not in craft:
            listed = ", ".join(craft)
            raise RecordingError(
                f"{path}: a flight of several craft ({listed}), none of them {namespace}; required "
                "one of these, or none; leave out --namespace"
            )
        return ""
    wanted = known if namespace is None else [a for a in known if a == asked]
    wanted = wanted or [a for a in known if asked in _craft_in_npz(path, a)]
    if len(wanted) == 1:
        return wanted[0]
    listed = ", ".join(f"/{agent}" for agent in known)
    asked = "" if namespace is None else f", none of them {namespace}"
    raise RecordingError(
        f"{path}: several spacecraft ({listed}){asked}; required one; name it with --namespace"
    )


def _craft_in_npz(path: Path, agent: str) -> tuple[str, ...]:
    """Return the craft of an agent, by the scenario in a file."""
    texts = Flight.load_scenario(path), path, agent or None, Flight.load_defaults(path)
    scenario, _ = parse_scenario(*texts)
    return () if scenario is None else craft_names(scenario, agent)


def read_flight(
    path: Path | str,
    *,
    namespace: str | None = None,
    allow_unfinished: bool = False,
    progress: Progress | None = None,
) -> RecordedRun:
    """Read the flight in a bag, its topics aligned by the control step in every message.

    What acted is what the plant told that it applied; where that was not recorded it is the
    command. A row that lacks a message holds NaN in its place (integers: -1), and
    `RunInfo.missing` names the step. A flight whose last state was not recorded ends one step
    earlier.

    Parameters
    ----------
    path
        Bag folder or .mcap file.
    namespace
        Of the spacecraft, where the bag holds several.
    allow_unfinished
        Read what is whole of a bag that was cut off, instead of refusing it.
    progress
        Called with the bytes read so far and in all.

    Raises
    ------
    RecordingError
        If there is no readable bag, or no flight of one spacecraft in it.
    """
    with open_bag(path, allow_unfinished=allow_unfinished) as bag:
        require_vehicle(bag)
        text, defaults = scenario_texts(bag.attachments())
        name = flight_namespace(bag, namespace, state_signals())
        scenario, problem = parse_scenario(text, bag.path, name, defaults)
        recorded = part("columns", scenario)(bag, namespace, scenario, progress)
        info = RunInfo(
            path=bag.path,
            scenario=scenario,
            scenario_text=text,
            scenario_problem=problem,
            namespace=namespace,
            unfinished=bag.unfinished,
            missing=recorded.missing,
            overridden=recorded.overridden,
            metadata=bag.metadata(),
            remarks=tuple(bag.remarks()),
        )
    return RecordedRun(recorded.trajectory, info)
