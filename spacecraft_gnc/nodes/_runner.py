"""Process of a node: start, spin, clean end on a signal, error report.

Exit codes: 0 the work is done or the node was told to end (SIGINT, SIGTERM, or a launcher that
went away), 1 it could not go on, 2 its parameters were refused.
"""

from __future__ import annotations

import atexit
import faulthandler
import gc
import os
import select
import signal
import sys
import time
import traceback
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import rclpy
from rclpy.exceptions import InvalidHandle
from rclpy.executors import Executor
from rclpy.experimental import EventsExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from rclpy.utilities import remove_ros_args

from spacecraft_gnc.errors import GncError, LaunchError, ScenarioError
from spacecraft_gnc.launcher.environment import LOG, SUPERVISED, TELL_WHERE, prepare
from spacecraft_gnc.nodes._deadline import end_within
from spacecraft_gnc.nodes._exchange import Exchange
from spacecraft_gnc.nodes._node import GncNode
from spacecraft_gnc.ros.parameters import command_line, given_parameters

_SPIN = 0.1  # [s] wall: how late a signal may be noticed
_BURST = 0.002  # [s] wall: how long messages are handed over before the executor has its turn
_RCLError = rclpy_implementation.RCLError  # has no public name
_FAREWELL = 2.0  # [s] wall: granted to DDS at the end of a process; less than a launcher grants
_TELL_WHERE_AFTER = 1.8  # [s] wall of these
_DRAIN_ROUNDS = 50  # looks at an empty queue before it counts as empty
_AUTOSTART = "autostart"


def run(*node_types: Callable[[], GncNode], arguments: Sequence[str] | None = None) -> int:
    """Run nodes in one process and one executor until all are told to end, or one has finished.

    Parameters
    ----------
    node_types
        Classes of nodes, or what makes one, in the order in which they start; they end in reverse.
    arguments
        Command line; by default that of the process.

    Returns
    -------
    int
        Exit code.
    """
    ending = _Ending() if os.environ.get(SUPERVISED) == "1" else None
    code = _run(node_types, list(sys.argv if arguments is None else arguments))
    if ending is not None:
        ending.code = code
    # Nodes are made of cycles, and what DDS has of them lives until these are collected. Left to
    # the end of the interpreter, its threads can meet a Python half gone and keep the process.
    gc.collect()
    return code


def _run(node_types: Sequence[Callable[[], GncNode]], argv: list[str]) -> int:
    stop = _StopRequest()
    nodes: list[GncNode] = []
    executor: Executor | None = None
    code = 1
    try:
        _check_arguments(argv)
        prepare(os.environ)
        gc.freeze()  # what was imported stays: the collection at the end is short on a busy machine
        rclpy.init(args=argv, signal_handler_options=SignalHandlerOptions.NO)
        executor = EventsExecutor()
        exchange = Exchange() if len(node_types) > 1 else None
        for node_type in node_types:
            nodes.append(node_type())
            nodes[-1].exchange = exchange
            executor.add_node(nodes[-1])
        loop = Loop(executor, nodes, exchange)
        try:
            _start(nodes)
            while not stop and not any(node.finished for node in nodes):
                loop.turn(_SPIN)
        finally:
            _end(loop, nodes)
        code = _exit_code(nodes)
    except GncError as error:
        report(error)
        code = error.exit_code
    except Exception:  # noqa: BLE001 - the last resort of a process
        traceback.print_exc()
    finally:
        _leave(executor, nodes, code)
    return code


def _leave(executor: Executor | None, nodes: Sequence[GncNode], code: int) -> None:
    """Give back what the nodes had; the process ends anyway, and its exit code is settled.

    It ends in time too: while a peer leaves, Fast DDS 2.14 can spin for ever where it destroys a
    participant (eProsima/Fast-DDS#6513), and Python waits for it. Before it is cut short it says
    where it hangs.
    """
    _flush()
    faulthandler.dump_traceback_later(_TELL_WHERE_AFTER)
    end_within(_FAREWELL, code)
    if executor is not None:
        with suppress(Exception):
            executor.shutdown()  # else it holds the ends of all nodes
    for node in nodes:
        with suppress(Exception):
            node.destroy_node()
    rclpy.try_shutdown()


def _flush() -> None:
    for stream in (sys.stdout, sys.stderr):
        with suppress(Exception):  # a log on a full disk
            stream.flush()


def report(error: Exception) -> None:
    """Print an error as the command line does: one line for each problem."""
    with suppress(OSError):
        for line in str(error).splitlines():
            print(f"error: {line}", file=sys.stderr, flush=True)


class _Ending:
    """The end of a process that a launcher started: it hangs in no place that it cannot tell.

    `faulthandler` falls silent when the interpreter is taken down, and whoever hangs after that, as
    a thread of DDS can, is killed by the signal that asks for its stacks, without a word. So the
    last of the functions that run at exit, which is the first to be registered, leaves at once.
    """

    def __init__(self) -> None:
        self.code = 1
        faulthandler.register(TELL_WHERE)
        atexit.register(self._leave)

    def _leave(self) -> None:
        _flush()
        os._exit(self.code)


class _StopRequest:
    """Whether a signal, or the end of a supervising launcher, asks this process to end."""

    def __init__(self) -> None:
        self._asked = False
        self._supervised = os.environ.get(SUPERVISED) == "1"
        self._next_look = 0.0
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._ask)

    def _ask(self, *_: Any) -> None:
        self._asked = True

    def __bool__(self) -> bool:
        if self._supervised and time.monotonic() >= self._next_look:
            self._next_look = time.monotonic() + _SPIN
            readable, _, _ = select.select([0], [], [], 0.0)
            if readable and os.read(0, 1) == b"":
                self._supervised = False
                self._asked = True
                _write_to_log()
        return self._asked


def _write_to_log() -> None:
    """Write to the log from here on: nobody reads the pipe of a launcher that has gone."""
    if LOG not in os.environ:
        return
    for path in (os.environ[LOG], os.devnull):
        with suppress(OSError):  # the folder was deleted
            log = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT)
            os.dup2(log, 1)
            os.dup2(log, 2)
            return


def _check_arguments(argv: Sequence[str]) -> None:
    """Refuse what ROS 2 would refuse without saying where and why."""
    command_line(argv)
    name = Path(argv[0]).name
    remedy = f"write {name} --ros-args --params-file config/SCENARIO.yaml"
    try:
        surplus = remove_ros_args(list(argv))[1:]
    except RuntimeError as error:  # the binding has several kinds, none of them public
        reason = " ".join(str(error).split())
        raise ScenarioError(
            f"{name}: received ROS 2 arguments that cannot be parsed ({reason}); required "
            f"well-formed ones; {remedy}"
        ) from error
    for argument in surplus:
        raise ScenarioError(
            f"{name}: received {argument!r}; required ROS 2 arguments only; {remedy}"
        )


def _start(nodes: Sequence[GncNode]) -> None:
    """Configure and activate the nodes that have no launcher to do so."""
    for node in nodes:
        if not given_parameters(node).get(_AUTOSTART, True):
            continue
        node.runner_reports = True
        for transition in (node.trigger_configure, node.trigger_activate):
            if transition() != TransitionCallbackReturn.SUCCESS:
                raise node.failure or LaunchError(f"{node.ROLE}: refused to start; see its log")
        node.runner_reports = False


class Loop:
    """Handles what comes to the nodes of a process.

    Parameters
    ----------
    executor
        Of the nodes.
    nodes
        In the order in which they start.
    exchange
        Between the nodes; None: there is one node.
    """

    def __init__(
        self, executor: Executor, nodes: Sequence[GncNode], exchange: Exchange | None
    ) -> None:
        self._executor = executor
        self._nodes = tuple(nodes)
        self._exchange = exchange
        self._gathers = nodes[0].GATHERS if exchange is None else 0.0

    def turn(self, timeout: float) -> None:
        """Hand messages over for a moment, then handle one event of ROS, if one comes in time.

        A node that lets messages gather handles after this event all that have gathered.

        A callback takes care of what its message or request leads to; here ends what cannot even
        be taken. An executor does not tell whose it was, so the first node refuses it for all.
        """
        try:
            if self._exchange is not None and self._hand_over(self._exchange):
                timeout = 0.0
            self._executor.spin_once(timeout_sec=timeout)
            if self._gathers and timeout and self._nodes[0].active:
                time.sleep(self._gathers)
                # Handles everything that is there, and waits for nothing.
                self._executor.spin_until_future_complete(Future(), 0.0)
        except InvalidHandle:
            pass  # an event of an endpoint that was destroyed meanwhile: nobody waits for it
        except _RCLError as error:
            self._nodes[0].refuse("ROS 2", str(error))

    def _hand_over(self, exchange: Exchange) -> bool:
        """Hand messages over until none waits or a node has finished; return whether some wait."""
        until = time.monotonic() + _BURST
        while exchange.deliver() and time.monotonic() < until:
            for node in self._nodes:
                if node.finished:
                    return True
        return bool(exchange)

    def drain(self, node: GncNode) -> None:
        """Let a node handle what has reached it before it ends."""
        handled = -1
        while handled != node.progress():
            handled = node.progress()
            for _ in range(_DRAIN_ROUNDS):
                self.turn(0.0)


def _end(loop: Loop, nodes: Sequence[GncNode]) -> None:
    """Shut the nodes down, last first, so that the recorder receives the last messages of all."""
    for node in reversed(nodes):
        if node.active:
            loop.drain(node)
            node.trigger_deactivate()
            loop.drain(nodes[0])
    for node in reversed(nodes):
        node.trigger_shutdown()


def _exit_code(nodes: Sequence[GncNode]) -> int:
    failures = [node.failure for node in nodes if node.failure is not None]
    for failure in failures:
        report(failure)
    return max((getattr(failure, "exit_code", 1) for failure in failures), default=0)
