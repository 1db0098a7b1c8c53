"""Provenance of a run: versions, machine and methods, as stored in a bag."""

from __future__ import annotations

import hashlib
import platform
import subprocess
from collections.abc import Mapping
from datetime import datetime, timezone
from importlib import metadata
from pathlib import Path
from typing import Final

from spacecraft_gnc import __version__
from spacecraft_gnc.scenario import Fleet, Scenario
from spacecraft_gnc.scenario.shipped import shipped_file
from spacecraft_gnc.vehicles import registry

RUN_RECORD: Final = "run"
"""Name of the metadata record that `run_record` fills."""
PARAMETERS_ATTACHMENT: Final = "parameters.yaml"
"""Name under which a recorder attaches what every node had as its parameters."""
LOCK_ATTACHMENT: Final = "requirements.lock"
"""Name under which a recorder attaches the lock file of the dependencies."""
_ROOT = Path(__file__).parents[2]  # of a checkout, or of an editable installation of one
_PATIENCE = 5.0  # [s] wall for git, which may meet a slow disk


def run_record(fleet: Fleet, middleware: Mapping[str, str]) -> dict[str, str]:
    """Return the record of a run that begins now.

    Parameters
    ----------
    fleet
        What flies.
    middleware
        Versions that only a node knows: ``rclpy``, ``rmw``.

    Returns
    -------
    dict
        Texts by name; what is not known, or not read by the method, is empty. Of several agents
        each has its own: ``sc1.method``.
    """
    lock = lock_file()
    of_agents = {
        f"{agent}.{name}" if agent else name: text
        for agent, one in fleet.agents.items()
        for name, text in _of_agent(one).items()
    }
    return {
        "package_version": __version__,
        "git_commit": _commit(),
        "lock_sha256": hashlib.sha256(lock).hexdigest() if lock else "",
        "host": platform.node(),
        "cpu": _processor(),
        "os": platform.platform(),
        "python": platform.python_version(),
        "numpy": version_of("numpy"),
        "numba": version_of("numba"),
        **middleware,
        "started": datetime.now(timezone.utc).isoformat(timespec="milliseconds"),
        "mode": fleet.plant.mode,
        **of_agents,
    }


def _of_agent(scenario: Scenario) -> dict[str, str]:
    """Return what the record says of one agent."""
    traits, vehicle = scenario.method, scenario.vehicle
    return {
        "vehicle": scenario.plant.vehicle,
        "method": scenario.controller.method,
        "variant": scenario.controller.variant if traits.variants else "",
        "formulation": scenario.controller.formulation if "formulation" in traits.reads else "",
        "governor": scenario.governor.governor,
        "vehicle_package": registry.provider("vehicles", scenario.vehicle.name),
        "method_package": registry.provider("controllers", scenario.controller.method, vehicle),
        "governor_package": registry.provider("governors", scenario.governor.governor, vehicle),
    }


def version_of(distribution: str) -> str:
    """Return the version of an installed distribution; empty where there is none."""
    try:
        return metadata.version(distribution)
    except metadata.PackageNotFoundError:
        return ""


def lock_file() -> bytes:
    """Return the lock file that came with the package; empty where none did."""
    path = shipped_file(f"../{LOCK_ATTACHMENT}")  # beside config/, in a checkout and in share/
    return b"" if path is None else path.read_bytes()


def _commit() -> str:
    """Return the commit of a checkout, with ``-dirty`` where files differ from it."""
    if not (_ROOT / ".git").exists():  # an installed package may lie in somebody else's repository
        return ""
    command = ["git", "-C", str(_ROOT), "describe", "--always", "--dirty", "--abbrev=40"]
    try:
        told = subprocess.run(
            [*command, "--exclude=*"], capture_output=True, text=True, timeout=_PATIENCE, check=True
        )
    except (OSError, subprocess.SubprocessError):
        return ""
    return told.stdout.strip()


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    named = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(named, platform.processor() or platform.machine())
