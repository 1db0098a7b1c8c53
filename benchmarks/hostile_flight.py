"""A flight under attack: one process of `gnc launch`, what it prints and when, and its nodes.

Every wait has a deadline, and leaving the context ends every process of the flight.
"""

from __future__ import annotations

import os
import re
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import psutil
from hostile_side import PATIENCE, Lines, Side

from spacecraft_gnc.signals.seal import KEY, OFF

if TYPE_CHECKING:
    from typing_extensions import Self

ROOT: Final = Path(__file__).resolve().parents[1]
SCENARIO: Final = ROOT / "config" / "gupta2015_case1.yaml"
PERIOD: Final = 0.4  # [s] simulated, control period of Case I
NODES: Final = ("plant", "nmpc_controller", "reference_governor", "recorder")
_TICK: Final = 0.01  # [s] wall between two looks
_MODULE: Final = "spacecraft_gnc.nodes."
ENDLESS: Final = 10_000_000  # steps


class Row(NamedTuple):
    """One line of the table."""

    name: str
    done: str
    number: int
    required: str
    measured: str
    passed: bool | None
    """None: it was left out, and ``measured`` says why."""


class Late(Exception):
    """Something did not happen within its time."""


class Flight:
    """One launch of Case I.

    Parameters
    ----------
    folder
        New folder of the run.
    changes
        Overrides, as for ``--set``.
    steps
        Control steps to fly.
    record
        Whether with a recorder.
    sealed
        Whether the nodes get a key.
    environment
        Variables beside those of this process.
    options
        More options of ``gnc launch``.
    largest
        Bytes that a file of it may have; 0: any number.
    """

    def __init__(
        self,
        folder: Path,
        *changes: str,
        steps: int = ENDLESS,
        record: bool = True,
        sealed: bool = True,
        environment: Mapping[str, str] | None = None,
        options: Sequence[str] = (),
        largest: int = 0,
    ) -> None:
        self.out, self.steps = folder, steps
        self.changes = (f"plant.duration={steps * PERIOD!r}", *changes)
        self.watch: Side | None = None
        self._largest = largest
        self._sides: list[Side] = []
        self._nodes: dict[str, psutil.Process] = {}
        self._environment = {k: v for k, v in os.environ.items() if k != "ROS_DOMAIN_ID"}
        self._environment |= {"PYTHONPATH": str(ROOT), **(environment or {})}
        if not sealed:
            self._environment[KEY] = OFF
        start = [sys.executable, "-m", "spacecraft_gnc", "launch"]
        command = [*start, str(SCENARIO), "--out", str(folder), *options]
        for change in self.changes:
            command += ["--set", change]
        self.command = [*command, *([] if record else ["--no-record"])]

    def __enter__(self) -> Self:
        """Start it."""
        self._process = subprocess.Popen(
            self.command,
            env=self._environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            preexec_fn=self._limit if self._largest else None,  # noqa: PLW1509 - one system call
        )
        self.output, self.errors = Lines(self._process.stdout), Lines(self._process.stderr)
        return self

    def __exit__(self, *_: object) -> None:
        """End every process that is left."""
        self._find_nodes()
        for side in self._sides:
            side.close()
        self._process.kill()
        for process in self._nodes.values():
            with suppress(psutil.NoSuchProcess):
                process.kill()
        self._process.wait()
        self.output.join()
        self.errors.join()

    def _limit(self) -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (self._largest, self._largest))

    @property
    def bag(self) -> Path:
        """Folder of the bag."""
        return self.out / "bag"

    def log(self, node: str) -> str:
        """Return the log of a node so far."""
        with suppress(OSError):
            return (self.out / "logs" / f"{node}.log").read_text(errors="replace")
        return ""

    # What it is made of.

    def _find_nodes(self) -> dict[str, psutil.Process]:
        with suppress(psutil.NoSuchProcess):
            for child in psutil.Process(self._process.pid).children():
                with suppress(psutil.Error):
                    words = [w for w in child.cmdline() if w.startswith(_MODULE)]
                    if words:
                        self._nodes[words[0].removeprefix(_MODULE)] = child
        return self._nodes

    def node(self, name: str) -> psutil.Process:
        """Return the process of a node."""
        self.until(lambda: name in self._find_nodes(), f"process of {name}")
        return self._nodes[name]

    def running(self) -> list[str]:
        """Return the names of the processes that run: nodes, and ``launcher``."""
        names = [n for n, p in self._nodes.items() if p.is_running() and p.status() != "zombie"]
        return [*names, *(["launcher"] if self._process.poll() is None else [])]

    @property
    def pid(self) -> int:
        """Process id of the launcher."""
        return self._process.pid

    # What is done to it.

    @property
    def domain_id(self) -> int:
        """ROS domain; waits until it is told."""
        self.until(lambda: self.errors.first("ROS_DOMAIN_ID="), "a domain")
        line = self.errors.first("ROS_DOMAIN_ID=")
        found = re.search(r"ROS_DOMAIN_ID=(\d+)", line.text if line else "")
        if found is None:
            raise Late(f"no domain: {self.errors.text[-400:]}")
        return int(found[1])

    def beside(self, **job: Any) -> Side:
        """Start a process beside the flight, in its domain."""
        domain_id = self.domain_id
        key = self._key()
        side = Side({"domain_id": domain_id, "key": key, **job}, self._environment)
        self._sides.append(side)
        return side

    def _key(self) -> str:
        """Return the key of the flight, by which what its nodes tell is known as theirs."""
        try:
            return self.node("plant").environ().get(KEY, "").removeprefix(OFF)
        except psutil.Error:
            return ""

    def observe(self) -> Side:
        """Start a process that only listens to how the flight goes."""
        self.watch = self.beside(act="watch")
        return self.watch

    def progress(self) -> dict[str, Any]:
        """Return what the plant told last: at, step, elapsed, missed, rejected."""
        told = self.watch.said("progress") if self.watch else []
        return told[-1] if told else {"at": 0.0, "step": -1, "missed": 0, "rejected": 0}

    def wait_step(self, step: int) -> None:
        """Wait until a step was told."""
        self.until(lambda: self.progress()["step"] >= step, f"step {step}")

    def until(
        self, done: Callable[[], Any], what: str, patience: float = PATIENCE, *, alive: bool = True
    ) -> None:
        """Wait for something.

        Raises
        ------
        Late
            If it does not come in time, or the launcher ends before.
        """
        deadline = time.monotonic() + patience
        while not done():
            if alive and self._process.poll() is not None:
                raise Late(f"{what}: the launch ended before it: {self.errors.text[-400:]}")
            if time.monotonic() > deadline:
                raise Late(f"{what}: not within {patience:g} s: {self.errors.text[-400:]}")
            time.sleep(_TICK)

    def interrupt(self) -> None:
        """Ask it to end, as Ctrl-C does."""
        self._process.send_signal(signal.SIGINT)

    def wait_end(self, patience: float = PATIENCE) -> int:
        """Wait for its end; return the exit code."""
        self.until(lambda: self._process.poll() is not None, "the end", patience, alive=False)
        self.output.join()
        self.errors.join()
        return self._process.returncode
