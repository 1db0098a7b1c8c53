"""Launch plan: scenario, folder and processes. Nothing is started here."""

from __future__ import annotations

import itertools
import os
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Final

from spacecraft_gnc.errors import LaunchError
from spacecraft_gnc.launcher.environment import require_middleware
from spacecraft_gnc.parameters.checked import plain_values
from spacecraft_gnc.parameters.declare import flatten
from spacecraft_gnc.parameters.sections import NODE_NAMES
from spacecraft_gnc.parameters.yaml_file import Sections
from spacecraft_gnc.parameters.yaml_scalar import emit
from spacecraft_gnc.recording import BAG_FOLDER, RUN_SCENARIO
from spacecraft_gnc.scenario import Fleet, Scenario, load_fleet
from spacecraft_gnc.scenario.node_sections import (
    add_file,
    add_option,
    agent_nodes,
    given_to,
    node_names,
)
from spacecraft_gnc.scenario.overrides import replaces_duration
from spacecraft_gnc.scenario.schema import ROLES
from spacecraft_gnc.scenario.shipped import find

PLANT: Final = "plant"
RECORDER: Final = "recorder"
COMPOSED: Final = "graph"
"""Name of the process that hosts all nodes in a composed launch."""
_RUNS: Final = Path("runs")


class LaunchRefused(LaunchError):
    """The requested launch is not possible."""

    exit_code: ClassVar[int] = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class LaunchPlan:
    """A prepared launch.

    Attributes
    ----------
    fleet
        The agents to fly, overrides included.
    parameter_file
        The file that every node reads: the user's own, or one in ``out`` with the values to fly
        if ROS 2 would give the nodes other values.
    out
        Folder of this run: bag, logs.
    nodes
        The nodes to start, named relative to the graph.
    composed
        Whether they share one process.
    restart
        Whether a dead controller, governor or recorder is restarted.
    """

    fleet: Fleet
    parameter_file: Path
    out: Path
    nodes: tuple[str, ...]
    composed: bool
    restart: bool

    @property
    def scenario(self) -> Scenario:
        """The scenario of the only agent; of several, that of the first."""
        return self.fleet.leading

    @property
    def records(self) -> bool:
        """Whether the launch records a bag."""
        return RECORDER in self.nodes

    @property
    def bag(self) -> Path:
        """Folder of the bag."""
        return self.out / BAG_FOLDER

    def discard(self) -> None:
        """Remove the files of a run that was refused before it began."""
        with suppress(OSError):  # not empty: holds other files
            (self.out / RUN_SCENARIO).unlink(missing_ok=True)
            self.out.rmdir()

    @property
    def logs(self) -> Path:
        """Folder of the nodes' logs."""
        return self.out / "logs"


def make_plan(
    path: Path,
    overrides: Sequence[str] = (),
    *,
    namespace: str | None = None,
    out: Path | None = None,
    record: bool = True,
) -> LaunchPlan:
    """Check a scenario, create the folder of its run and return the plan.

    The nodes of a single vehicle run in the root namespace, even if the sections belong to another
    one; controllers and governors of several agents run in their own.

    Raises
    ------
    GncError
        If the scenario is invalid.
    LaunchRefused
        If the folder cannot be used, or there is no plant.
    MiddlewareMissing
        If ROS 2 cannot start.
    """
    path = find(path)
    _require_utf8(path, out)
    fleet = load_fleet(path, overrides, namespace)
    nodes = tuple(n for n in fleet.nodes if record or n != RECORDER)
    if PLANT not in nodes:
        raise LaunchRefused(
            f"{path}: launcher.nodes: received {list(nodes)}; required the plant among them, which "
            f"owns simulated time; use {list(NODE_NAMES)}"
        )
    fleet.check_cores()
    require_middleware(os.environ)
    folder = _make_folder(path, out)
    peers = [node for node in nodes if node != PLANT]
    changes: dict[str, Any] = {}
    if set(peers) != set(fleet.peers):
        changes["plant.peers"] = peers
    if replaces_duration(overrides):
        changes["launcher.cut_short"] = "true"
    parameter_file = path.resolve()
    if overrides or changes or not _is_read_as(fleet, path):
        changes |= dict(_named_files(fleet, path.resolve().parent))
        words = [*overrides, *(f"{key}={value}" for key, value in changes.items())]
        merged = load_fleet(path, words, namespace)
        parameter_file = folder / RUN_SCENARIO
        parameter_file.write_text(merged.to_yaml(defaults=True), encoding="utf-8")
        fleet = merged
    launcher = fleet.launcher
    return LaunchPlan(
        fleet=fleet,
        parameter_file=parameter_file,
        out=folder,
        nodes=nodes,
        composed=launcher.composed,
        restart=launcher.on_node_death == "restart" and not launcher.composed,
    )


def _named_files(fleet: Fleet, folder: Path) -> Iterator[tuple[str, str]]:
    """Yield the parameters that name files, as whole paths: the file of a run is elsewhere."""
    for agent, one in fleet.agents.items():
        for section, name, path in one.named_files():
            key = f"/{agent}/{section}.{name}" if agent else f"{section}.{name}"
            yield key, emit(str(folder / path))


def node_options(autostart: bool, bag: Path) -> list[str]:
    """Return the launcher's overrides of a node's parameter file, as values of ``-p``."""
    return [f"autostart:={emit(autostart)}", f"{RECORDER}:storage_folder:={emit(str(bag))}"]


def _is_read_as(fleet: Fleet, path: Path) -> bool:
    """Tell whether the nodes, given a file and the launcher's options, fly a scenario.

    They do not if its sections belong to another namespace, or if one of them follows the sections
    into which the options are merged.
    """
    bag = Path("bag")
    sections: Sections = {}
    add_file(sections, path)
    for option in node_options(False, bag):
        add_option(sections, option)
    for agent, scenario in fleet.agents.items():
        nodes = agent_nodes(agent) if agent else node_names()
        given = plain_values(given_to(sections, nodes))
        wanted = {name: flatten(scenario.sections.get(name, {})) for name in ROLES}
        for name in NODE_NAMES:
            wanted[name]["autostart"] = False
        wanted[RECORDER]["storage_folder"] = str(bag)
        if {name: given.get(name, {}) for name in ROLES} != wanted:
            return False
    return True


def _require_utf8(*paths: Path | None) -> None:
    """Refuse names that ROS 2 cannot accept as an argument of a node."""
    for path in filter(None, paths):
        try:
            str(path.absolute()).encode()
        except UnicodeEncodeError as error:
            raise LaunchRefused(
                f"{path}: received a name with the byte {str(error.object)[error.start]!a}; "
                "required UTF-8, which ROS 2 needs; rename it"
            ) from None


def _make_folder(scenario: Path, out: Path | None) -> Path:
    """Create the folder of a run: ``out``, or the next free ``runs/SCENARIO-N``."""
    try:
        if out is None:
            return next_free(_RUNS, scenario.stem)
        out.mkdir(parents=True, exist_ok=True)
        if any(out.iterdir()):
            raise LaunchRefused(
                f"--out: received {str(out)!r}, which holds files; required a new or empty folder, "
                "so that no earlier run is overwritten; choose another one"
            )
        with tempfile.NamedTemporaryFile(dir=out):  # permission bits alone are not conclusive
            pass
    except OSError as error:
        place = out if out is not None else _RUNS
        reason = os.strerror(error.errno or 0)
        raise LaunchRefused(
            f"--out: received {str(place)!r} ({reason}); required a folder that can be written; "
            "choose another one with --out"
        ) from error
    return out


def next_free(parent: Path, stem: str) -> Path:
    """Create and return ``parent/stem-1``, or the next that is free.

    Raises
    ------
    OSError
        If it cannot be created.
    """
    parent.mkdir(parents=True, exist_ok=True)
    for number in itertools.count(1):
        folder = parent / f"{stem}-{number}"
        try:
            folder.mkdir()
        except FileExistsError:
            continue
        return folder
    raise AssertionError("unreachable")
