"""Nodes that die or stop, and a machine that breaks under a flight."""

from __future__ import annotations

import os
import random
import shutil
import subprocess
import sys
import time
from argparse import Namespace
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from hostile_checks import differing, last_step, recovered, traces
from hostile_clock import NoCompiler, SetBack
from hostile_flight import NODES, Flight, Late, Row
from hostile_wire import FREE_RUN

from spacecraft_gnc.errors import GncError

_EARLY, _LATE = 50, 400  # steps between which a node is killed, in lockstep
_LOSSY: Final = 2.5  # [s] wall at least before a recorder is killed: something is older than 1 s
_NAMED_WITHIN: Final = 1.0  # [s] wall
_LOST_WITHIN: Final = 1.0  # [s] wall
_STOPPED_AT: Final = 200  # steps
_STEPS: Final = 3_000
_LOOPS: Final = 4
_PATIENCE: Final = 600.0  # [s] wall for a flight on a busy machine
_LARGEST: Final = 3 << 20  # [bytes] of a disk, or of a file


class Kill(NamedTuple):
    """What came of a killed node."""

    named_after: float
    """[s] wall; infinite: never."""
    lost: float
    """[s] wall of the recording that is lost, before the kill; NaN: unknown."""
    bag: str
    """whole | recovered | none"""
    problem: str


def kills(options: Namespace) -> Iterator[Row]:
    """Kill each node in both modes, and the recorder again and again."""
    chance = random.Random(options.seed)  # noqa: S311
    modes = {"lockstep": (), "free run": tuple(c.format(options.factor) for c in FREE_RUN)}
    if options.short:
        del modes["free run"]
    nodes = ("nmpc_controller",) if options.short else NODES
    for mode, changes in modes.items():
        for node in nodes:
            found = [_kill(options, node, chance, *changes) for _ in range(options.kills)]
            yield _row_of_kills(f"kill {node}, {mode}", found)
    if options.recorder_kills:
        number = range(options.recorder_kills)
        yield _row_of_losses([_kill(options, "recorder", chance, lossy=True) for _ in number])
    if not options.short:
        yield _next_launch(options)


def _kill(
    options: Namespace, node: str, chance: random.Random, *changes: str, lossy: bool = False
) -> Kill:
    out = options.folder / f"kill-{len(list(options.folder.iterdir()))}"
    problem, code, bag, named_after, lost = "", None, "none", np.inf, np.nan
    with Flight(out, *changes) as flight:
        try:
            flight.observe()
            flight.wait_step(chance.randrange(_EARLY, _LATE) // (4 if changes else 1))
            if lossy:
                wait = chance.uniform(_LOSSY, 2.0 * _LOSSY)
                begun = flight.progress()["at"] - flight.progress()["elapsed"]
                flight.until(lambda: time.monotonic() > begun + wait, "its time")
            process = flight.node(node)
            killed = time.monotonic()
            process.kill()
            code = flight.wait_end()
        except Late as error:
            return Kill(np.inf, np.nan, bag, str(error))
        line = flight.errors.first(node, killed)
        named_after = line.at - killed if line else np.inf
        defects = traces(flight)
        if code != 1 or defects:
            problem = f"exit code {code}, {defects}: {flight.errors.text[-200:]}"
        told = flight.watch.said("progress") if flight.watch else []
    try:
        readable, bag = recovered(flight.bag)
        lost = killed - _time_of(last_step(readable), told)
    except GncError as error:
        problem = problem or str(error)
    shutil.rmtree(out, ignore_errors=True)
    shutil.rmtree(out.with_name(out.name + "-recovered"), ignore_errors=True)
    return Kill(named_after, lost, bag, problem)


def _time_of(step: int, told: list[dict[str, Any]]) -> float:
    """Return the wall time at which the plant came to a step, between what it told [s]."""
    return float(np.interp(step, [t["step"] for t in told], [t["at"] for t in told]))


def _row_of_kills(name: str, found: list[Kill]) -> Row:
    problems = [kill.problem for kill in found if kill.problem]
    longest = max(kill.named_after for kill in found)
    bags = ", ".join(
        f"{[k.bag for k in found].count(b)} {b}" for b in sorted({k.bag for k in found})
    )
    return Row(
        name,
        "SIGKILL at a random step",
        len(found),
        f"named on stderr within {_NAMED_WITHIN:g} s; exit code 1; bag whole or recovered",
        f"named within {longest:.2f} s; bags: {bags}" + "".join(f"; {p}" for p in problems[:1]),
        not problems and longest <= _NAMED_WITHIN and "none" not in bags,
    )


def _row_of_losses(found: list[Kill]) -> Row:
    lost = np.array([kill.lost for kill in found])
    problems = [kill.problem for kill in found if kill.problem]
    return Row(
        "kill recorder, its loss",
        "SIGKILL of the recorder after 2.5 to 5 s of flight",
        len(found),
        f"less than {_LOST_WITHIN:g} s of the recording lost",
        f"{np.median(lost):.2f} s median, {np.max(lost):.2f} s most"
        + "".join(f"; {p}" for p in problems[:1]),
        not problems and bool(np.max(lost) < _LOST_WITHIN),
    )


def _next_launch(options: Namespace) -> Row:
    with Flight(options.folder / "next", steps=50) as flight:
        code = flight.wait_end()
    steps, wrong = differing(flight.bag, flight.changes) if code == 0 else (0, ["exit code"])
    told = f"exit code {code}, {steps} steps equal" if not wrong else f"exit code {code}, {wrong}"
    done = "a launch after these, as each of them was after the one before"
    return Row("next launch", done, 1, "equals `gnc simulate`", told, code == 0 and not wrong)


# A machine that breaks.

_Break = Callable[[Flight, Namespace], None]


def stops(options: Namespace) -> Iterator[Row]:
    """Stop nodes, keep the processors busy, take the disk away, set the clock back."""
    for node in NODES:
        yield _broken(options, f"stop {node}", _stop(node), "SIGSTOP, later SIGCONT")
    yield _broken(options, "busy loops", _busy, f"{_LOOPS} processes in endless loops")
    yield _full_disk(options)
    yield _broken(options, "folder deleted", _delete, "rm -r of the run's folder")
    yield _set_back(options)


def _broken(options: Namespace, name: str, act: _Break, done: str, **how: Any) -> Row:
    """Fly, break something, and judge: the same bytes, or an end that says why."""
    out = how.pop("out", options.folder / name.replace(" ", "_"))
    begun = time.monotonic()
    with Flight(out, steps=how.pop("steps", _STEPS), **how) as flight:
        try:
            flight.observe()
            flight.wait_step(_STOPPED_AT)
            act(flight, options)
            code = flight.wait_end(_PATIENCE)
        except Late as error:
            return Row(name, done, 1, _SAME, str(error), False)
        told = flight.errors.text
        defects = traces(flight)
        flown = flight.progress()["step"]
    if code == 0:
        steps, wrong = differing(flight.bag, flight.changes)
        whole = not wrong and steps == flight.steps
        verdict = f"{steps} steps, all bytes equal" if whole else f"exit code 0, but {wrong} differ"
    else:
        errors = [line for line in told.splitlines() if line.startswith("error: ")]
        lines = [line for line in errors if any(n in line for n in (*NODES, out.name))]
        false = [line for line in errors if _STRANGER in line]  # nobody else is there
        whole = bool(lines) and not defects and not false
        shown = (false or lines or errors or ["no error"])[0].strip()
        verdict = f"ended with {code}: {shown[:200]}"
    verdict += f"; defects of {defects}" if defects else ""
    seconds = f" ({flown} steps, {time.monotonic() - begun:.0f} s)"
    return Row(name, done, 1, _SAME, verdict.replace(str(out), out.name) + seconds, whole)


_STRANGER: Final = "none of this flight's nodes"
_SAME: Final = "bytes of `gnc simulate`, or ended by name"


def _stop(node: str) -> _Break:
    def act(flight: Flight, options: Namespace) -> None:
        process = flight.node(node)
        process.suspend()
        try:
            time.sleep(options.stop)
        finally:
            with suppress(Exception):
                process.resume()

    return act


def _busy(flight: Flight, _: Namespace) -> None:
    loops = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(_LOOPS)]
    try:
        flight.wait_end(_PATIENCE)
    finally:
        for loop in loops:
            loop.kill()
            loop.wait()


def _delete(flight: Flight, _: Namespace) -> None:
    shutil.rmtree(flight.out, ignore_errors=True)


def _wait(*_: Any) -> None:
    """Nothing: it happens by itself."""


def _full_disk(options: Namespace) -> Row:
    """Fly into a small file system; where none can be mounted, with a limit of a file's size."""
    disk = options.folder / "disk"
    disk.mkdir()
    with _mounted(disk) as is_mounted:
        if is_mounted:
            return _broken(
                options,
                "disk full",
                _wait,
                f"tmpfs of {_LARGEST} bytes",
                out=disk / "run",
                steps=100_000,
            )
    done = f"no file above {_LARGEST} bytes (RLIMIT_FSIZE)"
    return _broken(options, "disk full", _wait, done, steps=100_000, largest=_LARGEST)


@contextmanager
def _mounted(folder: Path) -> Iterator[bool]:
    command = ["mount", "-t", "tmpfs", "-o", f"size={_LARGEST}", "tmpfs", str(folder)]
    mounted = (
        os.geteuid() == 0
        and not subprocess.run(command, capture_output=True, check=False).returncode
    )
    try:
        yield mounted
    finally:
        if mounted:
            _succeeds(["umount", "-l", str(folder)])


def _succeeds(command: list[str]) -> bool:
    return subprocess.run(command, capture_output=True, check=False).returncode == 0


def _set_back(options: Namespace) -> Row:
    """Set the wall clock back an hour, as the processes of the flight see it."""
    try:
        clock = SetBack(options.folder)
    except NoCompiler as error:
        return Row("clock set back", "", 0, _SAME, str(error), None)
    done = "wall clock back an hour, as all processes of the flight see it"
    return _broken(
        options, "clock set back", lambda *_: clock.set_back(), done, environment=clock.environment
    )
